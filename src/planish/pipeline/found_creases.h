#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/mesh/detect_creases.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/pipeline/fit.h"

namespace planish {

/// How a mesh's creases were found, and the tags that it had before.
struct FoundCreases {
  CreaseDetectionOptions options;
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;
};

/// Tags the creases and corners that the shape suggests, as with_detected_creases(). `prepared` is
/// the mesh's, and stays so.
[[nodiscard]] FoundCreases add_found_creases(PolygonMesh& mesh, const PreparedMesh& prepared,
                                             const CreaseDetectionOptions& options);

/// Finds them anew, but neither creases that end at one of these vertices nor corners there.
void leave_smooth(PolygonMesh& mesh, const PreparedMesh& prepared, const FoundCreases& found,
                  std::span<const std::int32_t> smoothed_vertices);

/// Whether creases are looked for that are clear, and whether a mesh may be meant as a ball, as one
/// of polygons may: where triangles were joined to these, some of its edges were smooth.
enum class CreaseTrial { None, NotOfBalls, All };

/// What add_clear_creases() found.
struct ClearCreases {
  std::optional<FoundCreases> found;
  bool are_of_balls = false;  ///< all edges would be sharp of are_coarse_balls(): none is found
  bool are_apart = false;     ///< all other edges turn by less than is looked for, and by far less
};

/// The same with the default options where the creases are clear, else none, and the mesh as it
/// was. They are clear where the mesh had no tags, where by far the most of what its faces turn is
/// at them (of the squares of all turns, weighted by the faces' areas), as on parts with flat and
/// round faces, or where they are apart from all other edges, as the rim of a cut ball is, and
/// where an edge is smooth or the mesh none of are_coarse_balls(), which turn at all of their
/// edges, unless `trial` is All.
[[nodiscard]] ClearCreases add_clear_creases(PolygonMesh& mesh,
                                             const std::shared_ptr<const PreparedMesh>& prepared,
                                             CreaseTrial trial);

/// Of CreaseDetectionOptions: no edge is sharp, but corners of outlines are, which turn by more
/// than kOutlineCornerDegrees then, as those of a hexagon do, and apexes of cones.
inline constexpr double kOutlineDegrees = 180, kOutlineCornerDegrees = 45;

/// How edges that turn by more than `degrees` are found, by default or as a user asks.
[[nodiscard]] CreaseDetectionOptions crease_detection(double degrees);

/// Tags the corners that outlines have beyond doubt (see outline_corners()), and cone_apexes(), as
/// with_detected_creases() by kOutlineDegrees with the vertices that are returned left smooth.
/// Nothing where there are none: the mesh is as it was. `prepared` is the mesh's, and stays so.
[[nodiscard]] std::optional<std::vector<std::int32_t>> add_outline_corners(
    PolygonMesh& mesh, const std::shared_ptr<const PreparedMesh>& prepared);
/// The same corners again, of a mesh with other faces but the same vertices.
void tag_outline_corners(PolygonMesh& mesh, const PreparedMesh& prepared,
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
