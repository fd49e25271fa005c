#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_halo.h"
#include "planish/distributed/sub_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/level_one.h"

namespace planish {

struct PartFairOptions {
  FitOptions fit;  ///< weights, sharp, polish_steps, cures_folds, within and tolerance count
  Placement placement;
  std::span<const glm::dvec3> points;  ///< to pass through, by local vertex; none: the part's
  std::int64_t block_vertices = kBlockVertices;
  std::function<void()> after_exchange;  ///< a sign of life
};

/// The fair surface of a rank's part: control points of level 1 at all corners of its faces, and on
/// curves. Figures are of the whole mesh.
struct PartFair : FairFigures {
  std::vector<glm::dvec3> state;  ///< per corner of the part, then by `keys`
  std::vector<CurveKey> keys;     ///< sorted; those at the part's rim say nothing
  Placement placement;            ///< in whose coordinates the state is
  ErrorNorms error;
  bool converged = false;
  std::int64_t concave_faces = 0;
};

/// bend_least() with exchanges, of the part's positions: the points that options.fit.within leaves
/// the surface to pass through, by local vertex, none where it leaves none. The part needs its
/// ghosts' tags. Throws AgreedError as make_part_fair().
struct PartWithin {
  std::optional<WithinFit> figures;
  std::vector<glm::dvec3> points;
};
[[nodiscard]] PartWithin bend_part_least(const Ranks& ranks, const MeshPart& part,
                                         const PartFairOptions& options);

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
