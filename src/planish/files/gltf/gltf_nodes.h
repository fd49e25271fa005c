#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <vector>

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

/// The meshes of the default scene (scene 0 where none is named; without scenes, of all nodes
/// that are no children), parents first, each as often as EXT_mesh_gpu_instancing places it. Every
/// node may be reached once. Throws Error{UnreadableInput}.
[[nodiscard]] std::vector<GltfInstance> gltf_instances(const JsonPlace& root, GltfSource& source);

}  // namespace planish
