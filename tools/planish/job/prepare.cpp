#include "job/prepare.h"

#include <algorithm>
#include <string>
#include <utility>

#include "planish/core/error.h"

namespace planish::command {

ReadyMesh prepare(PolygonMesh&& mesh, const Settings& settings, InterpolationMethod method) {
  const Preparation choice{settings.repair == RepairChoice::Safe,
                           settings.creases.use_tags,
                           settings.creases.dihedral_degrees,
                           method,
                           settings.weld,
                           {}};
  if (settings.crease_edges.empty() && settings.corner_vertices.empty())
    return make_ready(std::move(mesh), choice);
  const auto require_vertex = [&](std::int32_t vertex, const char* key) {
    if (vertex < mesh.vertex_count()) return;
    throw Error(ErrorCode::UnusableMesh, std::string(key) + " of the scene names vertex " +
                                             std::to_string(vertex) + " of " +
                                             std::to_string(mesh.vertex_count()));
  };
  PolygonMesh tagged = mesh;
  for (const CreaseEdge& crease : settings.crease_edges) {
    require_vertex(std::max(crease.v0, crease.v1), "crease_edges");
    tagged.creases.push_back(crease);
  }
  for (const CornerVertex& corner : settings.corner_vertices) {
    require_vertex(corner.vertex, "corner_vertices");
    tagged.corners.push_back(corner);
  }
  return make_ready(std::move(tagged), choice);
}

}  // namespace planish::command
