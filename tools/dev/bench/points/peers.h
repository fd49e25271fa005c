#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// A mesh of triangles after `rounds` Loop subdivisions, which OpenSubdiv does. Throws
/// std::invalid_argument for other faces.
[[nodiscard]] PolygonMesh loop_subdivided(const PolygonMesh& mesh, int rounds);

/// A mesh in the form that meshoptimizer takes.
class MeshoptimizerMesh {
 public:
  MeshoptimizerMesh(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

  /// meshopt_simplify() with that target error, relative to the mesh's largest side.
  [[nodiscard]] std::vector<Triangle> simplified(double target_error) const;

 private:
  std::vector<float> positions_;
  std::vector<unsigned> indices_;
};

/// A target error for meshoptimizer and how far its result is from the farthest point, in the
/// points' unit.
struct SimplifyTarget {
  double target_error = 0, distance = 0;
};

/// The largest target error, to a tenth, with which meshoptimizer's result is no farther from any
/// point than `distance`, measured as planish measures itself. Where even the smallest target's
/// result is farther, the largest target that comes as near as that one; `distance` of the result
/// is then above the given one. Throws std::runtime_error when the smallest leaves no triangle.
[[nodiscard]] SimplifyTarget target_error_for(const MeshoptimizerMesh& mesh,
                                              std::span<const glm::dvec3> positions,
                                              double distance);

}  // namespace planish::bench
