#include "planish/surface/subdivided_mesh.h"

#include <algorithm>
#include <vector>

#include "planish/mesh/check.h"
#include "planish/surface/memory_need.h"

namespace planish {

namespace {

// Splits down to the level asked for and finds what is sharp.
SharpFeatures refine_split(const UsedMesh& used, QuadSplit& split, const EvaluateOptions& options) {
  require_memory(split.counts_to(std::max(options.level, 1)), LastLevel::FacesOnly,
                 RefinedAttributes::of(used.mesh), options.memory_limit_bytes);
  split.refine(options.level);
  std::vector<glm::dvec3> rest = used.mesh.positions;
  if (!options.rest_positions.empty()) {
    for (std::size_t v = 0; v < rest.size(); ++v)
      rest[v] = options.rest_positions[used.vertices[v]];
  }
  return find_sharp_features(used.mesh, split, rest, options.sharp);
}

}  // namespace

UsedMesh usable_part(const PolygonMesh& mesh) {
  require_usable(mesh, "control cage");
  return without_unused_vertices(mesh);
}

SubdividedMesh::SubdividedMesh(const PolygonMesh& mesh, const EvaluateOptions& options)
    : used(usable_part(mesh)),
      split(used.mesh),
      features(refine_split(used, split, options)),
      subdivision(split, features, options.weights) {}

}  // namespace planish
