#include "planish/doosabin/subdivision.h"

#include <algorithm>

#include "planish/core/assert.h"

namespace planish {

namespace {

using OpenSubdiv::Far::TopologyLevel;

// Sharp edges of the next level: the halves of this level's.
std::vector<std::int32_t> split_sharp_edges(const TopologyLevel& parent, const TopologyLevel& child,
                                            const std::vector<std::int32_t>& sharp_of_edge) {
  std::vector<std::int32_t> children(static_cast<std::size_t>(child.GetNumEdges()), -1);
  for (std::size_t e = 0; e < sharp_of_edge.size(); ++e) {
    if (sharp_of_edge[e] < 0) continue;
    const auto halves = parent.GetEdgeChildEdges(static_cast<int>(e));
    for (int end = 0; end < 2; ++end) {
      children[halves[end]] = 2 * sharp_of_edge[e] + end;
      const auto half = child.GetEdgeVertices(halves[end]);
      const int vertex = parent.GetEdgeVertices(static_cast<int>(e))[end];
      PLANISH_ASSERT(half[0] == vertex || half[1] == vertex);
    }
  }
  return children;
}

std::vector<std::int32_t> invert(const std::vector<std::int32_t>& sharp_of_edge,
                                 std::size_t sharp_count) {
  std::vector<std::int32_t> edge_of_sharp(sharp_count);
  for (std::size_t e = 0; e < sharp_of_edge.size(); ++e) {
    if (sharp_of_edge[e] >= 0) edge_of_sharp[sharp_of_edge[e]] = static_cast<std::int32_t>(e);
  }
  return edge_of_sharp;
}

}  // namespace

Subdivision::Subdivision(const QuadSplit& split, const SharpFeatures& features, Weights weights)
    : split_(split), features_(features), face_weights_(weights) {
  const std::size_t level_count = static_cast<std::size_t>(split.level_count());
  layouts_.resize(level_count + 2);
  for (std::size_t l = 1; l < layouts_.size(); ++l) {
    StateLayout& layout = layouts_[l];
    layout.first_sharp = split.counts(static_cast<int>(l)).faces;
    layout.first_corner =
        layout.first_sharp + (static_cast<std::int64_t>(features.sharp_edge_count) << l);
    layout.size = layout.first_corner + features.corner_count;
  }

  sharp_of_edge_.resize(std::max<std::size_t>(level_count, 1));
  sharp_of_edge_[0] = features.sharp_of_edge;
  edge_of_sharp_.resize(sharp_of_edge_.size());
  if (!has_sharp_edges()) return;
  edge_of_sharp_[0] = invert(sharp_of_edge_[0], features.sharp_edge_count);
  for (std::size_t l = 1; l < sharp_of_edge_.size(); ++l) {
    sharp_of_edge_[l] = split_sharp_edges(split.level(static_cast<int>(l) - 1),
                                          split.level(static_cast<int>(l)), sharp_of_edge_[l - 1]);
    edge_of_sharp_[l] = invert(sharp_of_edge_[l], 2 * edge_of_sharp_[l - 1].size());
  }
}

}  // namespace planish
