#pragma once

#include <cstdint>
#include <vector>

#include "planish/primal/scheme.h"
#include "support/meshes.h"

namespace planish::test {

inline constexpr PrimalScheme kBothPrimalSchemes[] = {PrimalScheme::CatmullClark,
                                                      PrimalScheme::Loop};

/// Every face of more than three corners as a fan of triangles from its first corner.
[[nodiscard]] PolygonMesh as_triangles(const PolygonMesh& mesh);

/// Tags each edge, and each vertex with a tenth of that, with the given probability and a
/// sharpness between 0 and 4.
[[nodiscard]] PolygonMesh with_random_sharpness(PolygonMesh mesh, double probability,
                                                std::uint32_t seed);

/// The catalogue's closed, open and sharp meshes, some with semi-sharp tags and one with
/// a tagged tip; as triangles for Loop.
[[nodiscard]] std::vector<NamedMesh> primal_meshes(PrimalScheme scheme);

}  // namespace planish::test
