#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Faces of a mesh in one plane: a facet of whatever surface the mesh was made of.
struct FacetCluster {
  std::vector<std::int32_t> faces;
  std::vector<std::int32_t> neighbours;  ///< other clusters across smooth edges, ascending
  Facet facet;
};

/// Of the facets that a cluster's surface is looked for among: more beside it tell none.
inline constexpr std::size_t kMostNeighbours = 8;
/// A facet turns by no more from its surface: prisms of six sides and fewer are no cylinders.
inline constexpr double kMostFacetTurn = 28 * kDegree;

struct FacetClusters {
  std::vector<Facet> facets;  ///< by face
  std::vector<double> doubt;  ///< by face: what vertices that are off turn its normal by, radians
  std::vector<std::int32_t> cluster_of;  ///< by face
  std::vector<FacetCluster> clusters;
};

/// Clusters of faces whose vertices are at most `tolerance` off their planes. `is_sharp`: one per
/// edge; clusters end where it is not 0.
[[nodiscard]] FacetClusters make_facet_clusters(std::span<const glm::dvec3> positions,
                                                const MeshTopology& topology,
                                                std::span<const char> is_sharp, double tolerance);

}  // namespace planish
