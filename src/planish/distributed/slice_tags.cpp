#include "planish/distributed/slice_tags.h"

#include <string>

#include "planish/core/error.h"

namespace planish {

namespace {

void require_vertex(std::int32_t vertex, const char* key, std::int64_t total) {
  if (vertex >= 0 && vertex < total) return;
  throw Error(
      ErrorCode::UnusableMesh,
      formatted("{} names vertex {} of {}; vertices are counted from 0", key, vertex, total));
}

}  // namespace

void add_tags(const Ranks& ranks, std::span<const CreaseEdge> creases,
              std::span<const CornerVertex> corners, MeshSlice& slice) {
  agree(ranks, [&] {
    for (const CreaseEdge& crease : creases)
      for (const std::int32_t vertex : {crease.v0, crease.v1})
        require_vertex(vertex, "crease_edges", slice.vertex_total());
    for (const CornerVertex& corner : corners)
      require_vertex(corner.vertex, "corner_vertices", slice.vertex_total());
  });
  std::int64_t next_crease = sum_over(ranks, std::ssize(slice.creases));
  std::int64_t next_corner = sum_over(ranks, std::ssize(slice.corners));
  if (ranks.rank != 0) return;
  for (const CreaseEdge& crease : creases)
    slice.creases.push_back({crease.v0, crease.v1, crease.sharpness, next_crease++});
  for (const CornerVertex& corner : corners)
    slice.corners.push_back({corner.vertex, corner.sharpness, next_corner++});
}

void clear_tags(MeshSlice& slice) {
  slice.creases.clear();
  slice.corners.clear();
}

}  // namespace planish
