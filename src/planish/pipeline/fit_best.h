#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planish/pipeline/fit.h"
#include "planish/pipeline/found_creases.h"
#include "planish/surface/surface_quality.h"

namespace planish {

/// The mesh that a fair surface is made of, and its connectivity where that is at hand.
struct FairMesh {
  PolygonMesh mesh;
  std::shared_ptr<const PreparedMesh> prepared;
  std::optional<FoundCreases> found;  ///< where creases were: for fit_with_found_creases()
};

/// The better of the two surfaces through a mesh's vertices, and why.
struct BestFit {
  Fit fit;
  InterpolationMethod method = InterpolationMethod::Progressive;
  /// That `fit` is of, where it is fair; else it is of the given mesh.
  std::optional<PolygonMesh> fair_mesh;
  std::vector<std::int32_t> smoothed_vertices;  ///< of fair_mesh, see CreasedFit
  // At level 1, against the mesh's faces; empty: not tried.
  std::optional<SurfaceQuality> progressive, fair;
  std::string reason;  ///< in a line, for people: without figures of level 1 beside the surface's

  /// The mesh that `fit` is of.
  [[nodiscard]] const PolygonMesh& mesh(const PolygonMesh& given) const {
    return fair_mesh ? *fair_mesh : given;
  }
};

/// What decides, of surfaces at level 1 against the mesh's faces; see pipeline/details.md.
inline constexpr double kSoundFoldedArea = 1e-5;  ///< folds of less are none
inline constexpr double kCloseDegrees = 1;        ///< normals nearer to the faces' need no rival
inline constexpr double kClearlyBetter = 0.96;    ///< of the other's deviation

/// Fits by the progressive method and measures the surface at level 1; where it converges, does not
/// fold (but where the input does itself) and its normals are within kCloseDegrees rms of the
/// faces', that is all. Else fits by the fair method too and takes that, unless the progressive
/// surface does not fold, at level 2 either, and its normals are off by less than kClearlyBetter of
/// what fair's are, or fair folds more. That much because normals are measured against the mesh's
/// own faces, which the progressive method follows more closely even where it is no nearer to the
/// shape.
///
/// `are_found_sharp`: sharp edges were found, not given. Then the fair surface comes first, which
/// takes them back where it folds for them, and is taken where it converges and does not fold.
///
/// `make_fair_mesh` is called at most once, for the mesh that the fair surface is of: without it
/// with_cusp_corners() of with_convex_faces(). Only warnings of the fit that is taken are given.
/// Throws as fit(), whatever options.method is.
[[nodiscard]] BestFit fit_best(const PolygonMesh& mesh, Backend& backend,
                               const FitOptions& options = {},
                               const std::function<FairMesh()>& make_fair_mesh = {},
                               bool are_found_sharp = false);

}  // namespace planish
