#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/gltf/gltf_primitive.h"
#include "planish/files/shared/weld.h"

namespace planish {

/// Gathers what a mesh of an asset has besides a PolygonMesh, while a SceneReader reads its
/// primitives in turn. Vertices at one place are one where joints and morph targets move them
/// alike; what else differs is of corners, each of which has the number of its file's vertex.
class AssetCollector {
 public:
  /// The number of the group that the primitive belongs to. Throws Error{UnreadableInput},
  /// Error{OutOfMemory}.
  int begin_primitive(const JsonPlace& place, const SourcePrimitive& primitive, GltfBudget& budget);
  /// Sets of texture coordinates of the primitive.
  [[nodiscard]] int uv_set_count() const { return static_cast<int>(uvs_.size()); }
  /// Numbers its vertices, those of all primitives in turn: texture coordinates and what differs at
  /// one place go by these. Its first set goes to `first`, turned to run upwards; keeps the others.
  /// Returns the number of its first vertex.
  std::int64_t number_vertices(std::int64_t count, std::vector<glm::dvec2>& first);
  /// The vertex of the mesh that stands for one of the primitive's.
  std::int32_t weld(Welder& welder, const glm::dvec3& position, std::int64_t vertex);
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
  // The current primitive's numbers of corners, and what it has for them.
  struct Numbered {
    std::int64_t first, count;
    bool has_uvs;
    std::vector<Source> sources;
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
  void compare(std::int32_t welded, std::int64_t vertex);
  // The numbers of a vertex of the current primitive in an array.
  [[nodiscard]] float number(const Source& source, std::int64_t vertex, int k) const;
  void give_corners(AssetArray& array, std::size_t index) const;
  void keep_numbers(PolygonMesh& mesh) const;
  // How the current primitive's vertex moves, into influences_ and moves_.
  void read_motion(std::int64_t vertex);
  [[nodiscard]] bool moves_like(std::int32_t welded, const glm::dvec3& position) const;
  void append(std::int64_t vertex);

  AssetVertices made_;
  std::map<std::string, int, std::less<>> group_of_;  // by what a primitive has besides vertices
  std::int64_t next_primitive_ = 0, vertex_count_ = 0;
  std::unordered_map<std::int32_t, std::int32_t> apart_;  // the next vertex at the same place
  std::vector<bool> differs_;                             // by array: at one place
  std::vector<Numbered> numbered_;
  std::int64_t number_count_ = 0;
  std::set<std::string> lost_targets_;  // attributes of morph targets

  // Of the current primitive.
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
