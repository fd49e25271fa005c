#pragma once

#include <array>
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

/// What was found to be sharp of a mesh, its own tags aside: edges by their vertices, the smaller
/// first, and corners; both ascending.
struct FoundCreases {
  std::vector<std::array<std::int32_t, 2>> edges;
  std::vector<std::int32_t> corners;

  [[nodiscard]] bool is_empty() const { return edges.empty() && corners.empty(); }
};

/// Tags it. Throws Error{UnusableMesh} for what is no vertex of the mesh.
void add_tags(PolygonMesh& mesh, const FoundCreases& found);

/// Tags what find_features() finds. `prepared` is the mesh's, and stays so.
[[nodiscard]] FoundCreases add_features(PolygonMesh& mesh,
                                        const std::shared_ptr<const PreparedMesh>& prepared,
                                        const FeatureRules& rules = {},
                                        const std::function<void(double)>& done = {});

/// Takes back what was found at one of these vertices, of the tags and of `found`.
void leave_smooth(PolygonMesh& mesh, FoundCreases& found, std::span<const std::int32_t> vertices);

/// The share of the area that may fold before all found creases are taken back, part of it before
/// as large a part of them is, but for a few: an edge that is rounded is seen from far, a fold of
/// so little is not.
inline constexpr double kWorthAllCreases = 3e-3;

/// A fair surface whose creases only help.
struct CreasedFit {
  Fit fit;
  FoundCreases found;  ///< what was not taken back
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
