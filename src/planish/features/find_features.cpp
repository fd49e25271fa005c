#include "planish/features/find_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/features/jumps.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// A place that is either smooth or sharp, with what each costs.
struct LabelCost {
  double smooth = 0, sharp = 0;
};

// Two places that should be alike: `cost` where they are not.
struct LabelLink {
  std::int32_t a, b;
  double cost;
};

// Of all costs of a cut: less is rounding, and left as it is.
constexpr double kRounding = 1e-9;

constexpr char kOpen = 2;

// Places with what their decided neighbours say. Those whose own costs outweigh all open links are
// decided, too: nearly all.
class Decider {
 public:
  Decider(std::span<const LabelCost> costs, std::span<const LabelLink> links)
      : links_(links), costs_(costs.begin(), costs.end()), open_(costs.size(), 0.0) {
    labels_.assign(costs.size(), kOpen);
    links_at_ = group_by<std::int32_t>(costs.size(), [&](const auto& take) {
      for (std::size_t i = 0; i < links.size(); ++i) {
        take(links[i].a, static_cast<std::int32_t>(i));
        take(links[i].b, static_cast<std::int32_t>(i));
      }
    });
    for (const LabelLink& link : links) {
      open_[link.a] += link.cost;
      open_[link.b] += link.cost;
    }
  }

  void decide_clear_ones() {
    std::vector<std::int32_t> waiting(costs_.size());
    for (std::size_t i = 0; i < waiting.size(); ++i) waiting[i] = static_cast<std::int32_t>(i);
    while (!waiting.empty()) {
      const std::int32_t i = waiting.back();
      waiting.pop_back();
      if (labels_[i] != kOpen) continue;
      const double lead = costs_[i].smooth - costs_[i].sharp;
      // Sums that were taken from leave rounding.
      const double open = open_[i] + kRounding * (costs_[i].smooth + costs_[i].sharp);
      if (lead > open)
        labels_[i] = 1;
      else if (-lead > open)
        labels_[i] = 0;
      else
        continue;
      for (const std::int32_t l : links_at_.of(i)) {
        const std::int32_t other = other_end(l, i);
        open_[other] -= links_[l].cost;
        (labels_[i] ? costs_[other].smooth : costs_[other].sharp) += links_[l].cost;
        if (labels_[other] == kOpen) waiting.push_back(other);
      }
    }
  }

  [[nodiscard]] std::vector<char> cut_the_rest() {
    std::vector<std::int32_t> number(costs_.size(), -1), part;
    for (std::size_t start = 0; start < costs_.size(); ++start) {
      if (labels_[start] != kOpen) continue;
      part.assign(1, static_cast<std::int32_t>(start));
      number[start] = 0;
      for (std::size_t k = 0; k < part.size(); ++k) {
        for (const std::int32_t l : links_at_.of(part[k])) {
          const std::int32_t other = other_end(l, part[k]);
          if (labels_[other] != kOpen || number[other] >= 0) continue;
          number[other] = static_cast<std::int32_t>(part.size());
          part.push_back(other);
        }
      }
      cut(part, number);
    }
    return std::move(labels_);
  }

 private:
  struct Arc {
    std::int32_t to;
    double left;
  };
  std::span<const LabelLink> links_;
  std::vector<LabelCost> costs_;
  std::vector<double> open_;  // of links to open places
  std::vector<char> labels_;
  Groups<std::int32_t> links_at_;

  [[nodiscard]] std::int32_t other_end(std::int32_t link, std::int32_t place) const {
    return links_[link].a == place ? links_[link].b : links_[link].a;
  }

  void cut(std::span<const std::int32_t> part, std::span<const std::int32_t> number);
};

// Dinic's maximum flow; an arc and its reverse stand together, at 2 i and 2 i + 1.
class Flow {
 public:
  explicit Flow(std::size_t nodes) : arcs_at_(nodes), level_(nodes), next_(nodes) {}

  void add(std::int32_t from, std::int32_t to, double there, double back) {
    arcs_at_[from].push_back(static_cast<std::int32_t>(to_.size()));
    to_.push_back(to);
    left_.push_back(there);
    arcs_at_[to].push_back(static_cast<std::int32_t>(to_.size()));
    to_.push_back(from);
    left_.push_back(back);
    total_ += there + back;
  }

  // Afterwards a node is on the source's side where reached() says so.
  void run(std::int32_t source, std::int32_t sink) {
    least_ = kRounding * total_;
    while (set_levels(source, sink)) {
      std::ranges::fill(next_, 0);
      while (push(source, sink)) {
      }
    }
  }

