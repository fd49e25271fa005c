#include "planish/refine/vertex_jets.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr int kQuadric = 5, kCubic = 9;
// Directions that the places leave open, relative to the best known one, are left at 0.
constexpr double kRidge = 1e-8;
// Tangent of half the angle by which faces turn at most where they sample a smooth surface.
constexpr double kSteepest = 0.577;
constexpr int kTurns = 3;
// Places behind 60 degrees of a ball say little of the surface here.
constexpr double kMostStretched = 2;
// Share of the fit at a place that others decide, at least.
constexpr double kLeastOthers = 0.05;
constexpr int kStretchRounds = 4;
// Corners that are looked at beside a neighbour's, each way: linear time at hubs.
constexpr int kWalk = 16;

using Coefficients = std::array<double, kCubic>;

// A^T A + ridge, of which the upper half is given, as U^T D^-1 U with D on U's diagonal.
class Normal {
 public:
  Normal(const std::array<Coefficients, kCubic>& matrix, int first, int last)
      : matrix_(matrix), first_(first), last_(last) {
    double trace = 0;
    for (int i = first; i < last; ++i) trace += matrix_[i][i];
    for (int i = first; i < last; ++i) matrix_[i][i] += kRidge * trace + 1e-300;
    for (int k = first; k < last; ++k)
      for (int i = k + 1; i < last; ++i) {
        const double factor = matrix_[k][i] / matrix_[k][k];
        for (int j = i; j < last; ++j) matrix_[i][j] -= factor * matrix_[k][j];
      }
  }

  // Of A^T z.
  [[nodiscard]] Coefficients solve(Coefficients right) const {
    reduce(right);
    for (int i = last_ - 1; i >= first_; --i) {
      for (int j = i + 1; j < last_; ++j) right[i] -= matrix_[i][j] * right[j];
      right[i] /= matrix_[i][i];
    }
    return right;
  }
  // row (A^T A)^-1 row^T
  [[nodiscard]] double leverage(Coefficients row) const {
    reduce(row);
    double sum = 0;
    for (int i = first_; i < last_; ++i) sum += row[i] * row[i] / matrix_[i][i];
    return sum;
  }

 private:
  void reduce(Coefficients& right) const {
    for (int k = first_; k < last_; ++k)
      for (int i = k + 1; i < last_; ++i) right[i] -= matrix_[k][i] / matrix_[k][k] * right[k];
  }

  std::array<Coefficients, kCubic> matrix_;
  int first_, last_;
};

