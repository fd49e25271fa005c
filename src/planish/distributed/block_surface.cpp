#include "planish/distributed/block_surface.h"

#include <utility>

#include "planish/distributed/part_fair.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

BlockSurface::BlockSurface(const MeshPart& part, std::span<const glm::dvec3> cage,
                           const SubMesh& sub, const PartTilesOptions& options,
                           std::span<const glm::dvec3> limits, const std::vector<glm::vec4>& colors)
    : cage_(sub.mesh) {
  for (std::size_t v = 0; v < sub.vertices.size(); ++v) cage_.positions[v] = cage[sub.vertices[v]];
  EvaluateOptions evaluate;
  evaluate.weights = options.weights;
  evaluate.prepared = prepared_whole(cage_, topology_of_sound(cage_));
  const MeshTopology& topology = *evaluate.prepared->topology;
  evaluate.features = std::make_shared<const SharpFeatures>(
      find_sharp_features(sub.mesh, topology, sub.mesh.positions, options.sharp));
  if (options.fair == nullptr) {
    surface_.emplace(cage_, options.placement, evaluate);
  } else {
    level_one_ = level_one_of(part, *options.fair, sub, topology, *evaluate.features);
    surface_.emplace(cage_, level_one_, evaluate);
  }
  if (limits.empty()) return;
  RawVector<glm::dvec3> of_sub(sub.vertices.size());
  for (std::size_t v = 0; v < of_sub.size(); ++v) of_sub[v] = limits[sub.vertices[v]];
  surface_->take_whole(std::move(of_sub), colors);
}

}  // namespace planish
