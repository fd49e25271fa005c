#include "planish/files/gltf/gltf_cage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/mesh/face_geometry.h"
#include "planish/surface/mesh_blocks.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Based on: Pixar, "Universal Scene Description: UsdGeomMesh", 2016-2023, for the names.

constexpr std::int32_t kMostCounted = 1 << 24;  // by float32

// Normals that are none, of vertices without faces, point up: glTF wants all of unit length.
std::vector<glm::dvec3> facet_normals(const PolygonMesh& cage) {
  std::vector<glm::dvec3> normals(cage.positions.size(), glm::dvec3(0.0));
  for (std::int32_t f = 0; f < cage.face_count(); ++f) {
    const glm::dvec3 area = area_vector(cage.positions, cage.face(f));
    for (const std::int32_t v : cage.face(f)) normals[v] += area;
  }
  for (glm::dvec3& normal : normals) {
    normal = unit_or_zero(normal);
    if (normal == glm::dvec3(0.0)) normal = glm::dvec3(0.0, 0.0, 1.0);
  }
  return normals;
}

// The cage as a surface whose rows are its vertices.
SurfaceMesh surface_of(const PolygonMesh& cage) {
  SurfaceMesh surface;
  surface.positions.assign(cage.positions.begin(), cage.positions.end());
  for (const glm::dvec3& normal : facet_normals(cage)) surface.normals.push_back(normal);
  surface.face_offsets = cage.face_offsets;
  surface.face_vertices.assign(cage.face_vertices.begin(), cage.face_vertices.end());
  surface.base_vertices.resize(cage.positions.size());
  std::iota(surface.base_vertices.begin(), surface.base_vertices.end(), 0);
  if (!cage.face_uvs.empty()) {
    const auto none = static_cast<std::int32_t>(cage.uvs.size());
    surface.uvs.assign(cage.uvs.begin(), cage.uvs.end());
    surface.face_uvs.assign(cage.face_uvs.begin(), cage.face_uvs.end());
    if (std::ranges::find(cage.face_uvs, -1) != cage.face_uvs.end()) {
      surface.uvs.push_back(glm::dvec2(0.0));
      std::ranges::replace(surface.face_uvs, -1, none);
    }
  }
  surface.colors.assign(cage.colors.begin(), cage.colors.end());
  surface.groups = cage.groups;
  surface.face_groups.assign(cage.face_groups.begin(), cage.face_groups.end());
  return surface;
}

// Primitives are in the order of the groups, and have their faces in that of the cage.
std::vector<std::int32_t> written_places(const PolygonMesh& cage) {
  std::vector<std::int32_t> faces(static_cast<std::size_t>(cage.face_count()));
  std::iota(faces.begin(), faces.end(), 0);
  if (!cage.face_groups.empty())
    std::ranges::stable_sort(faces, {}, [&](std::int32_t f) { return cage.face_groups[f]; });
  std::vector<std::int32_t> places(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) places[faces[i]] = static_cast<std::int32_t>(i);
  return places;
}

GltfSubdivision subdivision_of(const PolygonMesh& cage, const CageSubdivision& how) {
  GltfSubdivision made{how, cage.creases, cage.corners, {}};
  if (cage.hole_faces.empty()) return made;
  const std::vector<std::int32_t> places = written_places(cage);
  for (const std::int32_t face : cage.hole_faces) made.hole_faces.push_back(places[face]);
  std::ranges::sort(made.hole_faces);
  return made;
}

}  // namespace

GltfFile write_gltf_cage(const std::filesystem::path& path, const PolygonMesh& cage,
                         const CageSubdivision& subdivision, GltfOptions options) {
  if (cage.vertex_count() > kMostCounted)
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: a cage in glTF has at most {} vertices, this one {}; write .usda or "
                          ".obj",
                          visible(path), kMostCounted, cage.vertex_count()));
  const SurfaceMesh surface = surface_of(cage);
  std::vector<float> numbers(cage.positions.size());
  std::iota(numbers.begin(), numbers.end(), 0.0f);
  options.fields.push_back({"cage_vertex", numbers});
  std::vector<std::int32_t> faces(static_cast<std::size_t>(cage.face_count()));
  std::iota(faces.begin(), faces.end(), 0);
  const GltfSubdivision extras = subdivision_of(cage, subdivision);
  options.subdivision = &extras;
  options.ngon_groups.assign(std::max<std::size_t>(cage.groups.size(), 1), 1);
  options.most_fanned = std::numeric_limits<std::size_t>::max();
  // All numbers of vertices are of one buffer.
  options.buffer_bytes = std::numeric_limits<std::uint64_t>::max();
  return write_gltf(path, MeshBlocks(surface, faces), options);
}

std::vector<glm::dvec3> written_cage_positions(const PolygonMesh& cage,
                                               const GltfOptions& options) {
  return written_positions(surface_of(cage), options, cage.positions.size());
}

}  // namespace planish
