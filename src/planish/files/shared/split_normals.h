#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/files/mesh_file.h"

namespace planish {

/// Normals as a file gives them to the corners of its faces.
struct CornerNormals {
  std::vector<glm::vec3> values;         ///< of any length; 0 or not finite: none
  std::vector<std::int32_t> of_corners;  ///< one per corner of the mesh, into values; -1: none
};

/// Normals that differ by more, in degrees, are split on purpose: in 8 bits they round by half a
/// degree.
inline constexpr double kSplitDegrees = 1;

/// Makes infinitely sharp creases of the edges where the normals of two faces differ at one of the
/// edge's vertices. Edges that the mesh has tagged keep their sharpness.
void mark_split_normals(PolygonMesh& mesh, const CornerNormals& normals);

/// Makes vertices at one place one vertex, since files repeat vertices to split normals at them.
/// The first one's colour stays.
void weld_repeated_vertices(MeshFile& file);

}  // namespace planish
