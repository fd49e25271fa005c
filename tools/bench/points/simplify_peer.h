#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/reconstruct/triangles.h"

namespace planish::bench {

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

/// The largest target error, to a tenth, with which meshoptimizer's result is no farther from any
/// point than `distance`, all measured as planish measures itself. Throws std::runtime_error when
/// even the smallest is farther.
[[nodiscard]] double target_error_for(const MeshoptimizerMesh& mesh,
                                      std::span<const glm::dvec3> positions, double distance);

}  // namespace planish::bench
