#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/mesh/edge_groups.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"

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

namespace {

// What a partial triangulation costs; smaller is better, the angle first.
struct Cost {
  double turn = 2;  // 1 - cosine of the largest dihedral angle's supplement: 0 flat, 2 folded
  double area = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool operator<(const Cost& other) const {
    return turn < other.turn || (turn == other.turn && area < other.area);
  }
};

class HoleFiller {
 public:
  HoleFiller(std::span<const glm::dvec3> positions, const Hole& hole,
             const std::function<bool(std::int32_t, std::int32_t)>& is_edge)
      : positions_(positions),
        hole_(hole),
        is_edge_(is_edge),
        count_(static_cast<int>(hole.loop.size())),
        costs_(hole.loop.size() * hole.loop.size()),
        splits_(hole.loop.size() * hole.loop.size(), -1) {}

  std::vector<Triangle> fill() {
    for (int i = 0; i + 1 < count_; ++i) costs_[at(i, i + 1)] = {.turn = 0, .area = 0};
    for (int span = 2; span < count_; ++span)
      for (int i = 0; i + span < count_; ++i) choose(i, i + span);
    std::vector<Triangle> triangles;
    if (splits_[at(0, count_ - 1)] >= 0) collect(0, count_ - 1, triangles);
    return triangles;
  }

 private:
  [[nodiscard]] std::size_t at(int i, int k) const {
    return static_cast<std::size_t>(i) * count_ + k;
  }
  [[nodiscard]] glm::dvec3 cross(int i, int j, int k) const {
    const glm::dvec3 a = positions_[hole_.loop[i]];
    return glm::cross(positions_[hole_.loop[j]] - a, positions_[hole_.loop[k]] - a);
  }
  // Normal of what lies beyond the side from i to j of a triangle inside i..j.
  [[nodiscard]] glm::dvec3 beyond(int i, int j) const {
    if (j == i + 1) return hole_.normals[i];
    return glm::normalize(cross(i, splits_[at(i, j)], j));
  }

  // The best middle corner for the part of the loop from i to k.
  void choose(int i, int k) {
    const bool is_rim = i == 0 && k == count_ - 1;
    if (!is_rim && is_edge_(hole_.loop[i], hole_.loop[k])) return;
    for (int j = i + 1; j < k; ++j) {
      const Cost& left = costs_[at(i, j)];
      const Cost& right = costs_[at(j, k)];
      if (!std::isfinite(left.area) || !std::isfinite(right.area)) continue;
      const glm::dvec3 normal = cross(i, j, k);
      const double doubled_area = glm::length(normal);
      if (!(doubled_area > 0)) continue;
      const auto turn_to = [&](const glm::dvec3& other) {
        return 1 - glm::dot(normal, other) / doubled_area;
      };
      Cost cost{
          .turn = std::max({left.turn, right.turn, turn_to(beyond(i, j)), turn_to(beyond(j, k))}),
          .area = left.area + right.area + 0.5 * doubled_area};
      if (is_rim) cost.turn = std::max(cost.turn, turn_to(hole_.normals[k]));
      if (cost < costs_[at(i, k)]) {
        costs_[at(i, k)] = cost;
        splits_[at(i, k)] = j;
      }
    }
  }

  void collect(int i, int k, std::vector<Triangle>& triangles) const {
    if (k == i + 1) return;
    const int j = splits_[at(i, k)];
    triangles.push_back({hole_.loop[i], hole_.loop[j], hole_.loop[k]});
    collect(i, j, triangles);
    collect(j, k, triangles);
  }

  std::span<const glm::dvec3> positions_;
  const Hole& hole_;
  const std::function<bool(std::int32_t, std::int32_t)>& is_edge_;
  int count_;
  std::vector<Cost> costs_;  // of the best triangulation from i to k
  std::vector<int> splits_;  // its corner between i and k; -1 if there is none
};

}  // namespace

std::vector<Triangle> fill_hole(std::span<const glm::dvec3> positions, const Hole& hole,
                                const std::function<bool(std::int32_t, std::int32_t)>& is_edge) {
  if (hole.loop.size() < 3) return {};
  return HoleFiller(positions, hole, is_edge).fill();
}

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

namespace {

// 1 for a triangle along the normals of its corners, -1 for one against them, 0 where they are
// silent.
int agreement(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
              const Triangle& triangle) {
  const glm::dvec3 &a = positions[triangle[0]], &b = positions[triangle[1]],
                   &c = positions[triangle[2]];
  const glm::dvec3 facing = glm::cross(b - a, c - a);
  double sum = 0;
  for (const std::int32_t corner : triangle) {
    const glm::dvec3 normal = normals[corner];
    const double length = glm::length(normal);
    if (length > 0 && std::isfinite(length)) sum += glm::dot(facing, normal) / length;
  }
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

}  // namespace

std::int64_t turn_by_normals(std::span<const glm::dvec3> positions,
                             std::span<const glm::vec3> normals, std::span<Triangle> triangles) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  std::vector<bool> reached(triangles.size(), false);
  std::vector<std::int32_t> component;
  std::int64_t turned_count = 0;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (reached[start]) continue;
    reached[start] = true;
    component.assign(1, static_cast<std::int32_t>(start));
    bool is_open = false;
    std::int64_t votes = 0;
    for (std::size_t i = 0; i < component.size(); ++i) {
      const std::int32_t t = component[i];
      votes += agreement(positions, normals, triangles[t]);
      for (std::int32_t half_edge = 3 * t; half_edge < 3 * t + 3; ++half_edge) {
        const std::int32_t twin = twins[half_edge];
        if (twin < 0) is_open = true;
        if (twin < 0 || reached[twin / 3]) continue;
        reached[twin / 3] = true;
        component.push_back(twin / 3);
      }
    }
    if (!is_open || votes >= 0) continue;
    for (const std::int32_t t : component) std::swap(triangles[t][1], triangles[t][2]);
    ++turned_count;
  }
  return turned_count;
}

}  // namespace planish
