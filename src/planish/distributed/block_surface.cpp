#include "planish/distributed/block_surface.h"

#include "planish/distributed/part_fair.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

BlockSurface::BlockSurface(const MeshPart& part, std::span<const glm::dvec3> cage,
                           const SubMesh& sub, const PartTilesOptions& options)
    : cage_(sub.mesh) {
  for (std::size_t v = 0; v < sub.vertices.size(); ++v)
    cage_.positions[v] = cage[static_cast<std::size_t>(sub.vertices[v])];
  EvaluateOptions evaluate;
  evaluate.weights = options.weights;
  evaluate.sharp = options.sharp;
  evaluate.rest_positions = sub.mesh.positions;
  evaluate.prepared = prepared_whole(cage_, topology_of_sound(cage_));
  if (options.fair == nullptr) {
    surface_.emplace(cage_, options.placement, evaluate);
    return;
  }
  const MeshTopology& topology = *evaluate.prepared->topology;
  const SharpFeatures features =
      find_sharp_features(sub.mesh, topology, sub.mesh.positions, options.sharp);
  level_one_ = level_one_of(part, *options.fair, sub, topology, features);
  surface_.emplace(cage_, level_one_, evaluate);
}

}  // namespace planish
