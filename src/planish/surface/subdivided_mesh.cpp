#include "planish/surface/subdivided_mesh.h"

#include <utility>

#include "planish/mesh/check.h"
#include "planish/mesh/mesh_arrays.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

UsedPart usable_part(const PolygonMesh& mesh, std::shared_ptr<const PreparedMesh> prepared) {
  constexpr const char* kName = "control cage";
  if (!prepared) return used_part(mesh, prepare_mesh(mesh, kName));
  if (!positions_are_finite(mesh) || !attributes_are_sound(arrays_of(mesh)))
    require_usable(mesh, kName);
  return used_part(mesh, std::move(prepared));
}

SubdividedMesh::SubdividedMesh(const PolygonMesh& mesh, const SharpFeatureOptions& sharp,
                               std::shared_ptr<const PreparedMesh> prepared,
                               std::shared_ptr<const SharpFeatures> found)
    : used(usable_part(mesh, std::move(prepared))),
      features(found ? std::move(found)
                     : std::make_shared<const SharpFeatures>(find_sharp_features(
                           used.mesh, *used.prepared->topology, used.mesh.positions, sharp))),
      subdivision(*used.prepared->topology, *features, Weights::DooSabin) {}

}  // namespace planish
