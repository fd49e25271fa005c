#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "job/answers.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/point_cloud.h"

namespace planish::command {

/// The value "0,0,-1" of --rays: three numbers, finite and not all 0. Throws
/// Error{InvalidArgument}.
[[nodiscard]] glm::dvec3 parse_direction(const std::string& text);

/// The points of a file, in its own coordinates. Throws Error{UnreadableInput} where some are not
/// finite, as there is one answer a point.
[[nodiscard]] std::vector<glm::dvec3> questions_of(PointCloud cloud, const std::string& path);

/// One answer a point, on all threads: the closest point of the surface.
void answer_closest(const SurfaceQueries& queries, std::span<const glm::dvec3> points,
                    bool with_curvature, std::span<QueryAnswer> answers);

/// The same: what a ray from there meets first.
void answer_rays(const SurfaceQueries& queries, const glm::dvec3& direction,
                 std::span<const glm::dvec3> points, std::span<QueryAnswer> answers);

}  // namespace planish::command
