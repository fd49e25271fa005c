#include "planish/reconstruct/repair_triangles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <set>
#include <string>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/stop.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/reconstruct/fill_hole.h"
#include "planish/reconstruct/open_bridges.h"

namespace planish {
namespace {

constexpr std::int32_t kLongestLoop = 1000;
// A patch smaller than this many times its own rim is a flap, not a surface with a hole.
constexpr std::int64_t kTrianglesPerRimEdge = 4;

glm::dvec3 cross_of(std::span<const glm::dvec3> positions, const Triangle& t) {
  return glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
}

double perimeter_of(std::span<const glm::dvec3> positions, const Triangle& t) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += glm::distance(positions[t[i]], positions[t[(i + 1) % 3]]);
  return sum;
}

// Removes what is marked; true if there was any.
bool remove_marked(std::vector<Triangle>& triangles, std::span<const std::uint8_t> marked) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!marked[t]) triangles[kept++] = triangles[t];
  const bool any = kept < triangles.size();
  triangles.resize(kept);
  return any;
}

void drop_repeated(std::vector<Triangle>& triangles) {
  std::vector<std::int32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0);
  const auto sorted = [&](std::int32_t t) {
    Triangle corners = triangles[t];
    std::ranges::sort(corners);
    return corners;
  };
  std::ranges::sort(order, [&](std::int32_t a, std::int32_t b) {
    const Triangle x = sorted(a), y = sorted(b);
    return x < y || (x == y && a < b);
  });
  std::vector<std::uint8_t> marked(triangles.size(), 0);
  for (std::size_t i = 1; i < order.size(); ++i)
    marked[order[i]] = sorted(order[i]) == sorted(order[i - 1]);
  remove_marked(triangles, marked);
}

// At an edge of three and more triangles all but the two of least perimeter go.
bool drop_surplus_at_edges(std::span<const glm::dvec3> positions,
                           std::vector<Triangle>& triangles) {
  std::vector<std::uint8_t> marked(triangles.size(), 0);
  edges_of(triangles, positions.size())
      .for_each([&](std::int32_t, std::span<const FaceSide> sides) {
        if (sides.size() <= 2) return;
        std::vector<std::pair<double, std::int32_t>> by_size;
        for (const FaceSide& side : sides)
          by_size.emplace_back(perimeter_of(positions, triangles[side.face]), side.face);
        std::ranges::sort(by_size);
        for (std::size_t i = 2; i < by_size.size(); ++i) marked[by_size[i].second] = 1;
      });
  return remove_marked(triangles, marked);
}

// Gives neighbours the same sense; where that is impossible (a Moebius strip) triangles go.
bool orient(std::size_t vertex_count, std::vector<Triangle>& triangles) {
  const std::vector<std::int32_t> twins = twins_of(triangles, vertex_count);
  const auto start = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  // 0: not reached, 1: as it is, 2: to be turned round.
  std::vector<std::uint8_t> sense(triangles.size(), 0), marked(triangles.size(), 0);
  std::vector<std::int32_t> stack;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    if (sense[seed]) continue;
    sense[seed] = 1;
    stack.push_back(static_cast<std::int32_t>(seed));
    while (!stack.empty()) {
      const std::int32_t t = stack.back();
      stack.pop_back();
      for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (twins[h] < 0) continue;
        const bool opposed = start(h) != start(twins[h]);
        const std::uint8_t wanted = opposed ? sense[t] : static_cast<std::uint8_t>(3 - sense[t]);
        const std::int32_t other = twins[h] / 3;
        if (sense[other] == 0) {
          sense[other] = wanted;
          stack.push_back(other);
        } else if (sense[other] != wanted && !marked[t]) {
          marked[other] = 1;
        }
      }
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (sense[t] == 2) std::swap(triangles[t][1], triangles[t][2]);
  return remove_marked(triangles, marked);
}

