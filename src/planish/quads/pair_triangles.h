#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Whether triangles of a mesh are joined to quads; auto: where the surface is better for it.
enum class QuadChoice { Auto, On, Off };

struct PairOptions {
  double largest_turn = 30;    ///< degrees between the two triangles' normals
  double largest_angle = 150;  ///< degrees at a corner of a quad; below 180, so quads are convex
  /// One per face of with_paired_triangles(), 0 where it stays as it is; empty: none has to.
  std::span<const std::uint8_t> may_join{};
};

/// Joins neighbouring triangles to quads: greedily by how near the quad's corners come to right
/// angles, then pairs are exchanged where that leaves two triangles fewer alone. Of quads that are
/// as good, within rounding, all are joined or none, as in fans: neither order nor place nor size
/// decide. Triangles without a partner stay. Each quad begins at an end of the edge that it lost:
/// cut into a fan it is the two triangles again. Positions are copied, unused ones too; the
/// triangles must be an oriented manifold.
[[nodiscard]] PolygonMesh pair_triangles(std::span<const glm::dvec3> positions,
                                         std::span<const Triangle> triangles,
                                         const PairOptions& options = {});

/// A mesh whose triangles have been joined.
struct PairedMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_faces;  ///< for each face of `mesh` the input's, its first half
  std::int64_t pair_count = 0;             ///< of triangles, each a diagonal less
};

/// The same of a mesh with whatever else it has: other faces stay as they are, and so do edges that
/// are tagged, at which texture coordinates or groups part, and where hole faces meet others.
/// Vertices keep their numbers. `prepared` is the mesh's.
[[nodiscard]] PairedMesh with_paired_triangles(const PolygonMesh& mesh,
                                               const PreparedMesh& prepared,
                                               const PairOptions& options = {});

/// What some vertices of a mesh, at most a thousand or two, say of whether its triangles are halves
/// of quads.
struct HalvedVertices {
  std::int64_t looked_at = 0;
  /// Inside the mesh, around which some edge turns and none does by more than may be joined; not
  /// at the rims of flat caps, where the cap and two others would be left.
  std::int64_t telling = 0;
  /// Those of them around which four faces are left where triangles that both would take the other
  /// first are joined.
  std::int64_t regular = 0;
};

/// Takes little more time than to go over the corners once.
[[nodiscard]] HalvedVertices halved_vertices(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                             const PairOptions& options = {});

}  // namespace planish
