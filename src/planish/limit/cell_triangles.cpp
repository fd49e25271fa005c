#include "planish/limit/cell_triangles.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/assert.h"

namespace planish {
namespace {

std::int64_t double_area(const CellPlace& a, const CellPlace& b, const CellPlace& c) {
  const std::int64_t bu = std::int64_t{b.u} - a.u, bv = std::int64_t{b.v} - a.v;
  const std::int64_t cu = std::int64_t{c.u} - a.u, cv = std::int64_t{c.v} - a.v;
  return bu * cv - bv * cu;
}

// Area by the sum of squared sides, 1 for equilateral triangles.
double shape_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, bc = c - b, ca = a - c;
  const double squares = glm::dot(ab, ab) + glm::dot(bc, bc) + glm::dot(ca, ca);
  return squares > 0 ? 2 * std::sqrt(3.0) * glm::length(glm::cross(ab, ca)) / squares : 0;
}

}  // namespace

CellTriangles::Ear CellTriangles::ear_at(std::size_t i) const {
  const std::size_t n = ring_.size();
  const auto a = static_cast<std::size_t>(ring_[(i + n - 1) % n]);
  const auto b = static_cast<std::size_t>(ring_[i]);
  const auto c = static_cast<std::size_t>(ring_[(i + 1) % n]);
  return {double_area(places_[a], places_[b], places_[c]),
          shape_of(positions_[a], positions_[b], positions_[c])};
}

std::span<const std::array<std::int32_t, 3>> CellTriangles::cut(
    std::span<const CellPlace> places, std::span<const glm::dvec3> positions) {
  places_ = places;
  positions_ = positions;
  triangles_.clear();
  ring_.clear();
  std::int64_t rest = 0;  // twice the area that is left
  for (std::size_t i = 0; i < places.size(); ++i) {
    ring_.push_back(static_cast<std::int32_t>(i));
    if (i >= 2) rest += double_area(places[0], places[i - 1], places[i]);
  }
  ears_.resize(ring_.size());
  for (std::size_t i = 0; i < ring_.size(); ++i) ears_[i] = ear_at(i);
  while (ring_.size() > 2) {
    const std::size_t n = ring_.size();
    std::size_t best = n;
    for (std::size_t i = 0; i < n; ++i) {
      // What is left must not be a line.
      if (ears_[i].area <= 0 || (n > 3 && ears_[i].area >= rest)) continue;
      if (best == n || ears_[i].shape > ears_[best].shape + kCutTie) best = i;
    }
    PLANISH_ASSERT(best < n);
    triangles_.push_back({ring_[(best + n - 1) % n], ring_[best], ring_[(best + 1) % n]});
    rest -= ears_[best].area;
    ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(best));
    ears_.erase(ears_.begin() + static_cast<std::ptrdiff_t>(best));
    if (ring_.size() < 3) break;
    const std::size_t m = ring_.size();
    ears_[best % m] = ear_at(best % m);
    ears_[(best + m - 1) % m] = ear_at((best + m - 1) % m);
  }
  return triangles_;
}

}  // namespace planish
