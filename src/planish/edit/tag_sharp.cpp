#include "planish/edit/tag_sharp.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "planish/core/error.h"

namespace planish {

namespace {

void require_sharpness(float sharpness, std::int32_t vertex) {
  if (sharpness == 0 || sharpness == kInfiniteSharpness) return;
  throw Error(ErrorCode::InvalidArgument,
              "set_sharp: the sharpness " + std::to_string(sharpness) + " at vertex " +
                  std::to_string(vertex) + " is neither 0, smooth, nor 10, sharp",
              vertex);
}

std::int32_t used_vertex(const PreparedMesh& prepared, std::int32_t vertex) {
  const auto found = std::ranges::lower_bound(prepared.vertices, vertex);
  if (found != prepared.vertices.end() && *found == vertex)
    return static_cast<std::int32_t>(found - prepared.vertices.begin());
  throw Error(ErrorCode::InvalidArgument, formatted("set_sharp: no face has a vertex {}", vertex),
              vertex);
}

}  // namespace

void tag_sharp(const PreparedMesh& prepared, std::span<const CreaseEdge> edges,
               std::span<const CornerVertex> corners, PolygonMesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, float> of_edge;
  for (const CreaseEdge& edge : edges) {
    require_sharpness(edge.sharpness, edge.v0);
    if (prepared.topology->find_edge(used_vertex(prepared, edge.v0),
                                     used_vertex(prepared, edge.v1)) < 0) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("set_sharp: vertices {} and {} have no edge; name two that follow one "
                            "another in a face",
                            edge.v0, edge.v1),
                  edge.v0);
    }
    of_edge[std::minmax(edge.v0, edge.v1)] = edge.sharpness;
  }
  std::map<std::int32_t, float> of_vertex;
  for (const CornerVertex& corner : corners) {
    require_sharpness(corner.sharpness, corner.vertex);
    (void)used_vertex(prepared, corner.vertex);
    of_vertex[corner.vertex] = corner.sharpness;
  }
  std::erase_if(mesh.creases, [&](const CreaseEdge& crease) {
    return of_edge.contains(std::minmax(crease.v0, crease.v1));
  });
  std::erase_if(mesh.corners,
                [&](const CornerVertex& corner) { return of_vertex.contains(corner.vertex); });
  for (const auto& [ends, sharpness] : of_edge)
    if (sharpness > 0) mesh.creases.push_back({ends.first, ends.second, sharpness});
  for (const auto& [vertex, sharpness] : of_vertex)
    if (sharpness > 0) mesh.corners.push_back({vertex, sharpness});
}

}  // namespace planish
