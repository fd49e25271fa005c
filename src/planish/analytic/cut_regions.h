#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/analytic/facet_clusters.h"
#include "planish/analytic/find_regions.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Adds regions of facets that were cut as facets. A program that knows triangles only (OpenSCAD,
/// a slicer, a mesh editor) makes a prism of a cylinder and cuts that: along the cut vertices lie
/// on its facets, inside the cylinder by up to a facet's sag. What tells the surface are the edges
/// between facets, which lie on it from end to end. `regions`: what whole facets told before; these
/// grow over cut ones, too. Returns by region whether it has facets that were cut, and nothing goes
/// on smoothly beside it: it is a surface of its own at whatever angle it meets others.
[[nodiscard]] std::vector<char> find_cut_regions(std::span<const glm::dvec3> positions,
                                                 const MeshTopology& topology,
                                                 std::span<const char> is_sharp,
                                                 const FacetClusters& made,
                                                 const FaceComponents& parts, double tolerance,
                                                 AnalyticRegions& regions);

}  // namespace planish
