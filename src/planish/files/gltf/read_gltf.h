#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/weld.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where a node stands in its parent. Throws Error{UnreadableInput}.
[[nodiscard]] glm::dmat4 local_transform(const JsonPlace& node);

/// A mesh as a node places it.
struct GltfInstance {
  std::int64_t mesh, node;
  glm::dmat4 to_world;
};

/// What a scene shows.
struct GltfScene {
  std::vector<GltfInstance> instances;
  std::int64_t hidden_count = 0;  ///< meshes that KHR_node_visibility hides, none of those above
};

/// The meshes of the default scene (scene 0 where none is named; without scenes, of all nodes
/// that are no children), parents first, each as often as EXT_mesh_gpu_instancing places it. Every
/// node may be reached once. Throws Error{UnreadableInput}.
[[nodiscard]] GltfScene gltf_scene(const JsonPlace& root, GltfSource& source);

/// "empty-scene" where the default scene has no mesh in a file that has some. Throws as above.
[[nodiscard]] std::optional<Warning> empty_scene_warning(const JsonPlace& root);

/// For each joint of a skin, what takes a vertex that it alone moves from the mesh to where the
/// file's nodes stand. Throws Error{UnreadableInput}.
/// Source: Khronos Group, "glTF 2.0 Specification", section 3.7.3.
[[nodiscard]] std::vector<glm::dmat4> joint_matrices(const JsonPlace& root, std::int64_t skin,
                                                     GltfSource& source);

/// JOINTS_n and WEIGHTS_n of a primitive.
struct JointSet {
  JsonPlace place;
  GltfAccessor joints, weights;
};

/// The accessors of a primitive, whether its bytes lie plain or are packed by Draco. Where there
/// are both, the plain ones are read. Every member throws Error{UnreadableInput}.
class SourcePrimitive {
 public:
  /// Unpacks what is packed; `primitive` must have positions, and must live longer.
  SourcePrimitive(const JsonPlace& root, const JsonPlace& primitive, GltfSource& source);

  [[nodiscard]] const GltfAccessor& positions() const { return *positions_; }
  [[nodiscard]] std::optional<GltfAccessor> indices() const;
  /// Empty where there is none; else as many elements as positions.
  [[nodiscard]] std::optional<GltfAccessor> attribute(std::string_view name,
                                                      GltfAccessor::Use use) const;

  /// The accessor of a morph target's attribute: one element for each position.
  [[nodiscard]] GltfAccessor target(const JsonPlace& place, GltfAccessor::Use use) const;

  /// JOINTS_0 and WEIGHTS_0, JOINTS_1 and WEIGHTS_1 ...: four of each, for each position.
  [[nodiscard]] std::vector<JointSet> joint_sets() const;

  /// A vertex in the world.
  [[nodiscard]] glm::dvec3 position(std::int64_t vertex, const GltfInstance& instance) const;
  /// An element of the attribute COLOR_0.
  [[nodiscard]] glm::vec4 color(const GltfAccessor& colors, std::int64_t vertex) const;

 private:
  void unpack();
  [[nodiscard]] GltfAccessor accessor(const JsonPlace& place, std::string_view name,
                                      GltfAccessor::Use use) const;

  const JsonPlace& root_;
  const JsonPlace& place_;
  GltfSource& source_;
  std::optional<DracoMesh> unpacked_;
  std::map<std::string, std::int64_t, std::less<>> identifiers_;  // of packed attributes
  std::optional<GltfAccessor> positions_;
};

/// Appends the joints of a vertex that have a weight, in the order of the file. Throws
/// Error{UnreadableInput}.
void append_influences(std::span<const JointSet> sets, std::int64_t vertex,
                       std::vector<JointWeight>& to);

/// What joints make of a vertex: a mean of joint_matrices() by its weights. One without any has the
/// first joint. Throws Error{UnreadableInput}.
[[nodiscard]] glm::dmat4 posed(std::span<const JointSet> sets, std::int64_t vertex,
                               std::span<const glm::dmat4> joints);

/// A normal in the world, of any length.
[[nodiscard]] glm::dvec3 placed_normal(const glm::dvec3& normal, const GltfInstance& instance);

/// Gathers the vertices of primitives of points.
class GltfPoints {
 public:
  [[nodiscard]] bool empty() const { return positions_.empty(); }
  /// Throws Error{UnreadableInput}.
  void add(const SourcePrimitive& primitive, const GltfInstance& instance);
  /// Points that have none of what others have are white, and without a normal.
  void finish(MeshFile& file);

