#pragma once

#include <cstdint>
#include <optional>
#include <vector>

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
/// What triangles look like: halves of quads, as those of cut grids do and those of scans do not.
enum class Halves { No, Maybe, Plain };

/// Whether a fit of quads is worth its time (Maybe), and one of triangles is not unless that of
/// quads folds (Plain), of a sound mesh of which most faces are triangles, else neither (No). Looks
/// at some hundreds of vertices: pairs of triangles that both would take the other first have to
/// leave four faces around kHalvedShare of those where the mesh is neither flat nor sharp,
/// kPlainShare or all of kPlainAll for Plain. Where it is flat or sharp nearly everywhere, as parts
/// are, nothing can be said: Maybe.
[[nodiscard]] Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                 std::optional<double> crease_degrees);

/// The same of each part of a mesh, in the order of mesh_parts().
[[nodiscard]] std::vector<Halves> look_halved_by_parts(const PolygonMesh& mesh,
                                                       const PreparedMesh& prepared,
                                                       std::optional<double> crease_degrees);

}  // namespace planish