  [[nodiscard]] bool reached(std::int32_t node) const { return level_[node] >= 0; }

 private:
  std::vector<std::vector<std::int32_t>> arcs_at_;
  std::vector<std::int32_t> to_, level_;
  std::vector<std::size_t> next_;
  std::vector<double> left_;
  std::vector<std::int32_t> path_;
  double total_ = 0, least_ = 0;

  bool set_levels(std::int32_t source, std::int32_t sink) {
    std::ranges::fill(level_, -1);
    level_[source] = 0;
    std::vector<std::int32_t> queue{source};
    for (std::size_t k = 0; k < queue.size(); ++k) {
      for (const std::int32_t arc : arcs_at_[queue[k]]) {
        if (left_[arc] <= least_ || level_[to_[arc]] >= 0) continue;
        level_[to_[arc]] = level_[queue[k]] + 1;
        queue.push_back(to_[arc]);
      }
    }
    return level_[sink] >= 0;
  }

  // One path by levels, without recursion.
  bool push(std::int32_t source, std::int32_t sink) {
    path_.clear();
    std::int32_t node = source;
    while (node != sink) {
      const std::vector<std::int32_t>& arcs = arcs_at_[node];
      std::size_t& next = next_[node];
      while (next < arcs.size() &&
             (left_[arcs[next]] <= least_ || level_[to_[arcs[next]]] != level_[node] + 1))
        ++next;
      if (next < arcs.size()) {
        path_.push_back(arcs[next]);
        node = to_[arcs[next]];
        continue;
      }
      if (path_.empty()) return false;
      node = to_[path_.back() ^ 1];
      path_.pop_back();
      ++next_[node];
    }
    double most = left_[path_.front()];
    for (const std::int32_t arc : path_) most = std::min(most, left_[arc]);
    for (const std::int32_t arc : path_) {
      left_[arc] -= most;
      left_[arc ^ 1] += most;
    }
    return true;
  }
};

void Decider::cut(std::span<const std::int32_t> part, std::span<const std::int32_t> number) {
  const auto count = static_cast<std::int32_t>(part.size());
  const std::int32_t source = count, sink = count + 1;
  Flow flow(part.size() + 2);
  for (std::int32_t k = 0; k < count; ++k) {
    const LabelCost& cost = costs_[part[k]];
    const double both = std::min(cost.smooth, cost.sharp);
    flow.add(source, k, cost.smooth - both, 0);
    flow.add(k, sink, cost.sharp - both, 0);
    for (const std::int32_t l : links_at_.of(part[k])) {
      const std::int32_t other = other_end(l, part[k]);
      if (number[other] > k && labels_[other] == kOpen)
        flow.add(k, number[other], links_[l].cost, links_[l].cost);
    }
  }
  flow.run(source, sink);
  for (std::int32_t k = 0; k < count; ++k) labels_[part[k]] = flow.reached(k) ? 1 : 0;
}

// One flag a place, 1: sharp. The labels that cost least in all, of several such those with the
// fewest sharp places: a minimum cut (Dinic, 1970) of what is not decided by its own costs.
std::vector<char> cheapest_labels(std::span<const LabelCost> costs,
                                  std::span<const LabelLink> links) {
  Decider decider(costs, links);
  decider.decide_clear_ones();
  return decider.cut_the_rest();
}

// Of these the vertices inside the surface where a line of two sharp segments jumps.
std::vector<std::int32_t> find_bends(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const RegionMap& map, std::span<const char> is_sharp,
                                     const FeatureRules& rules);

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
  double cosine_ = portable::cos(glm::radians(rules_.jump) / 2);
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
    return own >= portable::hypot(rules_.jump, rules_.spread * around);
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
    const double scale = portable::hypot(rules_.jump, rules_.spread * spread);
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

std::vector<std::int32_t> find_bends(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const RegionMap& map, std::span<const char> is_sharp,
                                     const FeatureRules& rules) {
  return CornerFinder(mesh, topology, map, is_sharp, rules).find_bends();
}

// Vertices, ascending, where a boundary or a line of two sharp segments jumps, or where a cone
// ends: by the same jump as edges.
std::vector<std::int32_t> find_corners(const PolygonMesh& mesh, const MeshTopology& topology,
                                       const RegionMap& map, std::span<const char> is_sharp,
                                       const FeatureRules& rules) {
  return CornerFinder(mesh, topology, map, is_sharp, rules).find();
}

