#include "planish/refine/vertex_jets.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr int kQuadric = 5, kCubic = 9;
// Unknowns of a cubic are told from a quadric's by so many places.
constexpr std::size_t kPlacesOfCubic = 14;
// Directions that the places leave open, relative to the best known one, are left at 0.
constexpr double kRidge = 1e-8;
// Tangent of half the angle by which faces turn at most where they sample a smooth surface.
constexpr double kSteepest = 0.577;
constexpr int kTurns = 3;
// Corners that are looked at beside a neighbour's, each way: linear time at hubs.
constexpr int kWalk = 16;

using Coefficients = std::array<double, kCubic>;

// Solves (A^T A + ridge) s = A^T z, of which the upper half is given, in place.
Coefficients solve(std::array<Coefficients, kCubic>& matrix, Coefficients right, int count) {
  double trace = 0;
  for (int i = 0; i < count; ++i) trace += matrix[i][i];
  for (int i = 0; i < count; ++i) matrix[i][i] += kRidge * trace + 1e-300;
  for (int k = 0; k < count; ++k) {
    for (int i = k + 1; i < count; ++i) {
      const double factor = matrix[k][i] / matrix[k][k];
      for (int j = i; j < count; ++j) matrix[i][j] -= factor * matrix[k][j];
      right[i] -= factor * right[k];
    }
  }
  for (int i = count - 1; i >= 0; --i) {
    for (int j = i + 1; j < count; ++j) right[i] -= matrix[i][j] * right[j];
    right[i] /= matrix[i][i];
  }
  return right;
}

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
    for (int turn = 0; turn < kTurns; ++turn) turn_to(jet, ring, size, turn + 1 == kTurns);
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

  void turn_to(VertexJet& jet, std::span<const std::int32_t> ring, double size,
               bool is_last) const {
    const int count = ring.size() >= kPlacesOfCubic ? kCubic : kQuadric;
    std::vector<Place> places;
    places.reserve(ring.size());
    for (const std::int32_t other : ring)
      places.push_back(place_of((positions_[other] - jet.origin) / size, jet));
    const Coefficients s = least_squares(places, count);
    if (!is_last) {
      jet.normal = glm::normalize(jet.normal - s[0] * jet.e1 - s[1] * jet.e2);
      set_axes(jet);
      return;
    }
    const double share = explained(places, s, count);
    for (int i = 0; i < 3; ++i) jet.quadric[i] = share * s[2 + i] / size;
    if (count == kCubic)
      for (int i = 0; i < 4; ++i) jet.cubic[i] = share * s[5 + i] / (size * size);
  }

  // A neighbour, over the jet's plane in units of the mean edge.
  struct Place {
    Coefficients row;
    double height, square;  // of the weight
  };

  [[nodiscard]] static Place place_of(const glm::dvec3& to, const VertexJet& jet) {
    const double x = glm::dot(to, jet.e1), y = glm::dot(to, jet.e2);
    const double weight = 1 / (1 + x * x + y * y);
    return {{x, y, x * x / 2, x * y, y * y / 2, x * x * x, x * x * y, x * y * y, y * y * y},
            glm::dot(to, jet.normal),
            weight * weight};
  }

  [[nodiscard]] static Coefficients least_squares(std::span<const Place> places, int count) {
    std::array<Coefficients, kCubic> matrix{};
    Coefficients right{};
    for (const auto& [row, height, square] : places) {
      for (int i = 0; i < count; ++i) {
        for (int j = i; j < count; ++j) matrix[i][j] += square * row[i] * row[j];
        right[i] += square * row[i] * height;
      }
    }
    return solve(matrix, right, count);
  }

  // The share of the neighbours' heights over their best plane that a jet explains, 0 to 1, less
  // what as many coefficients explain of noise: the adjusted coefficient of determination.
  [[nodiscard]] static double explained(std::span<const Place> places, const Coefficients& jet,
                                        int count) {
    const Coefficients plane = least_squares(places, 2);
    double of_plane = 0, of_jet = 0;
    for (const auto& [row, height, square] : places) {
      double value = 0;
      for (int i = 0; i < count; ++i) value += jet[i] * row[i];
      const double flat = height - plane[0] * row[0] - plane[1] * row[1];
      of_plane += square * flat * flat;
      of_jet += square * (height - value) * (height - value);
    }
    const auto free = [&](int unknowns) {
      return std::max(1.0, static_cast<double>(places.size()) - unknowns);
    };
    if (!(of_plane > 0)) return 0;
    return std::clamp(1 - of_jet / free(count) / (of_plane / free(2)), 0.0, 1.0);
  }
};

}  // namespace

glm::dvec3 VertexJet::on_jet(const glm::dvec3& place) const {
  const glm::dvec3 to = place - origin;
  const double x = glm::dot(to, e1), y = glm::dot(to, e2);
  const double z = quadric[0] * x * x / 2 + quadric[1] * x * y + quadric[2] * y * y / 2 +
                   x * x * (cubic[0] * x + cubic[1] * y) + y * y * (cubic[2] * x + cubic[3] * y);
  const double most = kSteepest * std::hypot(x, y);
  return place + (std::clamp(z, -most, most) - glm::dot(to, normal)) * normal;
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