// At a vertex of several fans all but the largest go.
bool drop_extra_fans(std::size_t vertex_count, std::vector<Triangle>& triangles) {
  const std::vector<std::int32_t> twins = twins_of(triangles, vertex_count);
  // A fan is a set of corners; a corner is numbered as the half-edge that starts there.
  DisjointSets fans(twins.size());
  for (std::size_t h = 0; h < twins.size(); ++h)
    if (twins[h] >= 0) fans.unite(static_cast<std::int32_t>(h), next_half_edge(twins[h]));
  std::vector<std::int32_t> sizes(twins.size(), 0), largest(vertex_count, -1);
  for (std::size_t h = 0; h < twins.size(); ++h) ++sizes[fans.find(static_cast<std::int32_t>(h))];
  for (std::size_t h = 0; h < twins.size(); ++h) {
    const std::int32_t fan = fans.find(static_cast<std::int32_t>(h));
    std::int32_t& best = largest[triangles[h / 3][h % 3]];
    if (best < 0 || sizes[fan] > sizes[best]) best = fan;
  }
  std::vector<std::uint8_t> marked(triangles.size(), 0);
  for (std::size_t h = 0; h < twins.size(); ++h)
    if (fans.find(static_cast<std::int32_t>(h)) != largest[triangles[h / 3][h % 3]])
      marked[h / 3] = 1;
  return remove_marked(triangles, marked);
}