// Of the time, what comes first.
constexpr double kRegions = 0.3, kAcross = 0.5, kMeasured = 0.7, kLabels = 0.9;
// Sharp edges explain nothing, so that others become sharp: so often at most.
constexpr int kPasses = 64;
// Jumps that differ by less, relatively, are as large.
constexpr double kAsLarge = 1e-6;
// Vertices with more lines have none that goes on.
constexpr std::size_t kMostLines = 16;
// Of a region on whose outline something has changed: those beyond it are marked, too.
constexpr char kLookedAround = 2;

class Labeller {
 public:
  Labeller(const PolygonMesh& mesh, const MeshTopology& topology, const RegionMap& map,
           const FeatureRules& rules)
      : mesh_(mesh), topology_(topology), map_(map), rules_(rules) {
    const std::size_t count = map.segments.size();
    labels_.assign(count, 0);
    for (std::size_t s = 0; s < count; ++s) labels_[s] = map.segments[s].is_tagged ? 1 : 0;
    jump_.resize(count);
  }

  template <class Tell>
  void run(const Tell& tell) {
    if (!can_any_be_sharp()) return;
    if (rules_.every) {
      for (std::size_t s = 0; s < labels_.size(); ++s)
        if (map_.segments[s].regions[1] >= 0 && std::abs(map_.segments[s].turn) > *rules_.every)
          labels_[s] = 1;
      return;
    }
    jumps_.emplace(map_, rules_);
    tell(kAcross);
    link();
    std::vector<char> is_near(map_.regions.size(), 1);
    for (int pass = 0; pass < kPasses; ++pass) {
      measure(is_near);
      if (pass == 0) tell(kMeasured);
      if (!cut(is_near) && !end_bends(is_near)) return;
    }
  }

  [[nodiscard]] const std::vector<char>& labels() const { return labels_; }
  [[nodiscard]] SegmentJumps::Jump jump(std::int32_t segment) const { return jump_[segment]; }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  const RegionMap& map_;
  const FeatureRules& rules_;
  std::optional<SegmentJumps> jumps_;
  std::vector<char> labels_;
  std::vector<SegmentJumps::Jump> jump_;
  std::vector<LabelLink> links_;
  struct SegmentEnd {
    std::int32_t vertex, segment;
  };
  std::vector<SegmentEnd> ends_;  // by vertex, inside the surface

  // A jump is at most its turn, and its scale at least FeatureRules::jump but between large planes:
  // where each label alone is cheapest smooth, so are all together, and nothing is to be measured.
  [[nodiscard]] bool can_any_be_sharp() {
    const auto is_large = [&](std::int32_t r) { return map_.regions[r].share >= rules_.large; };
    const double least = rules_.every.value_or(rules_.jump);
    bool can = false;
    for (std::size_t s = 0; s < jump_.size(); ++s) {
      const Segment& line = map_.segments[s];
      const auto& [a, b] = line.regions;
      jump_[s] = {b < 0 ? 0 : std::abs(line.turn), rules_.jump};
      can |= line.is_tagged ||
             (b >= 0 && (std::abs(line.turn) >= least || (is_large(a) && is_large(b))));
    }
    return can;
  }

  // Those with a region on which something has changed.
  void measure(const std::vector<char>& is_near) {
    parallel_each(jump_.size(), 256, [&](std::size_t s) {
      const auto& [a, b] = map_.segments[s].regions;
      if (is_near[a] || (b >= 0 && is_near[b]))
        jump_[s] = jumps_->jump(static_cast<std::int32_t>(s), labels_);
    });
  }

  // A line goes on at a vertex where one of the same sense leaves it nearly straight.
  void link() {
    std::vector<std::int32_t> lines;
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) {
      lines.clear();
      for (const std::int32_t corner : topology_.corners_at(v)) {
        add_line(topology_.edge_of(corner), v, lines);
        if (topology_.ccw(corner) < 0)
          add_line(topology_.edge_of(topology_.prev(corner)), v, lines);
      }
      if (lines.size() > kMostLines) continue;
      for (std::size_t i = 0; i < lines.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          link(lines[i] / 2, lines[j] / 2, (lines[i] ^ lines[j]) & 1);
      if (topology_.is_boundary_vertex(v)) continue;
      for (const std::int32_t line : lines)
        if (std::ranges::count(lines, line / 2, [](std::int32_t l) { return l / 2; }) == 1)
          ends_.push_back({v, line / 2});
    }
  }

