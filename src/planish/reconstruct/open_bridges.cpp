#include "planish/reconstruct/open_bridges.h"

#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/triangle_edges.h"

namespace planish {
namespace {

// Times the least circumradius at any of a triangle's corners. The least is a measure of the
// spacing that long thin triangles beside do not disturb, be the points random (5 at most in
// 100,000), noisy, in lines far apart, or ten times denser on one side.
constexpr double kBridgingRadii = 10;
constexpr double kOpenRim = 0.2;

double squared_circumradius(std::span<const glm::dvec3> positions, const Triangle& t) {
  const glm::dvec3 ab = positions[t[1]] - positions[t[0]], bc = positions[t[2]] - positions[t[1]],
                   ca = positions[t[0]] - positions[t[2]], cross = glm::cross(ab, ca);
  const double area = glm::dot(cross, cross);  // four times its square
  if (area == 0) return std::numeric_limits<double>::infinity();
  return glm::dot(ab, ab) * glm::dot(bc, bc) * (glm::dot(ca, ca) / (4 * area));
}

}  // namespace

std::vector<std::uint8_t> open_bridges(std::span<const glm::dvec3> positions,
                                       std::span<const Triangle> triangles) {
  std::vector<double> radii, least(positions.size(), std::numeric_limits<double>::infinity());
  radii.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    radii.push_back(squared_circumradius(positions, t));
    for (const std::int32_t corner : t) least[corner] = std::min(least[corner], radii.back());
  }
  std::vector<std::uint8_t> marked;
  marked.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [a, b, c] = triangles[t];
    marked.push_back(radii[t] >
                     kBridgingRadii * kBridgingRadii * std::max({least[a], least[b], least[c]}));
  }
  if (std::ranges::find(marked, 1) == marked.end()) return marked;
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  DisjointSets patches(triangles.size());  // of marked triangles, or of others
  for (std::size_t h = 0; h < twins.size(); ++h)
    if (twins[h] >= 0 && marked[h / 3] == marked[twins[h] / 3])
      patches.unite(static_cast<std::int32_t>(h / 3), twins[h] / 3);
  struct Rim {
    double open = 0, all = 0;
    std::int32_t beyond = -1;
    bool joins = false;          // two parts
    bool holds_a_scrap = false;  // by what it joins
  };
  std::vector<Rim> rims(triangles.size());
  std::vector<std::int64_t> sizes(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    sizes[patches.find(static_cast<std::int32_t>(t))] += !marked[t];
  const std::int64_t fewest = least_part(std::ranges::max(sizes));
  for (std::size_t h = 0; h < twins.size(); ++h) {
    const std::int32_t beyond = twins[h] < 0 ? -1 : twins[h] / 3;
    if (!marked[h / 3] || (beyond >= 0 && marked[beyond])) continue;
    const Triangle& t = triangles[h / 3];
    const double length = glm::distance(positions[t[h % 3]], positions[t[(h + 1) % 3]]);
    Rim& rim = rims[patches.find(static_cast<std::int32_t>(h / 3))];
    rim.all += length;
    if (beyond < 0) {
      rim.open += length;
    } else {
      const std::int32_t part = patches.find(beyond);
      rim.joins |= rim.beyond >= 0 && rim.beyond != part;
      rim.beyond = part;
      rim.holds_a_scrap |= sizes[part] < fewest;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Rim& rim = rims[patches.find(static_cast<std::int32_t>(t))];
    marked[t] = marked[t] && !(rim.joins && rim.holds_a_scrap) && rim.open >= kOpenRim * rim.all;
  }
  return marked;
}

}  // namespace planish
