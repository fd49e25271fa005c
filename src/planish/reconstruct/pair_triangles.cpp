#include "planish/reconstruct/pair_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "planish/reconstruct/triangle_edges.h"

namespace planish {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

struct Pair {
  double badness;  // largest deviation of a corner from a right angle
  std::int32_t half_edge, twin;
};

// a, d, b, c for the edge a b with the opposite corners c and d.
std::array<std::int32_t, 4> quad_of(std::span<const Triangle> triangles, std::int32_t half_edge,
                                    std::int32_t twin) {
  const auto start = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  return {start(half_edge), start(previous_half_edge(twin)), start(twin),
          start(previous_half_edge(half_edge))};
}

std::optional<double> badness_of(std::span<const glm::dvec3> positions,
                                 const std::array<std::int32_t, 4>& quad,
                                 const PairOptions& options) {
  const auto place = [&](std::size_t i) { return positions[quad[i % 4]]; };
  const glm::dvec3 n0 = glm::cross(place(1) - place(0), place(2) - place(0));
  const glm::dvec3 n1 = glm::cross(place(2) - place(0), place(3) - place(0));
  const double lengths = glm::length(n0) * glm::length(n1);
  if (!(lengths > 0) || glm::dot(n0, n1) < lengths * std::cos(options.largest_turn * kRadians))
    return std::nullopt;
  const glm::dvec3 normal = n0 + n1;
  double worst = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 ahead = place(i + 1) - place(i), back = place(i + 3) - place(i);
    const glm::dvec3 cross = glm::cross(ahead, back);
    if (!(glm::dot(cross, normal) > 0)) return std::nullopt;
    const double angle = std::atan2(glm::length(cross), glm::dot(ahead, back));
    if (angle > options.largest_angle * kRadians) return std::nullopt;
    worst = std::max(worst, std::abs(angle - std::numbers::pi / 2));
  }
  return worst;
}

}  // namespace

PolygonMesh pair_triangles(std::span<const glm::dvec3> positions,
                           std::span<const Triangle> triangles, const PairOptions& options) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  std::vector<Pair> pairs;
  for (std::size_t h = 0; h < twins.size(); ++h) {
    const auto half_edge = static_cast<std::int32_t>(h);
    if (twins[h] < half_edge) continue;
    const auto badness = badness_of(positions, quad_of(triangles, half_edge, twins[h]), options);
    if (badness) pairs.push_back({*badness, half_edge, twins[h]});
  }
  std::ranges::sort(pairs, [](const Pair& a, const Pair& b) {
    return a.badness < b.badness || (a.badness == b.badness && a.half_edge < b.half_edge);
  });
  // Where a triangle's quad begins; -1: none, -2: it belongs to an earlier triangle's.
  std::vector<std::int32_t> partners(triangles.size(), -1);
  for (const Pair& pair : pairs) {
    const std::int32_t first = pair.half_edge / 3, second = pair.twin / 3;
    if (partners[first] != -1 || partners[second] != -1) continue;
    partners[std::min(first, second)] = first < second ? pair.half_edge : pair.twin;
    partners[std::max(first, second)] = -2;
  }
  PolygonMesh mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (partners[t] == -2) continue;
    if (partners[t] == -1) {
      mesh.add_face(triangles[t]);
    } else {
      mesh.add_face(quad_of(triangles, partners[t], twins[partners[t]]));
    }
  }
  return mesh;
}

}  // namespace planish
