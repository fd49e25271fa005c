#include "planish/surface/subdivided_mesh.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "planish/mesh/check.h"
#include "planish/mesh/sound_topology.h"
#include "planish/surface/memory_need.h"

namespace planish {

namespace {

// Splits down to the level asked for and finds what is sharp.
SharpFeatures refine_split(const UsedPart& used, QuadSplit& split, const EvaluateOptions& options) {
  require_memory(split.counts_to(std::max(options.level, 1)), LastLevel::FacesOnly,
                 RefinedAttributes::of(used.mesh), options.memory_limit_bytes);
  split.refine(options.level);
  if (options.rest_positions.empty())
    return find_sharp_features(used.mesh, split, used.mesh.positions, options.sharp);
  if (used.prepared->uses_all())
    return find_sharp_features(used.mesh, split, options.rest_positions, options.sharp);
  std::vector<glm::dvec3> rest(used.vertices.size());
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = options.rest_positions[used.vertices[v]];
  return find_sharp_features(used.mesh, split, rest, options.sharp);
}

}  // namespace

UsedPart usable_part(const PolygonMesh& mesh, std::shared_ptr<const PreparedMesh> prepared) {
  constexpr const char* kName = "control cage";
  if (!prepared) return used_part(mesh, prepare_mesh(mesh, kName));
  if (!positions_are_finite(mesh)) require_usable(mesh, kName);
  return used_part(mesh, std::move(prepared));
}

EvaluateOptions first_level(const SharpFeatureOptions& sharp) {
  EvaluateOptions options{.level = 0};
  options.sharp = sharp;
  return options;
}

SubdividedMesh::SubdividedMesh(const PolygonMesh& mesh, const EvaluateOptions& options)
    : used(usable_part(mesh, options.prepared)),
      split(used.mesh, used.prepared->topology),
      features(refine_split(used, split, options)),
      subdivision(split, features, options.weights) {}

}  // namespace planish