 private:
  std::vector<glm::dvec3> positions_;
  std::vector<glm::vec3> normals_;  // up to the last given
  std::vector<glm::vec4> colors_;
};

/// Faces of a primitive: those of face f are corners[ends[f - 1]] to corners[ends[f]].
struct PrimitiveFaces {
  std::vector<std::int32_t> ends;
  std::vector<std::int32_t> corners;  ///< of the primitive, in its order

  void add(std::span<const std::int32_t> face) {
    corners.insert(corners.end(), face.begin(), face.end());
    ends.push_back(static_cast<std::int32_t>(corners.size()));
  }
  void clear() { ends.clear(), corners.clear(); }
  [[nodiscard]] std::size_t count() const { return ends.size(); }
  [[nodiscard]] std::span<const std::int32_t> face(std::size_t f) const {
    const auto begin = static_cast<std::size_t>(f == 0 ? 0 : ends[f - 1]);
    return std::span(corners).subspan(begin, static_cast<std::size_t>(ends[f]) - begin);
  }
};

/// Primitives on faces that others have already, as decals and coats are: a further material on the
/// same surface. While a mesh is read, and then joined with what its corners have.
class AssetLayers {
 public:
  /// What the layers' corners have, by the numbers of vertices that AssetCollector gives.
  struct Given {
    /// TEXCOORD_0, TEXCOORD_1 ...
    std::vector<std::vector<glm::dvec2>> uvs;
    std::vector<AssetUvMoves> uv_moves;
    std::vector<AssetArray> arrays;  ///< of_corners
  };

  /// Faces that follow in the mesh are of primitives of a kind: with the same material.
  void begin_kind(std::int32_t first_face, int kind);
  /// Whether every face of a primitive is one of `mesh`, with the same vertices in the same order
  /// round, and none has its kind: then it is a layer, which add() makes it. `vertices`: of the
  /// mesh, by corner of the primitive.
  [[nodiscard]] bool find(const PolygonMesh& mesh, const PrimitiveFaces& faces,
                          std::span<const std::int32_t> vertices, int kind);
  /// The primitive that was found last. `numbers`: of vertices, by corner of the primitive.
  void add(const PolygonMesh& mesh, const PrimitiveFaces& faces,
           std::span<const std::int32_t> numbers, AssetLayer layer, int kind);
  [[nodiscard]] bool empty() const { return layers_.empty(); }
  /// Gives corners of the mesh indices by which they have what is the mesh's own and what is of
  /// their layers, and faces groups with their layers.
  void join(PolygonMesh& mesh, AssetVertices& made, const Given& given) const;

 private:
  struct Kind {
    std::int32_t first_face;
    int kind;
  };
  struct Layer {
    AssetLayer made;
    int kind;
  };
  // So many layers lie under these. Negative: a face has none.
  struct Depth {
    std::vector<std::int32_t> layer_of_face;
    std::vector<std::int32_t> numbers;  // by corner of the mesh
  };

  // A face of the mesh, and how far another is turned against it.
  struct Found {
    std::int32_t face = -1;
    std::size_t turn = 0;
  };

  [[nodiscard]] Found face_of(const PolygonMesh& mesh, std::span<const std::int32_t> vertices);
  [[nodiscard]] int kind_of(std::int32_t face) const;
  // Sets of texture coordinates that layers of a depth have.
  [[nodiscard]] int uv_sets_at(int depth) const;
  void join_corners(PolygonMesh& mesh, AssetVertices& made, const Given& given) const;
  void join_groups(PolygonMesh& mesh, AssetVertices& made) const;

  std::vector<Kind> kinds_;  // by first face
  std::vector<Layer> layers_;
  std::vector<Depth> depths_;
  // Faces by their least vertex and the next, and how many of the mesh are here.
  std::unordered_multimap<std::uint64_t, std::int32_t> faces_;
  std::int32_t known_faces_ = 0;
  // Of the primitive that was found last.
  std::vector<Found> found_;
  std::size_t depth_ = 0;
};

