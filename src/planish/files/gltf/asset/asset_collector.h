#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
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
/// alike; of what else differs the first stays.
class AssetCollector {
 public:
  /// The number of the group that the primitive belongs to. Throws Error{UnreadableInput},
  /// Error{OutOfMemory}.
  int begin_primitive(const JsonPlace& place, const SourcePrimitive& primitive, GltfBudget& budget);
  /// Sets of texture coordinates of the primitive.
  [[nodiscard]] int uv_set_count() const { return static_cast<int>(uvs_.size()); }
  /// Appends its first set, turned to run upwards, and keeps the others.
  void read_uvs(std::vector<glm::dvec2>& first);
  /// The vertex of the mesh that stands for one of the primitive's.
  std::int32_t weld(Welder& welder, const glm::dvec3& position, std::int64_t vertex);
  [[nodiscard]] AssetVertices finish();

 private:
  struct Source {
    GltfAccessor accessor;
    std::size_t array;  // of AssetVertices
  };
  struct Target {
    JsonPlace place;
    GltfAccessor moves;
  };

  void find_uvs(const JsonPlace& attributes, const SourcePrimitive& primitive, GltfBudget& budget);
  void find_arrays(const JsonPlace& attributes, const SourcePrimitive& primitive,
                   GltfBudget& budget);
  void find_joints(const SourcePrimitive& primitive, GltfBudget& budget);
  void find_targets(const JsonPlace& place, const SourcePrimitive& primitive, GltfBudget& budget);
  // How the current primitive's vertex moves, into influences_ and moves_.
  void read_motion(std::int64_t vertex);
  [[nodiscard]] bool moves_like(std::int32_t welded, const glm::dvec3& position) const;
  void append(std::int64_t vertex);

  AssetVertices made_;
  std::map<std::string, int, std::less<>> group_of_;  // by what a primitive has besides vertices
  std::int64_t next_primitive_ = 0, vertex_count_ = 0;
  std::unordered_map<std::int32_t, std::int32_t> apart_;  // the next vertex at the same place

  // Of the current primitive.
  std::vector<GltfAccessor> uvs_;
  std::vector<JsonPlace> uv_places_;
  std::vector<Source> arrays_;
  std::vector<JointSet> joints_;
  std::vector<std::optional<Target>> targets_;
  std::vector<JointWeight> influences_;
  std::vector<glm::dvec3> moves_;
};

}  // namespace planish
