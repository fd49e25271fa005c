#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What fit(), evaluate() and reports want to know of a mesh's faces, found once for all of them:
/// that the mesh passes check(), and how its corners meet. Holds as long as faces, tags and the
/// number of vertices stay; positions may change.
struct PreparedMesh {
  RawVector<std::int32_t> vertices;              ///< those that faces name, ascending
  std::shared_ptr<const MeshTopology> topology;  ///< over these vertices, numbered anew
  std::int32_t given_vertex_count = 0;           ///< with unused ones

  [[nodiscard]] bool uses_all() const {
    return static_cast<std::int32_t>(vertices.size()) == given_vertex_count;
  }
};

/// Null where the mesh has a problem that check() reports.
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepare_if_sound(const PolygonMesh& mesh);

/// Throws as require_usable().
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepare_mesh(const PolygonMesh& mesh,
                                                               std::string_view name);

/// Of a mesh whose faces name all vertices and have been found sound; `topology` is its.
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepared_whole(
    const PolygonMesh& mesh, std::shared_ptr<const MeshTopology> topology);

/// A mesh without the vertices that no face names: the given mesh itself where there are none, else
/// a copy.
struct UsedPart {
  std::shared_ptr<const PreparedMesh> prepared;
  std::unique_ptr<const PolygonMesh> copy;
  const PolygonMesh& mesh;
  std::span<const std::int32_t> vertices;  ///< the original index of each vertex, ascending
};

/// `mesh` is the one that was prepared, but for positions, and must outlive the result. Corner tags
/// of unused vertices are dropped.
[[nodiscard]] UsedPart used_part(const PolygonMesh& mesh,
                                 std::shared_ptr<const PreparedMesh> prepared);
UsedPart used_part(PolygonMesh&& mesh, std::shared_ptr<const PreparedMesh> prepared) = delete;

}  // namespace planish
