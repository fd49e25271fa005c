#include "planish/features/find_features.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/features/corners.h"
#include "planish/features/jumps.h"
#include "planish/features/line_cut.h"
#include "planish/features/regions.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

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

}  // namespace planish
