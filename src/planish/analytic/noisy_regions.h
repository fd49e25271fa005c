#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/analytic/find_regions.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// The standard deviation of vertices from the smooth surface that they lie on, along its normals:
/// the quartile of what quadrics through patches of `faces` leave, which sharp edges end. 0 where
/// no patch tells it. Shapes that bend within a patch count as noise, too.
[[nodiscard]] double noise_of(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                              std::span<const char> is_sharp, std::span<const std::int32_t> faces);

/// Where vertices of a part lie.
enum class VertexPlaces : std::uint8_t {
  OnEdges,  ///< those of edges and corners lie on these, as a CAD program or a modeller makes them
  Samples,  ///< anywhere, as a scanner takes them: faces reach across edges
};

/// Finds the regions of parts anew whose vertices are noisy: surfaces that fit within five
/// deviations of the noise, and leave no more than it. Kinds are told by patches as large as they
/// can be, for facets tell nothing. `tolerance`: five deviations, for parts of which `regions` do
/// not take all and these take more; empty: of the noise that is measured in each part, where
/// `regions` take less than half of the area and these take more than half. Of samples all parts
/// are looked at, and regions have to take all faces. Returns the tolerances of the regions by
/// part, `exact` where they stay. Throws Error{Cancelled}.
std::vector<double> find_noisy_regions(std::span<const glm::dvec3> positions,
                                       const MeshTopology& topology, std::span<const char> is_sharp,
                                       const FaceComponents& parts, std::optional<double> tolerance,
                                       double exact, VertexPlaces places, AnalyticRegions& regions);

/// Moves samples that lie on the surface of one region alone, and have faces of others around them,
/// to where all of these meet.
void move_samples(const MeshTopology& topology, const FaceComponents& parts,
                  std::span<const double> tolerances, const AnalyticRegions& regions,
                  std::vector<glm::dvec3>& positions);

}  // namespace planish