  // A line that ends inside the surface where nothing else jumps costs as much as one that does not
  // go on.
  void add_ends(std::vector<LabelCost>& costs) const {
    for (std::size_t first = 0, last = 0; first < ends_.size(); first = last) {
      while (last < ends_.size() && ends_[last].vertex == ends_[first].vertex) ++last;
      const auto jumps = [&](const SegmentEnd& end) {
        const SegmentJumps::Jump& jump = jump_[end.segment];
        return labels_[end.segment] || jump.jump >= jump.scale;
      };
      const auto at = std::span(ends_).subspan(first, last - first);
      if (std::ranges::count_if(at, jumps) != 1) continue;
      const std::int32_t alone = std::ranges::find_if(at, jumps)->segment;
      costs[alone].sharp += rules_.line / 2 * map_.segments[alone].length;
    }
  }

  // A segment twice, and 1 where it runs to the vertex.
  void add_line(std::int32_t edge, std::int32_t v, std::vector<std::int32_t>& lines) const {
    const std::int32_t s = map_.segment_of_edge[edge];
    if (s < 0 || map_.segments[s].regions[1] < 0) return;
    const std::int32_t corner = topology_.corner_of(edge);
    const bool is_left =
        map_.region_of_face[topology_.face_of(corner)] == map_.segments[s].regions[0];
    lines.push_back(2 * s + ((topology_.vertex_of(corner) == v) != is_left ? 1 : 0));
  }

  void link(std::int32_t s, std::int32_t t, bool is_in_and_out) {
    const Segment &a = map_.segments[s], &b = map_.segments[t];
    if (s == t || a.turn * b.turn <= 0) return;
    const double cosine = glm::dot(a.along, b.along) * (is_in_and_out ? 1 : -1);
    if (cosine >= rules_.straight)
      links_.push_back({s, t, rules_.line / 2 * std::min(a.length, b.length) * cosine});
  }

  // Two smooth surfaces meet in a smooth line: where it jumps one of them is not smooth, and what
  // jumps most there, of edges between planes, is sharp. Whether there are more sharp segments now.
  bool end_bends(std::vector<char>& is_near) {
    std::vector<std::int32_t> lines, ends;
    for (const std::int32_t v : find_bends(mesh_, topology_, map_, labels_, rules_)) {
      lines.clear();
      for (const std::int32_t corner : topology_.corners_at(v))
        add_line(topology_.edge_of(corner), v, lines);
      std::erase_if(lines, [&](std::int32_t line) {
        const auto& [a, b] = map_.segments[line / 2].regions;
        return labels_[line / 2] || b < 0 || (!jumps_->is_told(a) && !jumps_->is_told(b));
      });
      double most = 0;
      for (const std::int32_t line : lines) most = std::max(most, jump_[line / 2].jump);
      for (const std::int32_t line : lines)
        if (jump_[line / 2].jump >= most * (1 - kAsLarge)) ends.push_back(line / 2);
    }
    for (const std::int32_t s : ends) sharpen(s, is_near);
    return !ends.empty();
  }

  // Whether there are more sharp segments now, and which regions look at one. What is sharp stays
  // so.
  bool cut(std::vector<char>& is_near) {
    std::vector<LabelCost> costs(map_.segments.size());
    for (std::size_t s = 0; s < costs.size(); ++s) {
      const double length = map_.segments[s].length;
      const double share = jump_[s].jump / jump_[s].scale;
      costs[s] = {length * (share < 1e3 ? share * share : 1e6), labels_[s] ? 0.0 : length};
      if (labels_[s]) costs[s].smooth = 1e6 * length;
      if (map_.segments[s].regions[1] < 0) costs[s] = {0, length};
    }
    add_ends(costs);
    const std::vector<char> cheapest = cheapest_labels(costs, links_);
    bool has_more = false;
    std::ranges::fill(is_near, 0);
    for (std::size_t s = 0; s < cheapest.size(); ++s) {
      if (!cheapest[s] || labels_[s]) continue;
      sharpen(s, is_near);
      has_more = true;
    }
    return has_more;
  }

  void sharpen(std::size_t s, std::vector<char>& is_near) {
    labels_[s] = 1;
    for (const std::int32_t region : map_.segments[s].regions) {
      if (is_near[region] == kLookedAround) continue;
      is_near[region] = kLookedAround;
      for (const std::int32_t other : map_.outlines.of(region))
        if (const std::int32_t near = map_.beyond(other, region); near >= 0 && is_near[near] == 0)
          is_near[near] = 1;
    }
  }
};

