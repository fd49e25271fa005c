#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/files/gltf/write_gltf.h"
#include "planish/files/write_polygons.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Writes a control cage as glTF, which knows no subdivision surfaces: its polygons as triangles
/// that encode them (FB_ngon_encoding), and what a program needs to draw its surface in the mesh's
/// extras, by the names that USD has for it:
///
///   "subdivision": {"subdivisionScheme": "catmullClark", "interpolateBoundary": "edgeOnly",
///                   "creaseIndices": [0, 1, ...], "creaseLengths": [2, ...],
///                   "creaseSharpnesses": [10, ...], "cornerIndices": [...],
///                   "cornerSharpnesses": [...], "holeIndices": [...]}
///
/// Each group of faces is a primitive with vertices of its own, which are doubled at seams of
/// texture coordinates: the attribute _CAGE_VERTEX says which of the cage's vertices each is, by
/// the numbers of these lists. Faces are counted over all primitives. Lists that are empty are left
/// out. Normals are the mean of the facets'. Polygons are fans, whose triangles overlap where one
/// is concave. The options' extras, name, origin and materials are taken. Throws as write_gltf(),
/// and Error{InvalidArgument} for a cage without faces or of more than 2^24 vertices, which float32
/// does not count.
GltfFile write_gltf_cage(const std::filesystem::path& path, const PolygonMesh& cage,
                         const CageSubdivision& subdivision, GltfOptions options);

/// Where that file has the cage's vertices.
[[nodiscard]] std::vector<glm::dvec3> written_cage_positions(const PolygonMesh& cage,
                                                             const GltfOptions& options);

}  // namespace planish
