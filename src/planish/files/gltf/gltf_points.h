#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/gltf/gltf_primitive.h"
#include "planish/files/mesh_file.h"

namespace planish {

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

}  // namespace planish
