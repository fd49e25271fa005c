#include "planish/edit/require_editable.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "planish/core/error.h"
#include "planish/surface/evaluate.h"

namespace planish {

namespace {

// Farther off, coordinates of unit diagonal lose what the tolerance asks for.
constexpr double kFarthestMove = 1e6;

}  // namespace

void require_editable(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_level(options.level);
  if (!fit.points.empty()) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit leaves the vertices within a bound, so that moving one has no place to "
                "go to; edit a fit with within = 0");
  }
  if (!fit.interpolation.converged) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit has not reached its tolerance (" +
                    std::string(name_of(fit.interpolation.stop_reason)) +
                    "); fit again with more iterations or a larger tolerance, or take fair "
                    "interpolation");
  }
  if (fit.prepared == nullptr || fit.prepared->given_vertex_count != mesh.vertex_count()) {
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("the fit is of {} vertices, the mesh has {}; give the mesh that was fitted",
                  fit.prepared ? fit.prepared->given_vertex_count : 0, mesh.vertex_count()));
  }
  if (options.fit.scheme != Scheme::DooSabin) {
    throw Error(ErrorCode::InvalidArgument,
                "fits of another scheme than Doo-Sabin cannot be edited; fit again with scheme "
                "doo-sabin");
  }
}

void require_moves(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                   std::int32_t vertex_count, const Placement& placement) {
  if (vertices.size() != positions.size()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("move: there are {} vertices and {} positions; give one each",
                          vertices.size(), positions.size()));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto name = [&] { return formatted("move {}: ", i); };
    if (vertices[i] < 0 || vertices[i] >= vertex_count) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("{}there is no vertex {}; the mesh has 0 to {}", name(), vertices[i],
                            vertex_count - 1),
                  vertices[i]);
    }
    const glm::dvec3 unit = placement.to_unit(positions[i]);
    const double far = std::max({std::abs(unit.x), std::abs(unit.y), std::abs(unit.z)});
    if (far <= kFarthestMove && !std::isnan(unit.x + unit.y + unit.z)) continue;
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}the position of vertex {} is not finite or farther than 10^6 "
                          "diagonals off; fit the moved mesh anew",
                          name(), vertices[i]),
                vertices[i]);
  }
}

}  // namespace planish