// The component of each triangle, named by one of its triangles.
std::vector<std::int32_t> components_of(std::size_t vertex_count,
                                        std::span<const Triangle> triangles) {
  const std::vector<std::int32_t> twins = twins_of(triangles, vertex_count);
  DisjointSets sets(triangles.size());
  for (std::size_t h = 0; h < twins.size(); ++h)
    if (twins[h] >= 0) sets.unite(static_cast<std::int32_t>(h / 3), twins[h] / 3);
  std::vector<std::int32_t> components(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    components[t] = sets.find(static_cast<std::int32_t>(t));
  return components;
}

std::vector<std::int64_t> sizes_of(std::span<const std::int32_t> components) {
  std::vector<std::int64_t> sizes(components.size(), 0);
  for (const std::int32_t component : components) ++sizes[component];
  return sizes;
}

std::int64_t drop_components(std::size_t vertex_count, std::vector<Triangle>& triangles,
                             const ComponentRule& rule) {
  if (rule.keep == ComponentRule::Keep::All || triangles.empty()) return 0;
  const std::vector<std::int32_t> components = components_of(vertex_count, triangles);
  const std::vector<std::int64_t> sizes = sizes_of(components);
  const auto largest = std::ranges::max_element(sizes) - sizes.begin();
  using Keep = ComponentRule::Keep;
  const std::int64_t least =
      rule.keep == Keep::Auto ? least_part(sizes[largest]) : rule.least_faces;
  const auto stays = [&](std::size_t component) {
    return rule.keep == Keep::Largest ? static_cast<std::ptrdiff_t>(component) == largest
                                      : sizes[component] >= least;
  };
  std::int64_t dropped = 0;
  for (std::size_t c = 0; c < sizes.size(); ++c) dropped += sizes[c] > 0 && !stays(c);
  std::vector<std::uint8_t> marked(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) marked[t] = !stays(components[t]);
  remove_marked(triangles, marked);
  return dropped;
}

std::int64_t fill_holes(std::span<const glm::dvec3> positions, std::vector<Triangle>& triangles,
                        const TriangleRepairOptions& options) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  const EdgeGroups edges = edges_of(triangles, positions.size());
  const std::vector<std::int32_t> components = components_of(positions.size(), triangles);
  const std::vector<std::int64_t> sizes = sizes_of(components);
  // The boundary half-edge that ends at each vertex: a manifold has one at most.
  std::vector<std::int32_t> incoming(positions.size(), -1);
  for (std::size_t h = 0; h < twins.size(); ++h) {
    const auto half_edge = static_cast<std::int32_t>(h);
    if (twins[h] < 0) incoming[triangles[h / 3][next_half_edge(half_edge) % 3]] = half_edge;
  }
  const std::size_t original_count = triangles.size();
  std::vector<std::uint8_t> visited(twins.size(), 0);
  std::set<std::pair<std::int32_t, std::int32_t>> new_edges;
  const auto is_edge = [&](std::int32_t a, std::int32_t b) {
    return !edges.find(a, b).empty() || new_edges.contains(std::minmax(a, b));
  };
  std::int64_t filled = 0;
  for (std::size_t first = 0; first < twins.size(); ++first) {
    if (twins[first] >= 0 || visited[first]) continue;
    check_stop();
    // Against the half-edges, so that the patch runs opposite to its neighbours.
    Hole hole;
    for (auto h = static_cast<std::int32_t>(first); !visited[h];) {
      visited[h] = 1;
      const Triangle& beyond = triangles[h / 3];
      hole.loop.push_back(beyond[next_half_edge(h) % 3]);
      const glm::dvec3 normal = cross_of(positions, beyond);
      const double length = glm::length(normal);
      hole.normals.push_back(length > 0 ? normal / length : glm::dvec3(0.0));
      h = incoming[beyond[h % 3]];
    }
    const auto length = static_cast<std::int64_t>(hole.loop.size());
    if (length > options.longest_filled_loop ||
        sizes[components[first / 3]] < kTrianglesPerRimEdge * length)
      continue;
    const std::vector<Triangle> patch = fill_hole(positions, hole, is_edge);
    filled += !patch.empty();
    for (const Triangle& t : patch) {
      triangles.push_back(t);
      for (int i = 0; i < 3; ++i) new_edges.emplace(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  PLANISH_ASSERT(triangles.size() >= original_count);
  return filled;
}

void turn_outwards(std::span<const glm::dvec3> positions, std::vector<Triangle>& triangles) {
  const std::vector<std::int32_t> components = components_of(positions.size(), triangles);
  std::vector<glm::dvec3> centroids(triangles.size(), glm::dvec3(0.0));
  std::vector<double> areas(triangles.size(), 0), volumes(triangles.size(), 0);
  const auto centre = [&](const Triangle& t) {
    return (positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0;
  };
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double area = glm::length(cross_of(positions, triangles[t]));
    areas[components[t]] += area;
    centroids[components[t]] += area * centre(triangles[t]);
  }
  // About the centroid, so that an open sheet and one far from the origin have a sign as well.
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::int32_t c = components[t];
    if (areas[c] > 0)
      volumes[c] += glm::dot(cross_of(positions, triangles[t]),
                             centre(triangles[t]) - centroids[c] / areas[c]);
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (volumes[components[t]] < 0) std::swap(triangles[t][1], triangles[t][2]);
}

}  // namespace

RepairedTriangles repair_triangles(std::span<const glm::dvec3> positions,
                                   std::vector<Triangle> triangles,
                                   const TriangleRepairOptions& options) {
  if (options.longest_filled_loop < 0 || options.longest_filled_loop > kLongestLoop)
    throw Error(ErrorCode::InvalidArgument,
                formatted("fill-holes: {} edges are asked for; 0 to {} work",
                          options.longest_filled_loop, kLongestLoop));
  const std::size_t given = triangles.size();
  RepairedTriangles result;
  const HostScope host(options.callbacks);
  options.callbacks.report("repair", 0.0);
  drop_repeated(triangles);
  // Each step can undo another's work by what it drops; each drops something or all are content.
  while (true) {
    check_stop();
    if (drop_surplus_at_edges(positions, triangles)) continue;
    if (orient(positions.size(), triangles)) continue;
    if (drop_extra_fans(positions.size(), triangles)) continue;
    if (!remove_marked(triangles, open_bridges(positions, triangles))) break;
  }
  result.dropped_triangle_count = static_cast<std::int64_t>(given - triangles.size());
  options.callbacks.report("repair", 0.5);
  result.dropped_component_count = drop_components(positions.size(), triangles, options.components);
  if (options.longest_filled_loop > 0)
    result.filled_loop_count = fill_holes(positions, triangles, options);
  turn_outwards(positions, triangles);
  result.triangles = std::move(triangles);
  options.callbacks.report("repair", 1.0);
  return result;
}

}  // namespace planish
