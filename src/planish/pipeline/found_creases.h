#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/features/find_features.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/pipeline/fit.h"

namespace planish {

/// The creases and corners that were found of a mesh, those that it was tagged with aside.
struct FoundCreases {
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;
};

/// Tags what find_features() finds. `prepared` is the mesh's, and stays so.
[[nodiscard]] FoundCreases add_features(PolygonMesh& mesh,
                                        const std::shared_ptr<const PreparedMesh>& prepared,
                                        const FeatureRules& rules = {},
                                        const std::function<void(double)>& done = {});

/// Takes back found creases that end at one of these vertices, and found corners there.
void leave_smooth(PolygonMesh& mesh, const FoundCreases& found,
                  std::span<const std::int32_t> smoothed_vertices);

/// The share of the area that may fold before all found creases are taken back, part of it before
/// as large a part of them is, but for a few: an edge that is rounded is seen from far, a fold of
/// so little is not.
inline constexpr double kWorthAllCreases = 3e-3;

/// A fair surface whose creases only help.
struct CreasedFit {
  Fit fit;
  /// Ascending: found creases with an end at one of them were taken back, and corners there.
  std::vector<std::int32_t> smoothed_vertices;
};

/// Fits by the fair method a mesh whose creases were found. Where the surface is folded at level 3
/// (see DeepLook), found creases around are taken back, four rounds at most; where folds
/// remain, all of them; each time if the folds, by the worst of levels 1 to 3, are worth it (see
/// kWorthAllCreases). `mesh` has the tags of what is given out then. A mesh that does not fold
/// costs a look at its folds. options.prepared is the mesh's, or null. Warnings are those of the
/// fit that is given out; throws as fit().
[[nodiscard]] CreasedFit fit_with_found_creases(PolygonMesh& mesh, const FoundCreases& found,
                                                Backend& backend, const FitOptions& options);

}  // namespace planish
