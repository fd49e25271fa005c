#include "bench/points/simplify_peer.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planish/reconstruct/triangle_tree.h"

namespace planish::bench {
namespace {

// Quadrics in float carry rounding errors of about 1e-7 of the squared extent. Targets far below
// the root of that, 3e-4, all let the same collapses pass, those whose error rounds to nothing: a
// smaller one would come no nearer to the points.
constexpr double kLeastTarget = 1e-7;
constexpr double kLargestTarget = 1e-2;

}  // namespace

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

SimplifyTarget target_error_for(const MeshoptimizerMesh& mesh,
                                std::span<const glm::dvec3> positions, double distance) {
  const auto farthest = [&](double target) {
    const std::vector<Triangle> triangles = mesh.simplified(target);
    return triangles.empty() ? std::numeric_limits<double>::infinity()
                             : measure_distances(positions, positions, triangles).max;
  };
  SimplifyTarget best{kLeastTarget, farthest(kLeastTarget)};
  if (!std::isfinite(best.distance))
    throw std::runtime_error("meshoptimizer: the smallest target error leaves no triangle");
  const double allowed = std::max(distance, best.distance);
  double high = kLargestTarget;
  while (high / best.target_error > 1.1) {
    const double middle = std::sqrt(best.target_error * high), reached = farthest(middle);
    if (reached <= allowed)
      best = {middle, reached};
    else
      high = middle;
  }
  return best;
}

}  // namespace planish::bench
