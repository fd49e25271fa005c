#include "planish/limit/surface_queries.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/safe_length.h"
#include "planish/limit/closest_point.h"
#include "planish/limit/ray_search.h"

namespace planish {
namespace {

constexpr std::size_t kQuestionGrain = 64;

bool is_finite(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void require_finite(const glm::dvec3& point, std::size_t index) {
  if (is_finite(point)) return;
  throw Error(ErrorCode::InvalidArgument, formatted("point {} is not finite", index));
}

// From here on the surface is one point, in unit coordinates.
constexpr double kFarthest = 1e100;

// In unit coordinates. From so far that squares are too large for double, the surface is one point;
// of a small one the coordinates of such a place are themselves too large.
glm::dvec3 nearby(const glm::dvec3& point, const Placement& placement) {
  const glm::dvec3 unit = placement.to_unit(point);
  const double far = safe_length(unit);
  if (far <= kFarthest) return unit;
  if (std::isfinite(far)) return unit * (kFarthest / far);
  constexpr double kSmall = 0x1p-600;  // the centre does not count from there
  const glm::dvec3 small = point * kSmall;
  return small * (kFarthest / safe_length(small));
}

void require_room(std::string_view name, std::size_t points, std::size_t answers) {
  if (points == answers) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: there are {} points, and room for {} answers", name, points, answers));
}

// Calls answer(search, i) for each of the points.
template <class Answer>
void ask_each(const CornerTree& tree, std::size_t kept_corners, std::span<const glm::dvec3> points,
              const Answer& answer) {
  parallel_for(points.size(), kQuestionGrain, [&](std::size_t begin, std::size_t end) {
    NearestSearch search(tree, kept_corners);
    for (std::size_t i = begin; i < end; ++i) {
      require_finite(points[i], i);
      answer(search, i);
    }
  });
}

ClosestPoint closest_point(NearestSearch& search, const LimitSurface& surface,
                           const glm::dvec3& point) {
  const NearestPlace place = search.run(nearby(point, surface.surface().placement()));
  ClosestPoint result;
  result.at = surface_parameter(surface.topology(), place.corner, place.u, place.v);
  const SurfacePoint on = surface.evaluate(result.at);
  result.position = on.position;
  result.normal = on.normal;
  result.distance = safe_length(point - on.position);
  return result;
}

struct UnitRay {
  glm::dvec3 origin, direction;
  double t_min, t_max, length;  // length: of one t
};

UnitRay unit_ray(const SurfaceRay& ray, const Placement& placement) {
  const double length = safe_length(ray.direction);
  if (!is_finite(ray.origin) || !std::isfinite(length) || !(length > 0)) {
    throw Error(ErrorCode::InvalidArgument,
                "the ray has no finite origin or no direction of a length above 0");
  }
  const double scale = length / placement.diagonal;
  return {placement.to_unit(ray.origin), ray.direction / length, ray.t_min * scale,
          ray.t_max * scale, scale};
}

std::vector<SurfaceHit> hits_of(const CornerTree& tree, const SurfaceRay& ray, RayAnswer wanted) {
  const LimitSurface& surface = tree.surface();
  const UnitRay unit = unit_ray(ray, surface.surface().placement());
  RaySearch search(tree);
  std::vector<SurfaceHit> hits;
  for (const RayPlace& place :
       search.run(unit.origin, unit.direction, unit.t_min, unit.t_max, wanted)) {
    SurfaceHit hit;
    hit.at = surface_parameter(surface.topology(), place.corner, place.u, place.v);
    const SurfacePoint on = surface.evaluate(hit.at);
    hit.position = on.position;
    hit.normal = on.normal;
    hit.t = place.t / unit.length;
    hit.is_tangent = place.is_tangent;
    hits.push_back(hit);
  }
  return hits;
}

}  // namespace

SurfaceQueries::SurfaceQueries(const LimitSurface& surface) : tree_(surface) {
  if (tree_.nodes().empty())
    throw Error(ErrorCode::UnusableMesh, "the surface has no faces: all of the mesh's are holes");
}

ClosestPoint SurfaceQueries::closest(const glm::dvec3& point) const {
  require_finite(point, 0);
  NearestSearch search(tree_);
  return closest_point(search, surface(), point);
}

void SurfaceQueries::closest(std::span<const glm::dvec3> points,
                             std::span<ClosestPoint> result) const {
  require_room("closest", points.size(), result.size());
  ask_each(tree_, 1, points, [&](NearestSearch& search, std::size_t i) {
    result[i] = closest_point(search, surface(), points[i]);
  });
}

void SurfaceQueries::distances(std::span<const glm::dvec3> points, std::span<double> result) const {
  require_room("distances", points.size(), result.size());
  const Placement& placement = surface().surface().placement();
  ask_each(tree_, NearestSearch::kManyCorners, points, [&](NearestSearch& search, std::size_t i) {
    const glm::dvec3 unit = placement.to_unit(points[i]);
    result[i] = safe_length(unit) <= kFarthest
                    ? placement.diagonal * std::sqrt(search.run(unit).square_distance)
                    : closest_point(search, surface(), points[i]).distance;
  });
}

// By parity of hits, each way by other directions where one touches the surface.
bool SurfaceQueries::is_inside(const glm::dvec3& point) const {
  constexpr int kTries = 8;
  glm::dvec3 direction(0.8191, 0.4233, 0.3874);
  for (int i = 0; i < kTries; ++i) {
    const auto hits = hits_of(tree_, {point, direction}, RayAnswer::All);
    bool is_clear = true;
    for (const SurfaceHit& hit : hits) is_clear &= !hit.is_tangent;
    if (is_clear) return hits.size() % 2 == 1;
    direction = glm::normalize(glm::dvec3(direction.y + 0.1, -direction.z, direction.x - 0.2));
  }
  return false;
}

double SurfaceQueries::signed_distance(const glm::dvec3& point) const {
  const ClosestPoint nearest = closest(point);
  // At a sharp edge the nearest side's own normal can point the wrong way.
  const DooSabinSurface& surface = this->surface().surface();
  const bool is_smooth = surface.patches().features().sharp_edge_count == 0;
  const bool inside =
      is_smooth ? glm::dot(point - nearest.position, nearest.normal) < 0 : is_inside(point);
  return inside ? -nearest.distance : nearest.distance;
}

std::optional<SurfaceHit> SurfaceQueries::first_hit(const SurfaceRay& ray) const {
  const auto hits = hits_of(tree_, ray, RayAnswer::First);
  if (hits.empty()) return std::nullopt;
  return hits.front();
}

std::vector<SurfaceHit> SurfaceQueries::all_hits(const SurfaceRay& ray) const {
  return hits_of(tree_, ray, RayAnswer::All);
}

bool SurfaceQueries::is_occluded(const SurfaceRay& ray) const {
  return !hits_of(tree_, ray, RayAnswer::Any).empty();
}

}  // namespace planish
