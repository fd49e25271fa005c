#include "job/questions.h"

#include <charconv>
#include <cmath>

#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/parallel.h"
#include "planish/core/refuse.h"
#include "planish/core/safe_length.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

constexpr std::size_t kAnswerGrain = 16;

}  // namespace

glm::dvec3 parse_direction(const std::string& text) {
  const auto fail = [&] {
    refuse("--rays", "\"" + visible(text) + "\" is no direction such as 0,0,-1");
  };
  glm::dvec3 direction(0.0);
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int d = 0; d < 3; ++d) {
    const auto [next, error] = std::from_chars(at, end, direction[d]);
    if (error != std::errc() || next == (d < 2 ? end : nullptr)) fail();
    if (d < 2 ? *next != ',' : next != end) fail();
    at = next + 1;
  }
  const double length = safe_length(direction);
  if (!(length > 0) || !std::isfinite(length)) fail();
  return direction;
}

std::vector<glm::dvec3> questions_of(PointCloud cloud, const std::string& path) {
  if (cloud.missing_count > 0) {
    throw Error(
        ErrorCode::UnreadableInput,
        formatted(
            "{}: {} of its points are not finite, and there is one answer a point; leave them out",
            visible(path), cloud.missing_count));
  }
  for (glm::dvec3& point : cloud.points) point += cloud.origin;
  return std::move(cloud.points);
}

void answer_closest(const SurfaceQueries& queries, std::span<const glm::dvec3> points,
                    bool with_curvature, std::span<QueryAnswer> answers) {
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  parallel_for(points.size(), kAnswerGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ClosestPoint& found = closest[i];
      answers[i] = {found.position, found.normal, found.distance, found.at, {}};
      if (with_curvature) answers[i].curvature = queries.surface().evaluate(found.at).curvature();
    }
  });
}

void answer_rays(const SurfaceQueries& queries, const glm::dvec3& direction,
                 std::span<const glm::dvec3> points, std::span<QueryAnswer> answers) {
  parallel_for(points.size(), kAnswerGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      answers[i].position = points[i];
      if (const auto hit = queries.first_hit({points[i], direction}))
        answers[i] = {hit->position, hit->normal, hit->t, hit->at, {}};
    }
  });
}

}  // namespace planish::command
