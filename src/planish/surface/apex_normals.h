#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where a surface has no normal: at corners that no boundary, and no edge with a tag, ends at, as
/// a cone's apex. Figures take the one that is beside it in each face.
class ApexNormals {
 public:
  /// Of a surface of `mesh`, which passes check() and must outlive it.
  explicit ApexNormals(const PolygonMesh& mesh);

  /// The place of such a vertex of a face of the mesh, or null; of several the last.
  [[nodiscard]] const glm::dvec3* apex_of(std::int32_t face) const;

 private:
  const PolygonMesh& mesh_;
  std::vector<std::uint8_t> is_apex_;  // by vertex; empty where there is none
};

/// Puts, in the corner of a surface's face that lies at `apex`, if one does, the direction of the
/// sum of both normals beside it in place of its own.
void leave_out_apex(const glm::dvec3& apex, std::span<const glm::dvec3> positions,
                    std::span<glm::vec3> normals);

}  // namespace planish
