#include "planish/features/corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "planish/core/unit_vector.h"
#include "planish/features/jumps.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

class CornerFinder {
 public:
  CornerFinder(const PolygonMesh& mesh, const MeshTopology& topology, const RegionMap& map,
               std::span<const char> is_sharp, const FeatureRules& rules)
      : mesh_(mesh), topology_(topology), map_(map), is_sharp_(is_sharp), rules_(rules) {
    set_lines();
  }

  // Inside the surface, where two sharp segments meet and their line jumps.
  [[nodiscard]] std::vector<std::int32_t> find_bends() const {
    std::vector<std::int32_t> bends;
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v)
      if (turns_[v] > 0 && !topology_.is_boundary_vertex(v) && jumps_at(v)) bends.push_back(v);
    return bends;
  }

  // What is a corner explains nothing: jumps are taken again beside it.
  [[nodiscard]] std::vector<std::int32_t> find() {
    std::vector<std::int32_t> corners, found;
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v)
      if (turns_[v] > 0 ? jumps_at(v) : count_[v] == 0 && is_tip(v)) found.push_back(v);
    while (!found.empty()) {
      corners.insert(corners.end(), found.begin(), found.end());
      for (const std::int32_t v : found) is_corner_[v] = 1;
      std::vector<std::int32_t> beside;
      for (const std::int32_t v : found)
        if (count_[v] == 2)
          for (const std::int32_t end : ends_[v]) beside.push_back(go(v, end).vertex);
      std::ranges::sort(beside);
      beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
      found.clear();
      for (const std::int32_t v : beside)
        if (is_corner_[v] == 0 && count_[v] == 2 && turns_[v] > 0 && jumps_at(v))
          found.push_back(v);
    }
    std::ranges::sort(corners);
    return corners;
  }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  const RegionMap& map_;
  std::span<const char> is_sharp_;
  const FeatureRules& rules_;
  double cosine_ = std::cos(glm::radians(rules_.jump) / 2);
  // By vertex: how many sharp edges and boundaries it has; the far ends of two of them; of a vertex
  // with two how the line turns there, in degrees, and about what.
  std::vector<std::int32_t> count_;
  std::vector<std::array<std::int32_t, 2>> ends_;
  std::vector<double> turns_;
  std::vector<glm::dvec3> axes_;

  std::vector<char> is_corner_;  // by vertex

  // Whether a line goes on there, as far as is known.
  [[nodiscard]] bool is_smooth(std::int32_t v) const {
    return count_[v] == 2 && is_corner_[v] == 0;
  }

  [[nodiscard]] glm::dvec3 at(std::int32_t vertex) const { return mesh_.positions[vertex]; }

  [[nodiscard]] bool is_line(std::int32_t edge) const {
    const std::int32_t segment = map_.segment_of_edge[edge];
    return segment >= 0 && (is_sharp_[segment] || map_.segments[segment].regions[1] < 0);
  }

  [[nodiscard]] std::int32_t region_of(std::int32_t corner) const {
    return map_.region_of_face[topology_.face_of(corner)];
  }

  void set_lines() {
    const auto count = static_cast<std::size_t>(topology_.vertex_count());
    count_.assign(count, 0);
    ends_.assign(count, {-1, -1});
    turns_.assign(count, 0);
    axes_.assign(count, glm::dvec3(0.0));
    is_corner_.assign(count, 0);
    for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (!is_line(e)) continue;
      const auto [a, b] = topology_.edge_vertices(e);
      if (count_[a] < 2) ends_[a][count_[a]] = b;
      if (count_[b] < 2) ends_[b][count_[b]] = a;
      ++count_[a];
      ++count_[b];
    }
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) {
      if (count_[v] != 2) continue;
      const glm::dvec3 in = at(v) - at(ends_[v][0]), out = at(ends_[v][1]) - at(v);
      axes_[v] = glm::cross(in, out);
      turns_[v] = std::min(degrees_between(in, out), along_surface(v));
      if (turns_[v] < rules_.flat) turns_[v] = 0;
    }
  }

  // By how much the line turns within the surface, on the side where it does so more: half a turn
  // against the angles of the faces. 0 of the rim of an open box.
  [[nodiscard]] double along_surface(std::int32_t v) const {
    std::array<double, 2> sides{0, 0};
    int side = 0;
    for (const std::int32_t corner : topology_.corners_at(v)) {
      if (corner != topology_.corners_at(v).front() && is_line(topology_.edge_of(corner)))
        side = 1 - side;
      sides[side] += degrees_between(at(topology_.vertex_of(topology_.next(corner))) - at(v),
                                     at(topology_.vertex_of(topology_.prev(corner))) - at(v));
    }
    if (topology_.is_boundary_vertex(v)) return std::abs(180 - sides[0]);
    return std::max(std::abs(180 - sides[0]), std::abs(180 - sides[1]));
  }

  // Along a line from a vertex over one of its ends to where it turns next, or ends.
  struct Way {
    std::int32_t vertex;
    std::int32_t from;  // the one before it
    double length;
  };
  [[nodiscard]] Way go(std::int32_t from, std::int32_t to) const {
    const std::int32_t start = from;
    double length = glm::distance(at(from), at(to));
    while (count_[to] == 2 && turns_[to] == 0 && to != start) {
      const std::int32_t next = ends_[to][0] == from ? ends_[to][1] : ends_[to][0];
      length += glm::distance(at(to), at(next));
      from = to;
      to = next;
    }
    return {to, from, length};
  }

  [[nodiscard]] double signed_turn(std::int32_t v, const glm::dvec3& axis,
                                   std::int32_t from) const {
    // The axis of a vertex is that of a walk from its first end.
    const double sign = glm::dot(axes_[v], axis) * (ends_[v][0] == from ? 1 : -1);
    return sign > 0 ? turns_[v] : sign < 0 ? -turns_[v] : 0;
  }

  [[nodiscard]] Explained explained(std::int32_t v, int side, double width_before) const {
    const Way way = go(v, ends_[v][side]);
    if (!is_smooth(way.vertex) || way.vertex == v) return {};
    const glm::dvec3 axis = side == 1 ? axes_[v] : -axes_[v];
    const double turn = signed_turn(way.vertex, axis, way.from);
    if (turn <= 0) return {};
    const std::int32_t behind =
        ends_[way.vertex][0] == way.from ? ends_[way.vertex][1] : ends_[way.vertex][0];
    return explained_by(turns_[v], turn, way.length, go(way.vertex, behind).length, width_before,
                        rules_);
  }

  [[nodiscard]] double jump(std::int32_t v) const {
    const double back = go(v, ends_[v][0]).length, on = go(v, ends_[v][1]).length;
    return jump_of(turns_[v], explained(v, 0, on), explained(v, 1, back));
  }

  // Lines that jump everywhere are ragged, and have no corners, unless a plane ends there.
  [[nodiscard]] bool jumps_at(std::int32_t v) const {
    const double own = jump(v);
    if (own < rules_.jump) return false;
    if (bounds_plane(v)) return true;
    double around = 0;
    for (const std::int32_t end : ends_[v]) {
      const Way way = go(v, end);
      if (is_smooth(way.vertex) && turns_[way.vertex] > 0)
        around = std::max(around, jump(way.vertex));
    }
    return own >= std::hypot(rules_.jump, rules_.spread * around);
  }

  // Whether one side of the line is a plane for sure.
  [[nodiscard]] bool bounds_plane(std::int32_t v) const {
    const std::span<const std::int32_t> corners = topology_.corners_at(v);
    std::size_t first = 0;
    while (first + 1 < corners.size() && !is_line(topology_.edge_of(corners[first]))) ++first;
    bool is_whole = true, found = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t corner = corners[(first + i) % corners.size()];
      if (i == 0 || is_line(topology_.edge_of(corner))) {
        found = found || (i > 0 && is_whole);
        is_whole = map_.is_more_than_a_facet(region_of(corner));
      } else {
        const std::int32_t before = corners[(first + i - 1) % corners.size()];
        is_whole = is_whole && region_of(corner) == region_of(before);
      }
    }
    return found || is_whole;
  }

  // Normals of all faces around lean away from their mean by more than what is behind explains.
  [[nodiscard]] bool is_tip(std::int32_t v) const {
    const std::span<const std::int32_t> corners = topology_.corners_at(v);
    if (corners.size() < 3 || topology_.is_boundary_vertex(v)) return false;
    // Where all are near to one of them, so is their mean.
    const glm::dvec3& first = map_.regions[region_of(corners.front())].normal;
    if (std::ranges::all_of(corners, [&](std::int32_t corner) {
          return glm::dot(map_.regions[region_of(corner)].normal, first) >= cosine_;
        }))
      return false;
    glm::dvec3 axis(0.0);
    for (const std::int32_t corner : corners) {
      const glm::dvec3 a = unit_or_zero(at(topology_.vertex_of(topology_.next(corner))) - at(v));
      const glm::dvec3 b = unit_or_zero(at(topology_.vertex_of(topology_.prev(corner))) - at(v));
      axis += map_.regions[region_of(corner)].normal * angle_between(a, b);
    }
    if (glm::length(axis) == 0) return false;
    const auto lean = [&](std::int32_t region) {
      return degrees_between(map_.regions[region].normal, axis);
    };
    double least = 180, mean = 0, spread = 0;
    const auto count = static_cast<double>(corners.size());
    for (const std::int32_t corner : corners) {
      least = std::min(least, lean(region_of(corner)));
      mean += lean(region_of(corner)) / count;
    }
    if (least < rules_.jump) return false;
    for (const std::int32_t corner : corners)
      spread += std::abs(lean(region_of(corner)) - mean) / count;
    const double scale = std::hypot(rules_.jump, rules_.spread * spread);
    return std::ranges::all_of(corners, [&](std::int32_t corner) {
      const std::int32_t region = region_of(corner);
      const double own = lean(region);
      double back = 0;
      for (const std::int32_t s : map_.outlines.of(region)) {
        const std::int32_t far = map_.beyond(s, region);
        if (far < 0 || is_sharp_[s]) continue;
        if (lean(far) < 90) back = std::max(back, (lean(far) - own) / 2);
      }
      return own - back >= scale;
    });
  }
};

}  // namespace

std::vector<std::int32_t> find_bends(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const RegionMap& map, std::span<const char> is_sharp,
                                     const FeatureRules& rules) {
  return CornerFinder(mesh, topology, map, is_sharp, rules).find_bends();
}

std::vector<std::int32_t> find_corners(const PolygonMesh& mesh, const MeshTopology& topology,
                                       const RegionMap& map, std::span<const char> is_sharp,
                                       const FeatureRules& rules) {
  return CornerFinder(mesh, topology, map, is_sharp, rules).find();
}

}  // namespace planish
