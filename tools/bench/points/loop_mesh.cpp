// Based on: C. Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987.
#include "bench/points/loop_mesh.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <stdexcept>
#include <vector>

namespace planish::bench {
namespace {

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

}  // namespace planish::bench
