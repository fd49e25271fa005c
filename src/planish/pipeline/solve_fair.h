#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/pipeline/fit.h"

namespace planish {

/// Builds the fair net of a mesh without unused vertices and measures, in double from its limit
/// points, how far it is from `given` (unit coordinates): result.fair and result.interpolation,
/// which has no iterations. `subdivision` has Weights::DooSabin. Throws and warns as fit().
void solve_fair(Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options);

/// What fit() warns of such counts.
[[nodiscard]] Warning folds_left_warning(std::int64_t edges, std::int64_t faces);
[[nodiscard]] Warning concave_faces_warning(std::int64_t faces, std::int64_t crossing = 0);

}  // namespace planish
