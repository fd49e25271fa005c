#include "planish/distributed/vertex_order.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

#include "planish/core/parallel.h"
#include "planish/distributed/part_attributes.h"
#include "planish/files/tiles/curve_order.h"

namespace planish {

namespace {

struct CurveVertex {
  std::uint64_t key;
  std::int64_t file_id;
  glm::dvec3 position;

  friend bool operator<(const CurveVertex& a, const CurveVertex& b) {
    return a.key != b.key ? a.key < b.key : a.file_id < b.file_id;
  }
};

using CurveVertices = RawVector<CurveVertex>;

CurveVertices with_keys(const Ranks& ranks, const MeshSlice& slice) {
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (const glm::dvec3& position : slice.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  MPI_Allreduce(MPI_IN_PLACE, &low.x, 3, MPI_DOUBLE, MPI_MIN, ranks.comm);
  MPI_Allreduce(MPI_IN_PLACE, &high.x, 3, MPI_DOUBLE, MPI_MAX, ranks.comm);
  const glm::dvec3 extent = high - low;
  const CurveBox box{low, std::max({extent.x, extent.y, extent.z})};
  CurveVertices result(slice.positions.size());
  parallel_each(result.size(), 4096, [&](std::size_t i) {
    result[i] = {hilbert_key(slice.positions[i], box),
                 slice.vertices[ranks.rank] + static_cast<std::int64_t>(i), slice.positions[i]};
  });
  return result;
}

// Where the runs of ranks 1, 2, ... begin, from samples of every rank's sorted vertices.
std::vector<CurveVertex> splitters_of(const Ranks& ranks, const CurveVertices& sorted) {
  constexpr std::size_t kSamples = 64;
  const CurveVertex last{std::numeric_limits<std::uint64_t>::max(), 0, {}};
  std::vector<CurveVertex> samples(kSamples, last), all(kSamples * ranks.size, last);
  for (std::size_t i = 0; i < kSamples && !sorted.empty(); ++i)
    samples[i] = sorted[sorted.size() * i / kSamples];
  constexpr int kBytes = kSamples * sizeof(CurveVertex);
  MPI_Allgather(samples.data(), kBytes, MPI_BYTE, all.data(), kBytes, MPI_BYTE, ranks.comm);
  std::ranges::sort(all, std::less());
  std::vector<CurveVertex> splitters;
  for (int r = 1; r < ranks.size; ++r) splitters.push_back(all[kSamples * r]);
  return splitters;
}

// Ascending over all ranks, in runs of whole blocks.
CurveVertices sorted_in_blocks(const Ranks& ranks, CurveVertices vertices,
                               std::int64_t block_vertices) {
  oneapi::tbb::parallel_sort(vertices.begin(), vertices.end());
  if (ranks.size == 1) return vertices;
  const std::vector<CurveVertex> splitters = splitters_of(ranks, vertices);
  vertices = route<CurveVertex>(ranks, vertices, [&](const CurveVertex& vertex, std::size_t) {
    return static_cast<int>(std::upper_bound(splitters.begin(), splitters.end(), vertex) -
                            splitters.begin());
  });
  oneapi::tbb::parallel_sort(vertices.begin(), vertices.end());
  const auto count = static_cast<std::int64_t>(vertices.size());
  const std::int64_t first = sum_before(ranks, count), total = sum_over(ranks, count);
  Layout shares = even_layout((total + block_vertices - 1) / block_vertices, ranks.size);
  for (std::int64_t& share : shares) share = std::min(share * block_vertices, total);
  return route<CurveVertex>(ranks, vertices, [&](const CurveVertex&, std::size_t i) {
    return owner_of(shares, first + static_cast<std::int64_t>(i));
  });
}

}  // namespace

CurveOrder order_along_curve(const Ranks& ranks, MeshSlice& slice, std::int64_t block_vertices) {
  CurveVertices vertices = with_keys(ranks, slice);
  slice.positions = {};
  vertices = sorted_in_blocks(ranks, std::move(vertices), block_vertices);
  CurveOrder order;
  order.layout = layout_of(ranks, static_cast<std::int64_t>(vertices.size()));
  struct Numbered {
    std::int64_t file_id, number;
  };
  RawVector<Numbered> pairs(vertices.size());
  order.file_ids.resize(vertices.size());
  order.positions.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    order.file_ids[i] = vertices[i].file_id;
    order.positions[i] = vertices[i].position;
    pairs[i] = {vertices[i].file_id, order.layout[ranks.rank] + static_cast<std::int64_t>(i)};
  }
  vertices = {};
  const std::int64_t first = slice.vertices[ranks.rank];
  order.number_of.resize(slice.vertices[ranks.rank + 1] - first);
  pairs = route<Numbered>(ranks, pairs, [&](const Numbered& pair, std::size_t) {
    return owner_of(slice.vertices, pair.file_id);
  });
  for (const Numbered& pair : pairs) order.number_of[pair.file_id - first] = pair.number;
  order.colors = colors_along_curve(ranks, slice.attributes, order);
  return order;
}

}  // namespace planish