void require_rules(const FeatureRules& rules) {
  const auto require = [](const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw Error(ErrorCode::InvalidArgument,
                  formatted("the rule of features {} is {}; give {} to {}", name,
                            short_number(value), short_number(least), short_number(most)));
  };
  require("flat", rules.flat, 0, 45);
  require("cap", rules.cap, 0, 90);
  require("jump", rules.jump, 1e-3, 180);
  require("spread", rules.spread, 0, 100);
  require("large", rules.large, 0, 1);
  require("uneven", rules.uneven, 1, 100);
  require("line", rules.line, 0, 100);
  require("parallel", rules.parallel, 0, 1);
  require("straight", rules.straight, 0, 1);
  require("every", rules.every.value_or(0), 0, 180);
}

FeatureReason reason_of(const Segment& segment, const SegmentJumps::Jump& jump, bool is_sharp,
                        const FeatureRules& rules) {
  if (segment.is_tagged) return FeatureReason::Tagged;
  if (rules.every) return is_sharp ? FeatureReason::Turn : FeatureReason::Explained;
  const bool jumps = jump.jump >= jump.scale;
  if (is_sharp) return jumps ? FeatureReason::Jump : FeatureReason::Line;
  return jumps ? FeatureReason::Ended : FeatureReason::Explained;
}

}  // namespace

std::vector<CreaseEdge> Features::sharp_edges() const {
  std::vector<CreaseEdge> sharp;
  for (const FeatureEdge& edge : edges)
    if (edge.is_sharp) sharp.push_back({edge.v0, edge.v1});
  return sharp;
}

Features find_features(const PolygonMesh& mesh, const MeshTopology& topology,
                       const FeatureRules& given, const std::function<void(double)>& done) {
  require_rules(given);
  const auto tell = [&](double part) {
    if (done) done(part);
  };
  FeatureRules rules = given;
  if (rules.every) rules.flat = std::min(rules.flat, *rules.every);
  const RegionMap map = make_regions(mesh, topology, rules);
  if (map.regions.empty()) return {};
  tell(kRegions);
  Labeller labeller(mesh, topology, map, rules);
  labeller.run(tell);
  tell(kLabels);
  Features features;
  features.edges.reserve(static_cast<std::size_t>(
      std::ranges::count_if(map.segment_of_edge, [](std::int32_t s) { return s >= 0; })));
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t s = map.segment_of_edge[e];
    if (s < 0 || map.segments[s].regions[1] < 0) continue;
    const auto [a, b] = topology.edge_vertices(e);
    const SegmentJumps::Jump jump = labeller.jump(s);
    const bool is_sharp = labeller.labels()[s];
    features.edges.push_back({a, b, map.segments[s].turn, jump.jump,
                              reason_of(map.segments[s], jump, is_sharp, rules), is_sharp});
  }
  features.corners = find_corners(mesh, topology, map, labeller.labels(), rules);
  for (const CornerVertex& corner : mesh.corners) features.corners.push_back(corner.vertex);
  std::ranges::sort(features.corners);
  features.corners.erase(std::unique(features.corners.begin(), features.corners.end()),
                         features.corners.end());
  return features;
}

Features find_features(const PolygonMesh& mesh, const FeatureRules& rules) {
  require_usable(mesh, "mesh");
  return find_features(mesh, MeshTopology(mesh), rules);
}

namespace {

// Of a turn: in the middle between half of it and all.
constexpr double kNearlyAll = 0.75;

class PlaneKeeper {
 public:
  PlaneKeeper(const PolygonMesh& mesh, const MeshTopology& topology, const RegionMap& map,
              std::span<const char> is_sharp, const FeatureRules& rules)
      : mesh_(mesh), topology_(topology), map_(map), is_sharp_(is_sharp) {
    std::vector<char> labels(map.segments.size(), 0);
    for (std::size_t e = 0; e < is_sharp.size(); ++e)
      if (const std::int32_t s = map.segment_of_edge[e]; s >= 0 && is_sharp[e] != 0) labels[s] = 1;
    const SegmentJumps jumps(map, rules);
    keeps_.assign(labels.size(), {false, false});
    std::vector<double> balance(map.regions.size(), 0.0);
    for (std::size_t s = 0; s < labels.size(); ++s)
      if (const Segment& line = map.segments[s]; labels[s] == 0 && line.regions[1] >= 0)
        for (const int side : {0, 1}) {
          keeps_[s][side] =
              jumps.is_told(line.regions[side]) &&
              jumps.explained(static_cast<std::int32_t>(s), 1 - side, labels).along() >=
                  kNearlyAll * std::abs(line.turn);
          balance[line.regions[side]] += keeps_[s][side] ? line.length : -line.length;
        }
    for (std::size_t s = 0; s < labels.size(); ++s)
      for (const int side : {0, 1})
        keeps_[s][side] = keeps_[s][side] && balance[map.segments[s].regions[side]] > 0;
  }

