#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/host_scope.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/triangle_tree.h"
#include "planish/reconstruct/witnessed_mesh.h"

namespace planish {

// Every point looks for its nearest triangle from that of the point before it. All results are the
// same for every thread count; all functions throw Error{Cancelled}.

/// Fills mesh.carriers. Returns the points, none of them at a vertex, that are farther than
/// `limit`, ascending. Both are lengths; the tolerance is not below the limit.
[[nodiscard]] std::vector<std::int32_t> find_carriers(const OrderedPoints& points,
                                                      WitnessedMesh& mesh, double tolerance,
                                                      double limit, LoopProgress& progress);

/// Those of `asked` that are farther than `limit`, a length, from the mesh; in the same order.
[[nodiscard]] std::vector<std::int32_t> points_beyond(const OrderedPoints& points,
                                                      std::span<const std::int32_t> asked,
                                                      const WitnessedMesh& mesh, double limit);

/// Of all points to triangles whose corners are indices of `points`; so is `farthest`.
[[nodiscard]] PointDistances measure_distances(const OrderedPoints& points,
                                               std::span<const Triangle> triangles);

}  // namespace planish
