#include "planish/vulkan/host/surface_records.h"

#include "planish/doosabin/surface_stencils.h"

namespace planish::vulkan {

SurfaceRecords::SurfaceRecords(const PolygonMesh& mesh, const SystemOptions& options)
    : topology(std::make_shared<const MeshTopology>(mesh)),
      features(find_sharp_features(mesh, *topology, mesh.positions, options.sharp)),
      patch_mesh(*topology, features),
      weights(options.weights),
      patches(patch_mesh, {.level = options.level, .weights = options.weights}) {}

void SurfaceRecords::take_sharp_rows(const PolygonMesh& mesh, const Subdivision& subdivision) {
  const RowRange rows{patch_mesh.first_sharp(), patch_mesh.state_size() - patch_mesh.first_sharp()};
  sharp_rows.emplace(first_step_table(mesh, subdivision, rows));
}

}  // namespace planish::vulkan