void set_axes(VertexJet& jet) {
  const glm::dvec3 n = jet.normal;
  jet.e1 = glm::normalize(
      glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  jet.e2 = glm::cross(n, jet.e1);
}

class JetFitter {
 public:
  JetFitter(std::span<const glm::dvec3> positions, const MeshTopology& topology,
            std::span<const char> is_sharp)
      : positions_(positions), topology_(topology), is_sharp_(is_sharp) {}

  // `sector`: corners at a vertex, counter-clockwise.
  [[nodiscard]] VertexJet fit(std::span<const std::int32_t> sector) const {
    const std::int32_t vertex = topology_.vertex_of(sector.front());
    VertexJet jet{};
    jet.origin = positions_[vertex];
    double size = 0;
    int edges = 0;
    for (const std::int32_t corner : sector) {
      const glm::dvec3 a = positions_[topology_.vertex_of(topology_.next(corner))] - jet.origin;
      const glm::dvec3 b = positions_[topology_.vertex_of(topology_.prev(corner))] - jet.origin;
      const glm::dvec3 cross = glm::cross(a, b);
      const double length = glm::length(cross);
      if (length > 0) jet.normal += cross / length * angle_between(a, b);
      size += glm::length(a) + glm::length(b);
      edges += 2;
    }
    size /= edges;
    const double length = glm::length(jet.normal);
    jet.normal = length > 0 ? jet.normal / length : glm::dvec3(0, 0, 1);
    set_axes(jet);
    if (!(size > 0)) return jet;
    const std::vector<std::int32_t> ring = two_rings(sector, vertex);
    const glm::dvec3 by_angle = jet.normal;
    std::vector<Place> places = places_over(jet, ring, size);
    const double untilted = least_squares(places, {2, kQuadric}).left;
    for (int turn = 0; turn < kTurns; ++turn) {
      const Coefficients s = best_of(places, 0).coefficients;
      jet.normal = glm::normalize(jet.normal - s[0] * jet.e1 - s[1] * jet.e2);
      set_axes(jet);
      places = places_over(jet, ring, size);
    }
    const double tilted = best_of(places, 0).left;
    const double tilt = believed(tilted, untilted);
    jet.normal = glm::normalize(tilt * jet.normal + (1 - tilt) * by_angle);
    set_axes(jet);
    places = places_over(jet, ring, size);
    const LeastSquares fit = best_of(places, 2);
    const Coefficients& s = fit.coefficients;
    const double share = believed(fit.left, least_squares(places, {0, 2}).left);
    jet.doubt = 1 - share;
    for (int i = 0; i < 3; ++i) jet.quadric[i] = share * s[2 + i] / size;
    for (int i = 0; i < 4; ++i) jet.cubic[i] = share * s[5 + i] / (size * size);
    return jet;
  }

 private:
  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;

  [[nodiscard]] std::int32_t across(std::int32_t corner, bool ccw) const {
    const std::int32_t edge = topology_.edge_of(ccw ? topology_.prev(corner) : corner);
    if (is_sharp_[edge]) return -1;
    return ccw ? topology_.ccw(corner) : topology_.cw(corner);
  }

  void add_face(std::int32_t corner, std::int32_t vertex, std::vector<std::int32_t>& ring) const {
    for (const std::int32_t other : topology_.face(topology_.face_of(corner)))
      if (other != vertex) ring.push_back(other);
  }

  [[nodiscard]] std::vector<std::int32_t> two_rings(std::span<const std::int32_t> sector,
                                                    std::int32_t vertex) const {
    std::vector<std::int32_t> ring;
    for (const std::int32_t corner : sector) {
      add_face(corner, vertex, ring);
      for (const std::int32_t start : {topology_.next(corner), topology_.prev(corner)}) {
        for (const bool ccw : {false, true}) {
          std::int32_t at = across(start, ccw);
          for (int step = 0; at >= 0 && at != start && step < kWalk; ++step) {
            add_face(at, vertex, ring);
            at = across(at, ccw);
          }
        }
      }
    }
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // A neighbour, over the jet's plane in units of the mean edge.
  struct Place {
    Coefficients row;
    double height, square;  // of the weight
  };
  // Those coefficients that are not 0, the first two of which tilt.
  struct Unknowns {
    int first, last;
  };

  [[nodiscard]] std::vector<Place> places_over(const VertexJet& jet,
                                               std::span<const std::int32_t> ring,
                                               double size) const {
    std::vector<Place> places;
    places.reserve(ring.size());
    for (const std::int32_t other : ring)
      places.push_back(place_of((positions_[other] - jet.origin) / size, jet));
    return places;
  }

  [[nodiscard]] static Place place_of(const glm::dvec3& to, const VertexJet& jet) {
    const double tilt1 = glm::dot(to, jet.e1), tilt2 = glm::dot(to, jet.e2);
    const double flat = tilt1 * tilt1 + tilt2 * tilt2, square = glm::dot(to, to);
    const double stretch = flat > 0 ? std::min(std::sqrt(square / flat), kMostStretched) : 1;
    const double x = stretch * tilt1, y = stretch * tilt2;
    const double weight = 1 / (1 + square);
    return {{tilt1, tilt2, x * x / 2, x * y, y * y / 2, x * x * x, x * x * y, x * y * y, y * y * y},
            glm::dot(to, jet.normal),
            weight * weight};
  }

  struct LeastSquares {
    Coefficients coefficients{};
    double left = 0;  // what is left of each height by the fit to all others, squares
  };

  [[nodiscard]] static LeastSquares least_squares(std::span<const Place> places,
                                                  Unknowns unknowns) {
    std::array<Coefficients, kCubic> matrix{};
    Coefficients right{};
    for (const auto& [row, height, square] : places) {
      for (int i = unknowns.first; i < unknowns.last; ++i) {
        for (int j = i; j < unknowns.last; ++j) matrix[i][j] += square * row[i] * row[j];
        right[i] += square * row[i] * height;
      }
    }
    const Normal normal(matrix, unknowns.first, unknowns.last);
    LeastSquares fit{normal.solve(right)};
    // So few places are met by any heights.
    const bool is_open = std::ssize(places) <= unknowns.last - unknowns.first;
    for (const auto& [row, height, square] : places) {
      double value = 0;
      for (int i = unknowns.first; i < unknowns.last; ++i) value += fit.coefficients[i] * row[i];
      const double others = 1 - square * normal.leverage(row);
      const double left = is_open ? height : (height - value) / std::max(others, kLeastOthers);
      fit.left += square * left * left;
    }
    return fit;
  }

  // A cubic where it leaves less than a quadric.
  [[nodiscard]] static LeastSquares best_of(std::span<const Place> places, int first) {
    const LeastSquares quadric = least_squares(places, {first, kQuadric});
    const LeastSquares cubic = least_squares(places, {first, kCubic});
    return cubic.left < quadric.left ? cubic : quadric;
  }

  // How far what leaves so much is believed against what leaves more.
  [[nodiscard]] static double believed(double left, double without) {
    return without > 0 ? std::clamp(1 - left / without, 0.0, 1.0) : 0.0;
  }
};

}  // namespace

glm::dvec3 VertexJet::on_jet(const glm::dvec3& place) const {
  const glm::dvec3 to = place - origin;
  const double px = glm::dot(to, e1), py = glm::dot(to, e2);
  const double flat = px * px + py * py, most = kSteepest * std::sqrt(flat);
  double z = 0;
  for (int round = 0; round < kStretchRounds && flat > 0; ++round) {
    const double stretch = std::sqrt(1 + z * z / flat), x = stretch * px, y = stretch * py;
    z = quadric[0] * x * x / 2 + quadric[1] * x * y + quadric[2] * y * y / 2 +
        x * x * (cubic[0] * x + cubic[1] * y) + y * y * (cubic[2] * x + cubic[3] * y);
    z = std::clamp(z, -most, most);
  }
  return place + (z - glm::dot(to, normal)) * normal;
}

VertexJets fit_vertex_jets(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                           std::span<const char> is_sharp) {
  VertexJets result;
  result.jet_of_corner.resize(topology.corner_count());
  // A sector starts behind a sharp edge; of a vertex without one anywhere.
  std::vector<std::int32_t> sector_begin{0}, sector_corners;
  sector_corners.reserve(topology.corner_count());
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    const std::span<const std::int32_t> corners = topology.corners_at(v);
    const std::size_t count = corners.size();
    if (count == 0) continue;
    std::size_t first = 0;
    while (first < count && !is_sharp[topology.edge_of(corners[first])]) ++first;
    if (first == count) first = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t corner = corners[(first + i) % count];
      const bool starts = i > 0 && (is_sharp[topology.edge_of(corner)] || topology.cw(corner) < 0);
      if (starts) sector_begin.push_back(static_cast<std::int32_t>(sector_corners.size()));
      sector_corners.push_back(corner);
      result.jet_of_corner[corner] = static_cast<std::int32_t>(sector_begin.size()) - 1;
    }
    sector_begin.push_back(static_cast<std::int32_t>(sector_corners.size()));
  }
  const JetFitter fitter(positions, topology, is_sharp);
  result.jets.resize(sector_begin.size() - 1);
  parallel_each(result.jets.size(), 256, [&](std::size_t s) {
    const std::size_t begin = sector_begin[s];
    result.jets[s] =
        fitter.fit(std::span(sector_corners).subspan(begin, sector_begin[s + 1] - begin));
  });
  return result;
}

}  // namespace planish