/// Gathers what a mesh of an asset has besides a PolygonMesh, while a SceneReader reads its
/// primitives in turn. Vertices at one place are one where joints and morph targets move them
/// alike; what else differs is of corners, each of which has the number of its file's vertex.
/// Primitives on faces that others have become layers of theirs.
class AssetCollector {
 public:
  /// Goes on with a primitive. Throws Error{UnreadableInput}, Error{OutOfMemory}.
  void begin_primitive(const JsonPlace& place, const SourcePrimitive& primitive,
                       GltfBudget& budget);
  /// The vertex of the mesh that stands for one of the primitive's.
  std::int32_t weld(Welder& welder, const glm::dvec3& position, std::int64_t vertex);
  /// What is needed of faces of the primitive, once their corners are welded. `corners`,
  /// `vertices`: by corner of the primitive, its vertex and the mesh's.
  struct Faces {
    const PolygonMesh& mesh;  ///< of the primitives before
    const PrimitiveFaces& faces;
    std::span<const std::int32_t> corners, vertices;
  };
  /// Whether all faces are the mesh's already and the primitive has another material: it becomes a
  /// layer, and adds no face.
  bool add_layer(const Faces& faces, std::vector<glm::dvec2>& first);
  /// Where it adds some: numbers its vertices, those of all primitives in turn. Texture coordinates
  /// and what differs at one place go by these; the first set goes to `first`, turned to run
  /// upwards. Returns the number of its group.
  int add_faces(const Faces& faces, std::vector<glm::dvec2>& first);
  /// The number of the first vertex of the primitive that was added last.
  [[nodiscard]] std::int64_t first_number() const { return numbered_.back().first; }
  /// Of the mesh that was read, whose corners have the numbers of their vertices as those of
  /// texture coordinates: they keep those that something goes by.
  [[nodiscard]] AssetVertices finish(PolygonMesh& mesh);

 private:
  struct Source {
    GltfAccessor accessor;
    std::size_t array;  // of AssetVertices
  };
  struct Target {
    JsonPlace place;
    GltfAccessor moves;
  };
  // Moves of texture coordinates of the current primitive.
  struct UvSource {
    JsonPlace place;
    GltfAccessor moves;
    std::size_t of;  // AssetVertices::uv_moves
  };
  // Numbers of a primitive's vertices, and what it has for them.
  struct Numbered {
    std::int64_t first, count;
    bool is_layer, has_uvs;
    std::vector<Source> arrays;
    std::vector<std::size_t> uv_moves;  // of AssetVertices
  };

  void find_uvs(const JsonPlace& attributes, const SourcePrimitive& primitive, GltfBudget& budget);
  void find_arrays(const JsonPlace& attributes, const SourcePrimitive& primitive,
                   GltfBudget& budget);
  void add_array(const JsonPlace& place, const GltfAccessor& values, const AssetArray& kind,
                 GltfBudget& budget);
  void find_joints(const SourcePrimitive& primitive, GltfBudget& budget);
  void find_targets(const JsonPlace& place, const SourcePrimitive& primitive, GltfBudget& budget);
  void find_target(const JsonPlace& target, std::size_t number, const SourcePrimitive& primitive,
                   GltfBudget& budget);
  void number_vertices(const Faces& faces, bool is_layer, std::vector<glm::dvec2>& first);
  [[nodiscard]] std::vector<float> by_numbers(std::size_t array) const;
  void settle(AssetArray& array) const;
  void keep_numbers(PolygonMesh& mesh) const;
  AssetLayers::Given take_layers(const std::vector<glm::dvec2>& uvs);
  // How the current primitive's vertex moves, into influences_ and moves_.
  void read_motion(std::int64_t vertex);
  [[nodiscard]] bool moves_like(std::int32_t welded, const glm::dvec3& position) const;
  void append();

  AssetVertices made_;
  std::map<std::string, int, std::less<>> kinds_;  // what primitives have besides vertices
  std::map<int, int> group_of_;                    // by kind
  std::int64_t next_primitive_ = 0, vertex_count_ = 0;
  std::unordered_map<std::int32_t, std::int32_t> apart_;  // the next vertex at the same place
  std::vector<Numbered> numbered_;
  std::vector<std::int32_t> vertex_of_;  // by number; -1: no face has it, or only a layer's
  AssetLayers layers_;
  std::set<std::string> lost_targets_;  // attributes of morph targets

  // Of the current primitive.
  std::int64_t number_ = 0;  // in the mesh
  int kind_ = 0;
  std::int64_t count_ = 0;     // of its vertices
  bool is_on_others_ = false;  // none of its vertices is new
  std::vector<GltfAccessor> uvs_;
  std::vector<JsonPlace> uv_places_;
  std::vector<Source> arrays_;
  std::vector<UvSource> uv_moves_;
  std::vector<JointSet> joints_;
  std::vector<std::optional<Target>> targets_;
  std::vector<JointWeight> influences_;
  std::vector<glm::dvec3> moves_;
};

