#include "planish/refine/spacing_metric.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "planish/core/parallel.h"

namespace planish {
namespace {

// Rings of few edges are uneven by chance: only what is narrower is narrow.
constexpr double kByChance = 1.5;
constexpr double kNarrowest = 4;
constexpr double kMostAcross = 0.25;

// A symmetric 2 x 2 matrix by its axes.
struct Axes {
  glm::dvec2 first, second;  // unit, at right angles
  double of_first, of_second;
};

Axes axes_of(double xx, double xy, double yy) {
  const double middle = (xx + yy) / 2, half = (xx - yy) / 2, reach = std::hypot(half, xy);
  glm::dvec2 first(1, 0);
  if (reach > 0) {
    // The longer of two equal directions.
    first = half >= 0 ? glm::dvec2(half + reach, xy) : glm::dvec2(xy, reach - half);
    first = glm::normalize(first);
  }
  return {first, glm::dvec2(-first.y, first.x), middle + reach, middle - reach};
}

struct Ring {
  glm::dmat3 tensor{0.0};  // mean of e e^T over the edges
  glm::dvec3 normal{0.0};
  double length = 0;  // mean
};

std::vector<Ring> rings_of(std::span<const glm::dvec3> positions, const MeshTopology& topology) {
  std::vector<Ring> rings(positions.size());
  parallel_each(rings.size(), 256, [&](std::size_t v) {
    Ring& ring = rings[v];
    double count = 0;
    for (const std::int32_t corner : topology.corners_at(static_cast<std::int32_t>(v))) {
      const glm::dvec3 a = positions[topology.vertex_of(topology.next(corner))] - positions[v];
      const glm::dvec3 b = positions[topology.vertex_of(topology.prev(corner))] - positions[v];
      ring.normal += glm::cross(a, b);
      for (const glm::dvec3& edge : {a, b}) {
        ring.tensor += glm::outerProduct(edge, edge);
        ring.length += glm::length(edge);
        ++count;
      }
    }
    if (count == 0) return;
    ring.tensor /= count;
    ring.length /= count;
  });
  return rings;
}

}  // namespace

std::vector<glm::dmat3> spacing_metrics(std::span<const glm::dvec3> positions,
                                        const MeshTopology& topology, const GuessSurface& guess,
                                        const EvenTrianglesOptions& options) {
  const std::vector<Ring> rings = rings_of(positions, topology);
  std::vector<glm::dmat3> metrics(positions.size(), glm::dmat3(0));
  parallel_each(metrics.size(), 64, [&](std::size_t v) {
    const Ring& ring = rings[v];
    const auto vertex = static_cast<std::int32_t>(v);
    if (!(ring.length > 0)) return;
    // Single rings are uneven by chance.
    glm::dmat3 tensor = ring.tensor;
    double count = 1;
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      const Ring& other = rings[topology.vertex_of(topology.next(corner))];
      const double length = other.length > 0 ? ring.length / other.length : 0;
      tensor += length * length * other.tensor;
      ++count;
    }
    tensor /= count;
    const double area = glm::length(ring.normal);
    const glm::dvec3 n = area > 0 ? ring.normal / area : glm::dvec3(0, 0, 1);
    const glm::dvec3 u = glm::normalize(
        glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 w = glm::cross(n, u);
    const auto in_plane = [&](const glm::dmat3& of, const glm::dvec3& a, const glm::dvec3& b) {
      return glm::dot(a, of * b);
    };
    const Axes shape =
        axes_of(in_plane(tensor, u, u), in_plane(tensor, u, w), in_plane(tensor, w, w));
    // Edges that leave the plane, as beside a spike, tell nothing of how triangles lie in it.
    const bool is_plane = glm::dot(n, tensor * n) < kMostAcross * shape.of_second;
    const double ratio = is_plane ? std::sqrt(shape.of_first / shape.of_second) : 1;
    const double narrow = std::sqrt(std::clamp(ratio / kByChance, 1.0, kNarrowest));
    // Of the mean edge's length as a whole, along and across: an area that stays.
    const double mean = ring.length * std::sqrt(2 / (narrow * narrow + 1 / (narrow * narrow)));
    // Ways of one mean edge.
    const glm::dvec3 along = mean * narrow * (shape.first.x * u + shape.first.y * w);
    const glm::dvec3 across = mean / narrow * (shape.second.x * u + shape.second.y * w);
    const glm::dmat3 turning = guess.turning(vertex);
    const double turn = glm::radians(options.turn);
    const Axes bend = axes_of(in_plane(turning, along, along), in_plane(turning, along, across),
                              in_plane(turning, across, across));
    // How many edges should take the place of a mean one.
    const auto parts = [&](double square) {
      return std::clamp(std::sqrt(std::max(square, 0.0)) / turn, 1 / options.spacing,
                        1 / options.least_spacing);
    };
    const glm::dvec3 dual_along = along / glm::dot(along, along),
                     dual_across = across / glm::dot(across, across);
    const auto direction = [&](const glm::dvec2& axis) {
      return axis.x * dual_along + axis.y * dual_across;
    };
    const double first = parts(bend.of_first);
    const double second = is_plane ? parts(bend.of_second) : first;
    const glm::dvec3 a = first * direction(bend.first), b = second * direction(bend.second);
    metrics[v] = glm::outerProduct(a, a) + glm::outerProduct(b, b);
    const double trace = metrics[v][0][0] + metrics[v][1][1] + metrics[v][2][2];
    metrics[v] += trace / 2 * glm::outerProduct(n, n);
  });
  return metrics;
}

}  // namespace planish
