#include "job/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "job/prepare.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/placement.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

void require_same_faces(const Input& cage, const PolygonMesh& given, const std::string& name) {
  const PolygonMesh& a = cage.file.mesh;
  const PolygonMesh& b = given;
  const std::string subject = cage.name + " is no cage of " + name + ": ";
  if (a.vertex_count() < b.vertex_count()) {
    throw Error(ErrorCode::UnusableMesh, subject + with_separators(a.vertex_count()) +
                                             " vertices for " + with_separators(b.vertex_count()));
  }
  if (a.face_count() != b.face_count()) {
    throw Error(ErrorCode::UnusableMesh, subject + with_separators(a.face_count()) + " faces for " +
                                             with_separators(b.face_count()));
  }
  for (std::int32_t face = 0; face < a.face_count(); ++face) {
    if (!std::ranges::equal(a.face(face), b.face(face))) {
      throw Error(ErrorCode::UnusableMesh,
                  subject + "face " + std::to_string(face) + " has other corners", face);
    }
  }
}

std::vector<glm::dvec3> progressive_limits(const Input& cage, const PolygonMesh& given,
                                           const std::string& name, const VerifyOptions& options) {
  require_same_faces(cage, given, name);
  PolygonMesh control = cage.file.mesh;
  if (!info_of(cage.file.format).keeps_sharp_edges || !options.creases.use_tags) {
    control.creases = given.creases;
    control.corners = given.corners;
  }
  require_usable(control, cage.name);
  return limit_positions(control, {options.scheme, options.weights, {options.boundary, true}});
}

std::vector<glm::dvec3> fair_limits(const Input& cage, const PolygonMesh& given,
                                    const std::string& name, const VerifyOptions& options) {
  const SharpFeatureOptions sharp{options.boundary, true};
  try {
    return limit_positions(given, level_one_of_cage(given, cage.file.mesh, sharp), sharp);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    throw Error(ErrorCode::UnusableMesh, cage.name + " is no cage of " + name + ": " + error.what(),
                error.element());
  }
}

}  // namespace

Verification verify(const Input& cage, const Input& given, const VerifyOptions& options) {
  const PolygonMesh prepared =
      prepare(PolygonMesh(given.file.mesh), {options.repair, options.creases, options.interpolation,
                                             options.weld, options.smoothed_vertices})
          .mesh;
  require_usable(prepared, given.name);
  const std::vector<glm::dvec3> limit =
      options.interpolation == InterpolationMethod::Fair
          ? fair_limits(cage, prepared, given.name, options)
          : progressive_limits(cage, prepared, given.name, options);
  const double diagonal = placement_of(prepared).diagonal;
  Verification result;
  result.vertex_count = prepared.vertex_count();
  double sum_of_squares = 0;
  for (std::int64_t vertex = 0; vertex < result.vertex_count; ++vertex) {
    const glm::dvec3 offset = limit[vertex] - prepared.positions[vertex];
    double error = std::hypot(offset.x, offset.y, offset.z) / diagonal;
    if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
    sum_of_squares += error * error;
    if (result.worst_vertex < 0 || error > result.error.max) {
      result.error.max = error;
      result.worst_vertex = vertex;
    }
  }
  if (result.vertex_count > 0) {
    result.error.rms = std::sqrt(sum_of_squares / static_cast<double>(result.vertex_count));
  }
  result.confirmed = result.error.max <= options.tolerance;
  return result;
}

}  // namespace planish::command