  [[nodiscard]] std::vector<KeptPlane> find() {
    std::vector<char> is_beside(static_cast<std::size_t>(topology_.vertex_count()), 0);
    for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
      const std::int32_t s = map_.segment_of_edge[e];
      if (s < 0 || (!keeps_[s][0] && !keeps_[s][1])) continue;
      const auto [a, b] = topology_.edge_vertices(e);
      is_beside[a] = is_beside[b] = 1;
    }
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v)
      if (is_beside[v] != 0) look_around(v);
    return std::move(found_);
  }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  const RegionMap& map_;
  std::span<const char> is_sharp_;          // by edge
  std::vector<std::array<bool, 2>> keeps_;  // by segment: whether that side is a plane up to it
  std::vector<KeptPlane> found_;
  std::vector<std::int32_t> sector_, kept_, lost_;  // corners; regions

  [[nodiscard]] std::int32_t region_of(std::int32_t corner) const {
    return map_.region_of_face[topology_.face_of(corner)];
  }
  // Between a corner and the next one counter-clockwise.
  [[nodiscard]] std::int32_t edge_behind(std::int32_t corner) const {
    return topology_.edge_of(topology_.prev(corner));
  }

  // Sector by sector; where no edge is sharp, all around.
  void look_around(std::int32_t v) {
    const std::span<const std::int32_t> corners = topology_.corners_at(v);
    const auto first = std::ranges::find_if(
        corners, [&](std::int32_t corner) { return is_sharp_[topology_.edge_of(corner)] != 0; });
    const auto begin = static_cast<std::size_t>(first - corners.begin());
    sector_.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t corner = corners[(begin + i) % corners.size()];
      sector_.push_back(corner);
      if (is_sharp_[edge_behind(corner)] == 0) continue;
      look_at_sector(v, sector_.size() - 1);
      sector_.clear();
    }
    if (first == corners.end()) look_at_sector(v, sector_.size());
  }

  // `edges`: behind so many of its corners. A plane that is none at one of them is none there.
  void look_at_sector(std::int32_t v, std::size_t edges) {
    kept_.clear();
    lost_.clear();
    for (std::size_t i = 0; i < edges; ++i) {
      const std::int32_t s = map_.segment_of_edge[edge_behind(sector_[i])];
      if (s < 0) continue;
      for (const int side : {0, 1})
        (keeps_[s][side] ? kept_ : lost_).push_back(map_.segments[s].regions[side]);
    }
    std::ranges::sort(kept_);
    kept_.erase(std::unique(kept_.begin(), kept_.end()), kept_.end());
    std::erase_if(kept_,
                  [&](std::int32_t r) { return std::ranges::find(lost_, r) != lost_.end(); });
    if (kept_.size() == 1) found_.push_back({v, largest_face_of(kept_.front())});
  }

  [[nodiscard]] std::int32_t largest_face_of(std::int32_t region) const {
    std::int32_t largest = -1;
    double most = -1;
    for (const std::int32_t corner : sector_) {
      const std::int32_t face = topology_.face_of(corner);
      const double area = glm::length(area_vector(mesh_.positions, topology_.face(face)));
      if (region_of(corner) != region || area <= most) continue;
      most = area;
      largest = face;
    }
    return largest;
  }
};

}  // namespace

std::vector<KeptPlane> find_kept_planes(const PolygonMesh& mesh, const MeshTopology& topology,
                                        std::span<const char> is_sharp, const FeatureRules& rules) {
  // Planes are large: where no region is, nothing is to be measured.
  const RegionMap map = make_regions(mesh, topology, rules, rules.large);
  if (map.regions.empty()) return {};
  return PlaneKeeper(mesh, topology, map, is_sharp, rules).find();
}

}  // namespace planish
