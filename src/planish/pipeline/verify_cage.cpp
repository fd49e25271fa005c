#include "planish/pipeline/verify_cage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/vectors.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/sound_topology.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"

namespace planish {
namespace {

void require_same_faces(const PolygonMesh& cage, const PolygonMesh& given,
                        const VerifyOptions& options) {
  const std::string subject =
      formatted("{} is no cage of {}: ", options.cage_name, options.given_name);
  if (cage.vertex_count() < given.vertex_count()) {
    throw Error(ErrorCode::UnusableMesh, formatted("{}{} vertices for {}", subject,
                                                   cage.vertex_count(), given.vertex_count()));
  }
  if (cage.face_count() != given.face_count()) {
    throw Error(ErrorCode::UnusableMesh,
                formatted("{}{} faces for {}", subject, cage.face_count(), given.face_count()));
  }
  for (std::int32_t face = 0; face < cage.face_count(); ++face) {
    if (!std::ranges::equal(cage.face(face), given.face(face))) {
      throw Error(ErrorCode::UnusableMesh, formatted("{}face {} has other corners", subject, face),
                  face);
    }
  }
}

std::vector<glm::dvec3> progressive_limits(const PolygonMesh& cage, const PolygonMesh& given,
                                           const VerifyOptions& options) {
  require_same_faces(cage, given, options);
  const FitOptions& fit = options.fit.fit;
  const LimitOptions how{fit.scheme, fit.weights, {fit.sharp.boundary, true}};
  if (options.cage_has_tags && fit.sharp.use_tags) {
    require_usable(cage, options.cage_name);
    return limit_positions(cage, how);
  }
  PolygonMesh control = cage;
  control.creases = given.creases;
  control.corners = given.corners;
  require_usable(control, options.cage_name);
  return limit_positions(control, how);
}

std::vector<glm::dvec3> fair_limits(const PolygonMesh& cage, const PolygonMesh& given,
                                    const VerifyOptions& options) {
  // What make_ready() left has no tags but those that count.
  const SharpFeatureOptions sharp{options.fit.fit.sharp.boundary, true};
  try {
    return limit_positions(given, level_one_of_cage(given, cage, sharp), sharp);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    throw Error(
        ErrorCode::UnusableMesh,
        formatted("{} is no cage of {}: {}", options.cage_name, options.given_name, error.what()),
        error.element());
  }
}

// A mesh as it was fitted, and its points on the cage's surface.
struct Limits {
  PolygonMesh mesh;
  std::vector<glm::dvec3> points;
};

Limits limits_of(const PolygonMesh& cage, const PolygonMesh& given, const VerifyOptions& options,
                 bool pairs_triangles, bool refines) {
  const auto method = options.fit.method.value_or(InterpolationMethod::Progressive);
  Preparation preparation = preparation_of(options.fit, method);
  preparation.found = options.found;
  preparation.pairs_triangles = pairs_triangles;
  ReadyMesh ready = make_ready(PolygonMesh(given), preparation);
  require_usable(ready.mesh, options.given_name);
  if (refines)
    if (auto refined = refine_mesh(ready.mesh, *prepare_mesh(ready.mesh, options.given_name)))
      ready.mesh = std::move(refined->mesh);
  Limits made{std::move(ready.mesh), {}};
  // What is compared or taken for control points later may hold anything as yet.
  require_sound_indices(arrays_of(cage), options.cage_name, ErrorCode::UnusableMesh);
  made.points = method == InterpolationMethod::Fair ? fair_limits(cage, made.mesh, options)
                                                    : progressive_limits(cage, made.mesh, options);
  return made;
}

// As the options say; what they leave open, as the first that the cage fits.
Limits limits_of(const PolygonMesh& cage, const PolygonMesh& given, const VerifyOptions& options) {
  const MeshFitOptions& fit = options.fit;
  const bool pairs = fit.quads == QuadChoice::On, adds = fit.refine == RefineChoice::On;
  try {
    return limits_of(cage, given, options, pairs, adds);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    const auto as = [&](bool joined, bool refined) -> std::optional<Limits> {
      try {
        return limits_of(cage, given, options, joined, refined);
      } catch (const Error& again) {
        if (again.code() != ErrorCode::UnusableMesh) throw;
        return std::nullopt;
      }
    };
    if (fit.quads == QuadChoice::Auto)
      if (auto made = as(true, adds)) return std::move(*made);
    if (fit.refine == RefineChoice::Auto && fit.method == InterpolationMethod::Fair)
      if (auto made = as(pairs, true)) return std::move(*made);
    throw;
  }
}

}  // namespace

Verification verify_cage(const PolygonMesh& cage, const PolygonMesh& given,
                         const VerifyOptions& options) {
  const auto [prepared, limit] = limits_of(cage, given, options);
  const double diagonal = placement_of(prepared).diagonal;
  Verification result;
  result.vertex_count = prepared.vertex_count();
  double sum_of_squares = 0;
  for (std::int64_t vertex = 0; vertex < result.vertex_count; ++vertex) {
    const glm::dvec3 offset = limit[vertex] - prepared.positions[vertex];
    const double error = safe_length(offset) / diagonal;
    sum_of_squares += error * error;
    if (result.worst_vertex < 0 || error > result.error.max) {
      result.error.max = error;
      result.worst_vertex = vertex;
    }
  }
  if (result.vertex_count > 0)
    result.error.rms = std::sqrt(sum_of_squares / static_cast<double>(result.vertex_count));
  result.confirmed = result.error.max <= options.tolerance;
  return result;
}

}  // namespace planish
