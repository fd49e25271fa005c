#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_form.h"
#include "planish/queries/surface_queries.h"

namespace planish::command {

/// What `query` answers to one of its points.
struct QueryAnswer {
  glm::dvec3 position{}, normal{};  ///< without an answer the point that was asked for, and 0
  double distance = -1;             ///< of a closest point, or t of a ray
  SurfaceParameter at{.face = -1};  ///< without an answer -1
  PointCurvature curvature;         ///< of closest points in JSON
};

/// What is done with the next bytes of the answers.
using TakeBytes = std::function<void(std::string_view)>;

/// The answers to some questions that follow one another.
using Answer = std::function<void(std::span<const glm::dvec3> points, std::span<QueryAnswer>)>;

/// Binary PLY without faces: x, y, z, nx, ny, nz, `distance_name`, face, u, v, one vertex an
/// answer. Some thousand answers at a time, as the JSON below.
void answers_ply(std::span<const glm::dvec3> points, const Answer& answer,
                 std::string_view distance_name, const TakeBytes& take);

/// The text of `head` with a list of answers more, by the name `list`: of closest points with
/// curvatures, or of what rays hit, where `distance_name` is "t". The same bytes as if all of it
/// were one JSON value, in the memory of some answers.
void answers_json(const nlohmann::ordered_json& head, std::string_view list,
                  std::span<const glm::dvec3> points, const Answer& answer,
                  std::string_view distance_name, const TakeBytes& take);

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
