#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "planish/fair/interpolation_method.h"
#include "planish/mesh/pair_triangles.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/mesh/repair.h"
#include "planish/pipeline/found_creases.h"

namespace planish {

/// What changes a mesh on its way to the fit.
struct Preparation {
  /// Mends what check() reports; and see weld_short_edges() and without_flat_triangles().
  bool repairs = true;
  bool uses_tags = true;                 ///< else edges and vertices lose theirs
  bool finds_features = false;           ///< and tags them: see find_features()
  std::optional<double> crease_degrees;  ///< sharp are edges whose faces turn by more, too
  InterpolationMethod method = InterpolationMethod::Progressive;
  std::optional<double> weld;  ///< see weld_vertices()
  /// Of the mesh that comes out, in place of a search.
  const FoundCreases* found = nullptr;
  bool pairs_triangles = false;                    ///< see with_paired_triangles()
  std::span<const std::uint8_t> may_join{};        ///< where; see PairOptions
  bool stands_alone = true;                        ///< see MeshFitOptions
  std::function<void(double)> features_done = {};  ///< told parts of 1, for these take a while
};

/// A mesh to be fitted, with what was found of it. The lists of source vertices and faces are empty
/// where nothing was welded, repaired or cut.
struct ReadyMesh : RepairedMesh {
  std::int64_t welded_count = 0;
  std::int64_t paired_count = 0;                 ///< diagonals that went
  FoundCreases found;                            ///< and tagged
  std::shared_ptr<const PreparedMesh> prepared;  ///< null where it cannot be used
};

/// How triangles are joined for a fit: edges that may be found as creases, which turn by more than
/// `crease_degrees`, stay.
[[nodiscard]] PairOptions pair_options(std::optional<double> crease_degrees,
                                       std::span<const std::uint8_t> may_join = {});

/// The mesh that is fitted: without tags where they are to be ignored, welded where that is asked
/// for, repaired where that is, and then with mirrored charts cut, with its triangles paired, with
/// creases detected where an angle is given, and for fair surfaces, which fold beside corners that
/// turn inward and around tips of slits, with concave faces cut and such tips made corners where
/// repair may. A mesh that remains unusable comes back as it is, for require_usable() to refuse.
/// Throws what repair() throws, and then leaves `mesh` as it is, or welded.
[[nodiscard]] ReadyMesh make_ready(PolygonMesh&& mesh, const Preparation& choice);

/// What that does where triangles are paired, of a mesh that is ready otherwise and has no found
/// creases. False, and nothing is done, where none are.
bool pair_up(ReadyMesh& ready, std::optional<double> crease_degrees,
             std::span<const std::uint8_t> may_join = {});

/// What that does for fair surfaces alone, of a mesh that is ready otherwise and has no found
/// creases.
void make_fair(ReadyMesh& ready);

/// "use", "ignore", "auto" or "auto:40": what is sharp besides boundaries, as flags and reports say
/// it.
[[nodiscard]] std::string creases_text(bool uses_tags, bool finds_features,
                                       std::optional<double> crease_degrees);

}  // namespace planish
