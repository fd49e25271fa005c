#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The faces around a run of a part's vertices as a mesh of their own. Vertices and faces are in
/// the order of the file, so that planish's functions sum in the same order as on the whole mesh.
/// A vertex at the rim whose faces here form several fans has a copy for each, one next to the
/// other; those that are not at the rim are left as they are, right or wrong.
struct SubMesh {
  PolygonMesh mesh;                    ///< with positions, and the tags at vertices of the run
  std::vector<std::int32_t> vertices;  ///< of each vertex: the part's
  std::vector<std::int32_t> faces;     ///< of each face: the part's
  std::vector<std::uint8_t> is_own;    ///< of each face, with Rings::Whole: it would be in None
  std::int32_t copy_count = 0;
};

/// The connectivity of a sub mesh, whose faces have been found sound.
[[nodiscard]] std::shared_ptr<const MeshTopology> topology_of_sound(const PolygonMesh& mesh);

/// Which faces a sub mesh has.
enum class Rings {
  None,  ///< those whose first vertex along the curve is in the run
  One,   ///< those with a vertex in the run
  Two,   ///< and those that share a vertex with one of them
  /// Those of Two, with the tags at all vertices whose faces are all there.
  TwoTagged,
  /// Those of None, which come with all that meets them: the others share a vertex with one of
  /// them. Tags are those at their vertices, ghosts' too, and the mesh has its attributes.
  Whole,
};

/// Makes sub meshes of one part, one after another.
class SubMeshMaker {
 public:
  explicit SubMeshMaker(const MeshPart& part);

  /// Of the owned vertices [begin, end), by local number.
  [[nodiscard]] SubMesh make(std::int32_t begin, std::int32_t end, Rings rings = Rings::Two);

 private:
  void take_around(std::int32_t vertex, std::vector<std::int32_t>& faces);
  void take_vertices(std::span<const std::int32_t> faces, std::vector<std::int32_t>& vertices);
  void choose_faces(std::int32_t begin, std::int32_t end, Rings rings);
  void take_own(std::int32_t begin, std::int32_t end);
  void number_vertices(SubMesh& sub);
  void list_rim();
  void split_fans(std::int32_t vertex, SubMesh& sub);
  void add_tags(std::int32_t begin, std::int32_t end, SubMesh& sub);
  void add_whole(SubMesh& sub);
  void add_all_tags(SubMesh& sub);
  [[nodiscard]] bool is_edge(std::int32_t v0, std::int32_t v1) const;

  struct RimCorner {
    std::int32_t vertex, corner, next, last;  // by local numbers
  };

  const MeshPart& part_;
  std::int32_t stamp_ = 0;  // of the sub mesh in the making
  std::vector<std::int32_t> face_stamps_, vertex_stamps_, whole_stamps_;  // in it; all around too
  std::vector<std::int32_t> faces_, vertices_;  // of the part, in the making
  std::vector<std::int32_t> first_vertices_;    // of each face, once one is asked for
  std::vector<std::int32_t> own_;               // of the faces those of the run, ascending
  std::vector<std::int32_t> numbers_;           // by vertex of the part: that in the sub mesh
  std::vector<RimCorner> rim_;                  // of the sub mesh in the making, by vertex
  std::vector<std::int32_t> corner_numbers_;    // by corner of the part, of vertices with copies
};

}  // namespace planish
