#include "bench/points/simplify_peer.h"

#include <meshoptimizer.h>

#include <cmath>
#include <stdexcept>

#include "planish/reconstruct/triangle_tree.h"

namespace planish::bench {

MeshoptimizerMesh::MeshoptimizerMesh(std::span<const glm::dvec3> positions,
                                     std::span<const Triangle> triangles) {
  positions_.reserve(3 * positions.size());
  for (const glm::dvec3& p : positions)
    for (int axis = 0; axis < 3; ++axis) positions_.push_back(static_cast<float>(p[axis]));
  indices_.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (const std::int32_t corner : t) indices_.push_back(static_cast<unsigned>(corner));
}

std::vector<Triangle> MeshoptimizerMesh::simplified(double target_error) const {
  std::vector<unsigned> result(indices_.size());
  result.resize(meshopt_simplify(result.data(), indices_.data(), indices_.size(), positions_.data(),
                                 positions_.size() / 3, 3 * sizeof(float), 0,
                                 static_cast<float>(target_error), 0, nullptr));
  std::vector<Triangle> triangles(result.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i)
    triangles[i / 3][i % 3] = static_cast<std::int32_t>(result[i]);
  return triangles;
}

double target_error_for(const MeshoptimizerMesh& mesh, std::span<const glm::dvec3> positions,
                        double distance) {
  double low = 1e-7, high = 1e-2;
  const auto holds = [&](double target) {
    const std::vector<Triangle> triangles = mesh.simplified(target);
    return !triangles.empty() && measure_distances(positions, positions, triangles).max <= distance;
  };
  if (!holds(low)) throw std::runtime_error("meshoptimizer: no target error is small enough");
  while (high / low > 1.1) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace planish::bench
