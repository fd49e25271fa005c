#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// What decides; see pipeline/README.md.
inline constexpr double kHalvedShare = 0.8;  ///< of the vertices that are looked at
/// The same, of as many at least, where they are plainly halves: no mesh is known whose surface was
/// better without joining them then.
inline constexpr double kPlainShare = 0.9;
inline constexpr std::int64_t kPlainCount = 50;
/// So many are enough where all of them are: of triangles of which four fifths look so, 20 do once
/// in 87 times.
inline constexpr std::int64_t kPlainAll = 20;
/// Of 1 and the triangles' bending: rounding. A surface that bends by less is flat everywhere.
inline constexpr double kSameBending = 1e-6;

/// Whether at least half of the faces are triangles.
[[nodiscard]] bool are_mostly_triangles(const PolygonMesh& mesh);

/// What triangles look like: halves of quads, as those of cut grids do and those of scans do not.
enum class Halves { No, Maybe, Plain };

/// Whether a fit of quads is worth its time (Maybe), and one of triangles is not unless that of
/// quads folds (Plain), of a sound mesh of which most faces are triangles. Looks at some hundreds
/// of vertices: pairs of triangles that both would take the other first have to leave four faces
/// around kHalvedShare of those where the mesh is neither flat nor sharp, kPlainShare or all of
/// kPlainAll for Plain. Where it is flat or sharp nearly everywhere, as parts are, nothing can be
/// said: Maybe.
[[nodiscard]] Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                 std::optional<double> crease_degrees);

/// Of a surface at level 2: long quads bend between the places of level 1.
struct BendingFigures {
  bool converged = false;
  double bending = 0, folded_area = 0;  ///< see SurfaceQuality; what the input does not fold
};

/// Which of two surfaces through the same vertices was taken, that of the triangles or that of
/// quads made of them, and why.
struct QuadReason {
  bool are_better = false;                         ///< the quads
  std::optional<BendingFigures> triangles, quads;  ///< empty: only one surface was made
  std::string text;                                ///< in a line, for people
};

/// Takes the quads where their surface converges and folds no more than the other, or that does
/// not converge, and bends less, by more than kSameBending, or not at all: flat quads are fewer and
/// carry texture coordinates straight. Bending belongs to a surface alone: normals are measured
/// against faces, which triangles follow into the creases along their diagonals.
[[nodiscard]] QuadReason choose_quads(const BendingFigures& triangles, const BendingFigures& quads);

}  // namespace planish