/// Reads triangles, or points where there are none, of meshes as nodes place them; welded by exact
/// position over all of them. Everything that it is given must live longer.
class SceneReader {
 public:
  SceneReader(JsonPlace root, GltfSource& source, GltfBudget budget, const FileBytes& file)
      : root_(std::move(root)),
        source_(source),
        budget_(std::move(budget)),
        creases_from_normals_(file.split_normals_crease),
        bytes_(file.bytes.size()),
        progress_(file.progress) {}

  /// The default scene.
  [[nodiscard]] MeshFile read(FileFormat format);
  /// A mesh in its own coordinates; `asset` gets what no PolygonMesh has.
  [[nodiscard]] MeshFile read_mesh(FileFormat format, std::int64_t mesh, AssetCollector& asset);

 private:
  [[nodiscard]] MeshFile read(FileFormat format, std::span<const GltfInstance> instances);
  void read_instance(const GltfInstance& instance, std::size_t bytes);
  void read_primitive(const JsonPlace& place, const GltfInstance& instance, std::size_t bytes);
  void read_point_primitive(const JsonPlace& place, const GltfInstance& instance);
  [[nodiscard]] GltfInstance placed(std::int64_t vertex, const GltfInstance& instance) const;
  void name_group(const JsonPlace& place);
  void read_uvs(const JsonPlace& place, const SourcePrimitive& primitive);
  void read_normals(const SourcePrimitive& primitive, const GltfInstance& instance);
  void color_vertices(const SourcePrimitive& primitive);
  void find_faces(const JsonPlace& place, std::int64_t mode, bool mirrored);
  void find_polygons(bool mirrored);
  void add_faces();
  std::int32_t welded(const SourcePrimitive& primitive, std::int64_t vertex,
                      const GltfInstance& instance);

  JsonPlace root_;
  GltfSource& source_;
  GltfBudget budget_;
  Welder welder_;
  TriangleCollector triangles_;
  AttributeCollector attributes_;
  AssetCollector* asset_ = nullptr;
  bool creases_from_normals_;
  std::size_t bytes_;
  ReadProgress* progress_;
  std::vector<glm::dmat4> joints_;    // of the current instance's skin; empty: it has none
  std::vector<JointSet> joint_sets_;  // of the current primitive, where there are joints
  CornerNormals normals_;
  GltfPoints points_;
  std::vector<glm::dvec2> uvs_;
  std::int64_t first_uv_ = -1, first_normal_ = -1;  // of the current primitive; -1: it has none
  // By corner of the current primitive: its vertex, and what that is welded to.
  std::vector<std::int32_t> corners_, vertices_;
  PrimitiveFaces faces_;
  MeshFile file_;
  std::vector<std::string> material_names_;
  std::set<std::string> lost_of_points_;  // what points have that no mesh is made with
  std::int64_t colored_count_ = 0, shared_count_ = 0, first_shared_ = -1;
  std::int64_t deformed_count_ = 0, point_primitive_count_ = 0, primitive_count_ = 0;
  // By vertex of the current primitive: its welded vertex, valid where the stamp is the current.
  std::vector<std::int32_t> welded_vertices_;
  std::vector<std::int64_t> stamps_;
  std::int64_t stamp_ = 0;
  // By welded vertex: the last polygon that had it.
  std::vector<std::int64_t> polygon_of_;
  std::int64_t polygon_number_ = 0;
};

/// Throws Error{UnreadableInput} for a version but 2.x, for one that needs a later reader, and for
/// an extension that the file requires and nobody here reads.
void require_gltf_version(const JsonPlace& root);

/// Reads a .glb or .gltf file: the triangles of the default scene (scene 0 where none is named)
/// with all node transforms applied, of skinned meshes those of their joints, welded by position
/// across primitives; what KHR_node_visibility hides is left out. Texture
/// coordinates (TEXCOORD_0) stay with the corners, colours (COLOR_0) with the vertices, material
/// names become groups. External buffers are read from beside the file only; absolute and parent
/// paths are refused.
/// Without a path buffers must be embedded (GLB chunk or data URI).
/// Throws Error{UnreadableInput}: what is out of range, its JSON path and value;
/// Error{OutOfMemory} for a scene that needs more than the machine has free.
[[nodiscard]] MeshFile read_gltf(const FileBytes& file);

/// The same within other limits.
[[nodiscard]] MeshFile read_gltf_within(const FileBytes& file, const GltfLimits& limits);

}  // namespace planish
