#include "planish/surface/level_faces.h"

#include "planish/core/assert.h"
#include "planish/mesh/hole_flags.h"
#include "planish/surface/attributes.h"

namespace planish {
namespace {

// Faces by their sizes; each child gives the corner that it keeps.
template <class SizeOf>
LevelFaces parents_of(const LevelFaces& finer, std::size_t face_count, bool triangles,
                      const SizeOf& size_of) {
  LevelFaces coarser;
  coarser.offsets.reserve(face_count + 1);
  std::size_t child = 0;
  for (std::size_t f = 0; f < face_count; ++f) {
    const std::size_t size = size_of(f);
    for (std::size_t k = 0; k < size; ++k) {
      const auto corners = finer.face(child + k);
      coarser.vertices.push_back(
          corners[child_corners(size, corners.size(), static_cast<int>(k)).corner]);
    }
    coarser.offsets.push_back(static_cast<std::int32_t>(coarser.vertices.size()));
    child += triangles ? 4 : size;
  }
  PLANISH_ASSERT(child == finer.face_count());
  return coarser;
}

}  // namespace

ChildCorners child_corners(std::size_t face_size, std::size_t child_size, int k) {
  const int m = static_cast<int>(child_size);
  const int corner = face_size == child_size ? k : 0;
  return {corner, (corner + 1) % m, m == 4 ? (corner + 2) % m : -1};
}

std::vector<LevelFaces> level_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  std::vector<LevelFaces> levels(static_cast<std::size_t>(surface.level) + 1);
  LevelFaces& last = levels.back();
  last.vertices.assign(surface.face_vertices.begin(), surface.face_vertices.end());
  last.offsets = surface.face_offsets;
  if (last.offsets.empty()) {
    for (std::int64_t f = 0; f <= surface.face_count(); ++f)
      last.offsets.push_back(static_cast<std::int32_t>(4 * f));
  }
  if (surface.level == 0) return levels;

  const bool triangles = surface.is_triangles();
  for (std::size_t l = levels.size() - 1; l > 1; --l) {
    const std::size_t size = triangles ? 3 : 4;
    levels[l - 1] = parents_of(levels[l], levels[l].face_count() / 4, triangles,
                               [&](std::size_t) { return size; });
  }
  std::vector<std::size_t> sizes;
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!is_hole[f]) sizes.push_back(static_cast<std::size_t>(mesh.face_size(f)));
  }
  levels[0] =
      parents_of(levels[1], sizes.size(), triangles, [&](std::size_t f) { return sizes[f]; });
  return levels;
}

std::vector<std::int32_t> ancestor_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> result;
  result.reserve(static_cast<std::size_t>(surface.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f]) continue;
    // Descendants of a face follow one another.
    const auto count = descendant_count(surface, mesh.face_size(f));
    result.insert(result.end(), static_cast<std::size_t>(count), f);
  }
  PLANISH_ASSERT(static_cast<std::int64_t>(result.size()) == surface.face_count());
  return result;
}

}  // namespace planish
