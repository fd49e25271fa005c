#include "prepare.h"

#include <algorithm>
#include <string>

#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/detect_creases.h"

namespace planish::command {

RepairedMesh prepare(const PolygonMesh& mesh, RepairChoice choice, const CreaseChoice& creases) {
  RepairedMesh prepared;
  if (choice == RepairChoice::Safe) {
    prepared = repair(mesh);
  } else {
    prepared.mesh = mesh;
  }
  if (creases.dihedral_degrees && (choice == RepairChoice::Safe || check(mesh).empty())) {
    prepared.mesh =
        with_detected_creases(prepared.mesh, {.dihedral_degrees = *creases.dihedral_degrees});
  }
  return prepared;
}

RepairedMesh prepare(const PolygonMesh& mesh, const Settings& settings) {
  if (settings.crease_edges.empty() && settings.corner_vertices.empty()) {
    return prepare(mesh, settings.repair, settings.creases);
  }
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
  return prepare(tagged, settings.repair, settings.creases);
}

}  // namespace planish::command
