#include "planish/analytic/region_borders.h"

#include <algorithm>
#include <cstddef>

namespace planish {
namespace {

class BorderFinder {
 public:
  BorderFinder(const MeshTopology& topology, const AnalyticRegions& regions)
      : topology_(topology),
        regions_(regions),
        meeting_(topology.vertex_count(), 0),
        use_of_(topology.corner_count(), ChainUse{-1, false}),
        is_done_(topology.corner_count(), 0) {
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      if (!is_border(topology.corner_of(e))) continue;
      const auto [from, to] = topology.edge_vertices(e);
      ++meeting_[from];
      ++meeting_[to];
    }
  }

  RegionBorders find() && {
    result_.loops.resize(regions_.regions.size());
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
      const std::int32_t region = region_at(c);
      if (region < 0 || is_done_[c] != 0 || !is_border(c)) continue;
      result_.loops[region].push_back(loop_from(c));
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::int32_t region_at(std::int32_t corner) const {
    return regions_.region_of[topology_.face_of(corner)];
  }
  [[nodiscard]] bool is_border(std::int32_t corner) const {
    const std::int32_t twin = topology_.twin(corner);
    return twin < 0 || region_at(twin) != region_at(corner);
  }
  [[nodiscard]] bool is_end(std::int32_t vertex) const { return meeting_[vertex] != 2; }
  [[nodiscard]] std::int32_t next_on_border(std::int32_t corner) const {
    std::int32_t next = topology_.next(corner);
    while (!is_border(next)) next = topology_.next(topology_.twin(next));
    return next;
  }

  std::vector<ChainUse> loop_from(std::int32_t first) {
    std::vector<std::int32_t> corners;
    for (std::int32_t c = first; is_done_[c] == 0; c = next_on_border(c)) {
      is_done_[c] = 1;
      corners.push_back(c);
    }
    // Begins where a chain does.
    const auto start = std::ranges::find_if(
        corners, [&](std::int32_t c) { return is_end(topology_.vertex_of(c)); });
    const bool is_closed = start == corners.end();
    if (!is_closed) std::ranges::rotate(corners, start);
    std::vector<ChainUse> loop;
    for (std::size_t i = 0; i < corners.size();) {
      std::size_t j = i + 1;
      while (j < corners.size() && !is_end(topology_.vertex_of(corners[j]))) ++j;
      loop.push_back(use_of(std::span(corners).subspan(i, j - i), is_closed));
      i = j;
    }
    return loop;
  }

  ChainUse use_of(std::span<const std::int32_t> corners, bool is_closed) {
    const std::int32_t twin = topology_.twin(corners.front());
    if (twin >= 0 && use_of_[twin].chain >= 0) return {use_of_[twin].chain, true};
    const auto index = static_cast<std::int32_t>(result_.chains.size());
    BorderChain chain;
    chain.left = region_at(corners.front());
    chain.right = twin < 0 ? -1 : region_at(twin);
    chain.is_boundary = twin < 0;
    chain.is_closed = is_closed;
    for (const std::int32_t c : corners) {
      use_of_[c] = {index, false};
      chain.vertices.push_back(topology_.vertex_of(c));
    }
    chain.vertices.push_back(topology_.vertex_of(topology_.next(corners.back())));
    result_.chains.push_back(std::move(chain));
    return {index, false};
  }

  const MeshTopology& topology_;
  const AnalyticRegions& regions_;
  std::vector<std::int32_t> meeting_;  // borders at a vertex
  std::vector<ChainUse> use_of_;       // by corner, of the chain's left side
  std::vector<char> is_done_;
  RegionBorders result_;
};

}  // namespace

RegionBorders find_borders(const MeshTopology& topology, const AnalyticRegions& regions) {
  return BorderFinder(topology, regions).find();
}

}  // namespace planish
