#include "planish/files/gltf/strip_order.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Strips this long turn back before the codec, which packs 16 neighbours together, has forgotten
// what lies beside them: of 512 to 2^18 triangles the goblet is smallest with these.
constexpr std::int64_t kBlockTriangles = 2048;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Numbers the vertices of a block by themselves, since the optimiser takes time and memory by them.
class BlockOrder {
 public:
  void operator()(std::span<const std::uint32_t> from, std::span<std::uint32_t> to) {
    slots_.assign(kSlots, kNone);
    vertices_.clear();
    corners_.resize(from.size());
    ordered_.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) corners_[i] = local(from[i]);
    meshopt_optimizeVertexCacheStrip(ordered_.data(), corners_.data(), corners_.size(),
                                     vertices_.size());
    std::ranges::transform(ordered_, to.begin(), [&](std::uint32_t v) { return vertices_[v]; });
  }

 private:
  // More than twice as many as corners.
  static constexpr int kSlotBits = 14;
  static constexpr std::size_t kSlots = std::size_t{1} << kSlotBits;
  static_assert(kSlots > 6 * kBlockTriangles);

  std::uint32_t local(std::uint32_t vertex) {
    constexpr std::uint32_t kGolden = 0x9e3779b9;
    std::size_t slot = vertex * kGolden >> (32 - kSlotBits);
    while (slots_[slot] != kNone && vertices_[slots_[slot]] != vertex) slot = (slot + 1) % kSlots;
    if (slots_[slot] == kNone) {
      slots_[slot] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
    }
    return slots_[slot];
  }

  RawVector<std::uint32_t> corners_, ordered_;
  std::vector<std::uint32_t> slots_, vertices_;
};

}  // namespace

StripOrder strip_order(std::span<const std::uint32_t> indices, std::size_t vertex_count) {
  StripOrder order;
  order.indices.resize(indices.size());
  const std::vector<RowRange> blocks =
      ranges_of(static_cast<std::int64_t>(indices.size() / 3), kBlockTriangles);
  parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    BlockOrder reorder;
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
