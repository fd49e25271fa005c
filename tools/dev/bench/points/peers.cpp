#include "bench/points/peers.h"

#include <meshoptimizer.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "planish/reconstruct/spatial_search.h"

namespace planish::bench {
namespace {

// Based on: C. Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987.

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// What OpenSubdiv's refiner averages.
struct Position {
  glm::dvec3 place{0.0};
  void Clear() { place = glm::dvec3(0.0); }
  void AddWithWeight(const Position& other, float weight) {
    place += static_cast<double>(weight) * other.place;
  }
};

}  // namespace

PolygonMesh loop_subdivided(const PolygonMesh& mesh, int rounds) {
  std::vector<int> sizes;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    sizes.push_back(static_cast<int>(mesh.face(f).size()));
    if (sizes.back() != 3) throw std::invalid_argument("Loop subdivision needs triangles");
  }
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(mesh.positions.size());
  descriptor.numFaces = static_cast<int>(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = mesh.face_vertices.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_LOOP, {})));
  refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(rounds));
  std::vector<Position> coarse;
  for (const glm::dvec3& p : mesh.positions) coarse.push_back({p});
  const Far::PrimvarRefiner primvars(*refiner);
  for (int level = 1; level <= rounds; ++level) {
    std::vector<Position> fine(refiner->GetLevel(level).GetNumVertices());
    primvars.Interpolate(level, coarse, fine);
    coarse = std::move(fine);
  }
  PolygonMesh result;
  for (const Position& position : coarse) result.positions.push_back(position.place);
  const Far::TopologyLevel& last = refiner->GetLevel(rounds);
  for (int f = 0; f < last.GetNumFaces(); ++f) {
    const auto corners = last.GetFaceVertices(f);
    result.add_face(std::vector<std::int32_t>{corners[0], corners[1], corners[2]});
  }
  return result;
}

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
