#include "planish/queries/limit_surface.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "planish/core/error.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::size_t kPlaceGrain = 256;

// Where tangents are parallel at a point, its normal is that of places so far beside it.
constexpr double kAside = 1.0 / 1024;

glm::dvec3 unit_or_zero(const PatchPoint& point) {
  const double length = glm::length(point.normal);
  const bool is_known = length > 1e-6 * glm::length(point.du) * glm::length(point.dv);
  return is_known && length > 0 ? point.normal / length : glm::dvec3(0.0);
}

}  // namespace

PointCurvature SurfacePoint::curvature() const {
  PatchPoint point;
  point.du = du;
  point.dv = dv;
  point.duu = duu;
  point.duv = duv;
  point.dvv = dvv;
  point.has_second = has_second;
  return curvature_of(point);
}

LimitSurface::LimitSurface(std::shared_ptr<const DooSabinSurface> surface)
    : surface_(std::move(surface)), forms_(surface_->weights()) {
  const std::int32_t count = topology().corner_count();
  form_of_corner_.resize(static_cast<std::size_t>(count));
  std::map<PatchClass, std::uint16_t> numbers;
  for (std::int32_t c = 0; c < count; ++c) {
    const PatchClass patch = surface_->patches().corner_patch(c).patch;
    const auto [at, is_new] =
        numbers.try_emplace(patch, static_cast<std::uint16_t>(form_list_.size()));
    if (is_new) {
      if (form_list_.size() > std::numeric_limits<std::uint16_t>::max()) {
        throw Error(ErrorCode::UnusableMesh,
                    "the mesh has more than 65,536 kinds of corners: valences and face sizes "
                    "differ too much");
      }
      form_list_.push_back(&forms_.of(patch));
    }
    form_of_corner_[c] = at->second;
  }
}

void LimitSurface::Corner::move_to(std::int32_t corner) {
  if (corner == corner_) return;
  corner_ = corner;
  form_ = &whole_.form(corner);
  const PatchMesh& patches = whole_.surface_->patches();
  indices_.resize(static_cast<std::size_t>(form_->column_count));
  patches.gather(patches.corner_patch(corner), indices_.data(), 1);
  const std::span<const glm::dvec3> state = whole_.surface_->state();
  own_ = state[indices_[0]];
  points_.resize(indices_.size());
  for (std::size_t k = 0; k < indices_.size(); ++k) points_[k] = state[indices_[k]] - own_;
}

glm::dvec3 LimitSurface::normal_beside(const CornerParameter& at) const {
  Corner corner(*this);
  glm::dvec3 sum(0.0);
  const auto add = [&](std::int32_t c, double u, double v) {
    const auto aside = [](double t) { return t + (t < 0.5 ? kAside : -kAside); };
    corner.move_to(c);
    sum += corner.at({aside(u), aside(v)}).normal;
  };
  if (at.u == 0 && at.v == 0) {
    for (const std::int32_t c : topology().corners_at(topology().vertex_of(at.corner)))
      add(c, 0, 0);
  } else {
    add(at.corner, at.u, at.v);
  }
  const double length = glm::length(sum);
  return length > 0 ? sum / length : glm::dvec3(0, 0, 1);
}

SurfacePoint LimitSurface::point_of(Corner& corner, const CornerParameter& at) const {
  corner.move_to(at.corner);
  const PatchPoint raw = corner.at({at.u, at.v});
  glm::dvec3 normal = unit_or_zero(raw);
  if (normal == glm::dvec3(0.0)) normal = normal_beside(at);
  const Placement& placement = surface_->placement();
  const PatchPoint point = raw.turned(at.turn_c, at.turn_s, 2);
  SurfacePoint result;
  result.position = placement.to_model(point.position);
  result.du = placement.diagonal * point.du;
  result.dv = placement.diagonal * point.dv;
  result.duu = placement.diagonal * point.duu;
  result.duv = placement.diagonal * point.duv;
  result.dvv = placement.diagonal * point.dvv;
  result.normal = normal;
  result.has_second = point.has_second;
  return result;
}

SurfacePoint LimitSurface::evaluate(const SurfaceParameter& at) const {
  Corner corner(*this);
  return point_of(corner, corner_parameter(topology(), at));
}

void LimitSurface::evaluate(std::span<const SurfaceParameter> places,
                            std::span<SurfacePoint> points) const {
  if (places.size() != points.size()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("evaluate: there are {} places, and room for {} points", places.size(),
                          points.size()));
  }
  parallel_for(places.size(), kPlaceGrain, [&](std::size_t begin, std::size_t end) {
    Corner corner(*this);
    for (std::size_t i = begin; i < end; ++i)
      points[i] = point_of(corner, corner_parameter(topology(), places[i]));
  });
}

SurfaceStencil LimitSurface::stencil(const SurfaceParameter& at) const {
  const CornerParameter place = corner_parameter(topology(), at);
  const PatchMesh& patches = surface_->patches();
  const PatchForm& form = this->form(place.corner);
  const auto count = static_cast<std::size_t>(form.column_count);
  std::vector<std::int32_t> points(count);
  patches.gather(patches.corner_patch(place.corner), points.data(), 1);
  const std::vector<double> rows = patch_weights(form, place.u, place.v);
  SurfaceStencil result;
  const auto add = [&](std::int32_t point, double share, std::size_t k) {
    const double du = rows[count + k], dv = rows[2 * count + k];
    result.points.push_back(point);
    result.position.push_back(share * rows[k]);
    result.du.push_back(share * (2 * (place.turn_c * du - place.turn_s * dv)));
    result.dv.push_back(share * (2 * (place.turn_s * du + place.turn_c * dv)));
  };
  std::vector<std::int32_t> of_ring;
  for (std::size_t k = 0; k < count; ++k) {
    if (points[k] < patches.state_size()) {
      add(points[k], 1, k);
      continue;
    }
    const LargeRing& ring = patches.ring_of_sum(points[k]);
    const std::vector<double> shares = sum_weights(ring, points[k] - ring.first_sum);
    patches.ring_points(ring, of_ring);
    for (std::size_t i = 0; i < shares.size(); ++i) add(of_ring[i], shares[i], k);
  }
  return result;
}

}  // namespace planish
