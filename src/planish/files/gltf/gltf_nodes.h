#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"

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

}  // namespace planish
