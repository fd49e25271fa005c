#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "planish/files/gltf/asset/asset_layers.h"
#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/gltf/gltf_primitive.h"
#include "planish/files/shared/weld.h"

namespace planish {

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

}  // namespace planish
