#include "planish/features/kept_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/features/jumps.h"
#include "planish/features/regions.h"
#include "planish/mesh/area_vector.h"

namespace planish {
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
  const RegionMap map = make_regions(mesh, topology, rules);
  // Planes are large: where no region is, nothing is to be measured.
  if (std::ranges::none_of(map.regions, [&](const Region& r) { return r.share >= rules.large; }))
    return {};
  return PlaneKeeper(mesh, topology, map, is_sharp, rules).find();
}

}  // namespace planish
