#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/distributed/read_slices.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Vertices of one block: the unit of work, and of what ranks own. 3.7 % more faces as ghosts.
inline constexpr std::int64_t kBlockVertices = 65536;

/// The vertices along the Hilbert curve of their box. A vertex's number is its place; ties go by
/// the number in the file, so that the order is the same for every rank count.
struct CurveOrder {
  Layout layout;                        ///< of numbers; ranks are cut between blocks
  std::vector<std::int64_t> file_ids;   ///< of this rank's run: numbers in the file
  std::vector<glm::dvec3> positions;    ///< of this rank's run
  std::vector<glm::vec4> colors;        ///< of this rank's run, where the mesh has some
  std::vector<std::int64_t> number_of;  ///< of this rank's slice of the file
};

/// Takes the slice's positions and colours. Sample sort: no rank ever holds more than about its
/// share.
[[nodiscard]] CurveOrder order_along_curve(const Ranks& ranks, MeshSlice& slice,
                                           std::int64_t block_vertices = kBlockVertices);

/// A tagged edge at a vertex of the part, by local numbers; -1: no vertex of the part, so no edge.
struct PartCrease {
  std::int32_t v0, v1;
  float sharpness;
  std::int64_t index;
  std::int64_t file_v0, file_v1;
};

/// A tagged vertex.
struct PartCorner {
  std::int32_t vertex;
  float sharpness;
  std::int64_t index;
};

/// What rides on a part; empty where the mesh has none.
struct PartAttributes {
  std::vector<glm::vec4> colors;       ///< linear RGBA, by local vertex
  std::vector<std::int64_t> uv_ids;    ///< texture coordinates here: numbers in the file, ascending
  std::vector<glm::dvec2> uvs;         ///< their values
  std::vector<std::int32_t> face_uvs;  ///< one per corner: a place in these; -1: none there
  std::vector<FaceGroup> groups;       ///< of the whole mesh
  std::vector<std::int32_t> face_groups;  ///< one per face
};

/// What one rank works on: a run of vertices along the curve, and two rings of faces around them.
/// Local vertices are the owned ones by number, then the ghosts by number. Faces ascend with their
/// numbers in the file, whatever the ranks, so that sums over them have the same bits.
struct MeshPart {
  Layout layout;  ///< of numbers
  int rank = 0;
  std::vector<std::int64_t> ghosts;    ///< numbers, ascending
  std::vector<std::int64_t> file_ids;  ///< by local vertex: its number in the file
  std::vector<glm::dvec3> positions;   ///< by local vertex
  std::vector<std::int64_t> face_ids;  ///< numbers in the file, ascending
  std::vector<std::int32_t> face_offsets{0}, face_vertices;  ///< local vertices
  std::vector<std::int32_t> first_around, faces_around;      ///< by local vertex: its faces
  std::vector<PartCrease> creases;                           ///< ascending by index
  std::vector<PartCorner> corners;
  /// Those at ghosts, for whoever needs the whole of a face: an edge may be in both lists.
  std::vector<PartCrease> ghost_creases;
  std::vector<PartCorner> ghost_corners;
  std::vector<std::int64_t> holes;  ///< faces of the whole mesh that are not shown, ascending
  PartAttributes attributes;

  [[nodiscard]] std::int32_t owned_count() const {
    return static_cast<std::int32_t>(layout[rank + 1] - layout[rank]);
  }
  [[nodiscard]] std::int32_t vertex_count() const {
    return static_cast<std::int32_t>(file_ids.size());
  }
  [[nodiscard]] std::int32_t face_count() const {
    return static_cast<std::int32_t>(face_ids.size());
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::int32_t index) const {
    return std::span(face_vertices)
        .subspan(face_offsets[index], face_offsets[index + 1] - face_offsets[index]);
  }
  [[nodiscard]] std::span<const std::int32_t> around(std::int32_t vertex) const {
    return std::span(faces_around)
        .subspan(first_around[vertex], first_around[vertex + 1] - first_around[vertex]);
  }
  [[nodiscard]] std::int64_t number_of(std::int32_t vertex) const {
    return vertex < owned_count() ? layout[rank] + vertex : ghosts[vertex - owned_count()];
  }
  /// The first of the face's vertices along the curve, whose rank and block the face belongs to.
  [[nodiscard]] std::int32_t first_vertex(std::int32_t face) const {
    return *std::ranges::min_element(this->face(face), {},
                                     [&](std::int32_t v) { return number_of(v); });
  }
  [[nodiscard]] bool is_hole(std::int32_t face) const {
    return std::ranges::binary_search(holes, face_ids[face]);
  }
  /// -1 for a number that is not here.
  [[nodiscard]] std::int32_t local_of(std::int64_t number) const;
};

/// Faces on their way, by numbers along the curve: id, size, corners, texture coordinates of the
/// corners and the group where the mesh has them, id, size, ...
using FaceStream = RawVector<std::int64_t>;

/// How a face stands there.
struct FaceForm {
  explicit FaceForm(const SliceAttributes& attributes)
      : has_uvs(attributes.has_uvs), has_groups(attributes.has_groups) {}

  /// Numbers of a face.
  [[nodiscard]] std::int64_t length(std::int64_t size) const {
    return 2 + size * (has_uvs ? 2 : 1) + (has_groups ? 1 : 0);
  }
  bool has_uvs, has_groups;
};

/// Sends each face to the owners of all its vertices: the first ring. Takes the slice's faces, with
/// what rides on them;
/// numbers of its tags in the file become numbers along the curve.
[[nodiscard]] FaceStream send_first_ring(const Ranks& ranks, MeshSlice& slice,
                                         const CurveOrder& order);

/// Asks the owners of the other vertices of those faces for the faces around them: the second ring;
/// then fetches what is to be known of all vertices. Throws AgreedError{OutOfMemory} where a rank's
/// part is more than 32 bits count.
[[nodiscard]] MeshPart make_part(const Ranks& ranks, FaceStream first_ring, MeshSlice& slice,
                                 CurveOrder order);

/// Fetches ghost_creases and ghost_corners from the owners of ghosts.
void fetch_ghost_tags(const Ranks& ranks, MeshPart& part);

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
