#include "planish/limit/distance_net.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {
namespace {

// Of a coefficient, and of differences of some: far above what is lost.
constexpr double kCoefficientRounding = 4e-15;

constexpr std::array<double, 3> kQuadratic = {1, 2, 1};  // binomial coefficients
constexpr std::array<double, 5> kQuartic = {1, 4, 6, 4, 1};

}  // namespace

// The product of two Bernstein polynomials: coefficients times binomial coefficients multiply like
// those of powers.
DistanceNet::DistanceNet(const BezierNet& net, const glm::dvec3& point) {
  BezierNet off;
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i)
      off[i + 3 * j] = kQuadratic[i] * kQuadratic[j] * (net[i + 3 * j] - point);
  for (std::size_t a = 0; a < 9; ++a) {
    const std::size_t i = a % 3, j = a / 3;
    values_[2 * i + kSide * 2 * j] += glm::dot(off[a], off[a]);
    for (std::size_t b = a + 1; b < 9; ++b)
      values_[i + b % 3 + kSide * (j + b / 3)] += 2 * glm::dot(off[a], off[b]);
  }
  for (std::size_t j = 0; j < kSide; ++j)
    for (std::size_t i = 0; i < kSide; ++i) values_[i + kSide * j] /= kQuartic[i] * kQuartic[j];
}

std::array<double, 2> DistanceNet::place_of_least() const {
  const auto at = static_cast<std::size_t>(std::ranges::min_element(values_) - values_.begin());
  constexpr double kLast = kSide - 1;
  return {static_cast<double>(at % kSide) / kLast, static_cast<double>(at / kSide) / kLast};
}

double DistanceNet::least_at_corners() const {
  return std::min({values_[0], values_[kSide - 1], values_[kSide * (kSide - 1)], values_.back()});
}

double DistanceNet::rounding() const { return kCoefficientRounding * largest(); }

int DistanceNet::slope(bool along_v) const {
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t k = 0; k < kSide; ++k) {
    for (std::size_t i = 0; i + 1 < kSide; ++i) {
      const double rise = values_[k * across + (i + 1) * step] - values_[k * across + i * step];
      least = std::min(least, rise);
      most = std::max(most, rise);
    }
  }
  if (least > rounding()) return 1;
  return most < -rounding() ? -1 : 0;
}

DistanceNet::Bend DistanceNet::bend(bool along_v) const {
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  Bend bend{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t k = 0; k < kSide; ++k) {
    for (std::size_t i = 0; i + 2 < kSide; ++i) {
      const double* const at = &values_[k * across + i * step];
      const double second = at[0] - 2 * at[step] + at[2 * step];
      bend.least = std::min(bend.least, second);
      bend.most = std::max(bend.most, std::abs(second));
    }
  }
  return bend;
}

bool DistanceNet::is_convex_along(bool along_v) const { return bend(along_v).least > rounding(); }

// The Hessian's diagonal from below and the other entry by magnitude: 12, 12 and 16 times the
// differences.
bool DistanceNet::is_convex() const {
  const double uu = bend(false).least, vv = bend(true).least, lost = rounding();
  if (!(uu > lost) || !(vv > lost)) return false;
  double mixed = 0;
  for (std::size_t j = 0; j + 1 < kSide; ++j) {
    for (std::size_t i = 0; i + 1 < kSide; ++i) {
      const double* const at = &values_[i + kSide * j];
      mixed = std::max(mixed, std::abs(at[kSide + 1] - at[kSide] - at[1] + at[0]));
    }
  }
  return 144 * (uu - lost) * (vv - lost) > 256 * (mixed + lost) * (mixed + lost);
}

bool DistanceNet::bends_more_along_v() const { return bend(true).most > bend(false).most; }

// De Casteljau's midpoints.
DistanceNet DistanceNet::half(bool along_v, bool upper) const {
  DistanceNet result(*this);
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  for (std::size_t k = 0; k < kSide; ++k) {
    double* const line = &result.values_[k * across];
    for (std::size_t round = 1; round < kSide; ++round) {
      for (std::size_t i = 0; i + round < kSide; ++i) {
        // From the end that stays outwards.
        const std::size_t at = upper ? i : kSide - 1 - i;
        double& value = line[at * step];
        value = 0.5 * (value + line[(upper ? at + 1 : at - 1) * step]);
      }
    }
  }
  return result;
}

DistanceNet DistanceNet::border(bool along_v, bool upper) const {
  DistanceNet result(*this);
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  for (std::size_t k = 0; k < kSide; ++k) {
    const double value = values_[k * across + (upper ? kSide - 1 : 0) * step];
    for (std::size_t i = 0; i < kSide; ++i) result.values_[k * across + i * step] = value;
  }
  return result;
}

}  // namespace planish
