#include "planish/files/gltf/strip_order.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Enough that the seams between blocks cost less than 1 %, few enough for many threads.
constexpr std::int64_t kBlockTriangles = std::int64_t{1} << 16;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Numbers the vertices of a block by themselves, since the optimiser takes time and memory by them.
class BlockOrder {
 public:
  explicit BlockOrder(std::size_t vertex_count) : local_(vertex_count, kNone) {}

  void operator()(std::span<const std::uint32_t> from, std::span<std::uint32_t> to) {
    vertices_.clear();
    corners_.resize(from.size());
    ordered_.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
      std::uint32_t& local = local_[from[i]];
      if (local == kNone) {
        local = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(from[i]);
      }
      corners_[i] = local;
    }
    meshopt_optimizeVertexCacheStrip(ordered_.data(), corners_.data(), corners_.size(),
                                     vertices_.size());
    std::ranges::transform(ordered_, to.begin(), [&](std::uint32_t v) { return vertices_[v]; });
    for (const std::uint32_t vertex : vertices_) local_[vertex] = kNone;
  }

 private:
  RawVector<std::uint32_t> corners_, ordered_;
  std::vector<std::uint32_t> local_, vertices_;
};

}  // namespace

StripOrder strip_order(std::span<const std::uint32_t> indices, std::size_t vertex_count) {
  StripOrder order;
  order.indices.resize(indices.size());
  const std::vector<RowRange> blocks =
      ranges_of(static_cast<std::int64_t>(indices.size() / 3), kBlockTriangles);
  parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    BlockOrder reorder(vertex_count);
    for (std::size_t i = begin; i < end; ++i) {
      const auto first = static_cast<std::size_t>(3 * blocks[i].first);
      const auto count = static_cast<std::size_t>(3 * blocks[i].count);
      reorder(indices.subspan(first, count), std::span(order.indices).subspan(first, count));
    }
  });
  order.new_vertices.assign(vertex_count, kNone);
  std::uint32_t next = 0;
  for (std::uint32_t& index : order.indices) {
    std::uint32_t& vertex = order.new_vertices[index];
    if (vertex == kNone) vertex = next++;
    index = vertex;
  }
  for (std::uint32_t& vertex : order.new_vertices)
    if (vertex == kNone) vertex = next++;
  return order;
}

}  // namespace planish
