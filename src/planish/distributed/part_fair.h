#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_halo.h"
#include "planish/distributed/sub_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/level_one.h"

namespace planish {

struct PartFairOptions {
  FitOptions fit;  ///< weights, sharp, polish_steps, cures_folds and tolerance count
  Placement placement;
  std::int64_t block_vertices = kBlockVertices;
  std::function<void()> after_exchange;  ///< a sign of life
};

/// The fair surface of a rank's part: control points of level 1 at all corners of its faces, and on
/// curves. Figures are of the whole mesh.
struct PartFair {
  std::vector<glm::dvec3> state;  ///< per corner of the part, then by `keys`
  std::vector<CurveKey> keys;     ///< sorted; those at the part's rim say nothing
  Placement placement;            ///< in whose coordinates the state is
  ErrorNorms error;
  bool converged = false;
  std::int64_t shrunk_vertices = 0, reversed_vertices = 0, cured_vertices = 0;
  std::int64_t flagged_edges = 0, flagged_faces = 0;  ///< as FairNet has them
  std::int64_t concave_faces = 0;
};

/// fair_net() and the looks at the finished surface, with exchanges: the bits of one machine but
/// for sums over blocks, which single precision follows; the same for every count of ranks. The
/// part needs its ghosts' tags. Throws AgreedError where a rank cannot make its part's topology.
[[nodiscard]] PartFair make_part_fair(const Ranks& ranks, const MeshPart& part,
                                      const PartFairOptions& options);

/// The control points of a sub mesh of the part, as LevelOne has them. Those on curves that the
/// part does not know, at the sub mesh's rim, stand at their vertices.
[[nodiscard]] LevelOne level_one_of(const MeshPart& part, const PartFair& fair, const SubMesh& sub,
                                    const MeshTopology& topology, const SharpFeatures& features);

}  // namespace planish
