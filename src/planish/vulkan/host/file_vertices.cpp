#include "planish/vulkan/host/file_vertices.h"

#include <algorithm>
#include <map>

#include "planish/mesh/hole_flags.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/seam_vertices.h"

namespace planish::vulkan {

namespace {

// The corners of a file's faces, with their rows here, there, and of the texture coordinates.
class FileCorners {
 public:
  FileCorners(const PatchSurface& patches, const FileFaces& faces)
      : topology_(patches.mesh().topology()),
        own_(patches.numbering()),
        rows_(patches.mesh(), own_.level(), faces.hidden),
        cells_(std::max(own_.level(), 1)) {
    if (faces.uvs)
      uvs_.emplace(topology_, faces.uvs->indices, faces.uvs->count, own_.level(), faces.hidden);
  }

  [[nodiscard]] bool has_uvs() const { return uvs_.has_value(); }
  [[nodiscard]] std::int64_t row_count() const { return rows_.row_count(); }

  /// Calls visit(row here, row there, texture coordinate) for each, of a face of the mesh.
  template <class Visit>
  void for_face(std::int32_t face, const Visit& visit) const {
    const std::int32_t first = topology_.first_corner(face);
    for (std::int32_t c = first; c < first + topology_.face_size(face); ++c) {
      if (own_.level() == 0) {
        visit(own_.vertex_row(c), rows_.vertex_row(c), uvs_ ? uvs_->vertex_row(c) : 0);
        continue;
      }
      const std::vector<std::int32_t> own = grid(own_, c), rows = grid(rows_, c);
      const std::vector<std::int32_t> uvs = uvs_ ? grid(*uvs_, c) : rows;
      for (const auto& cell : cells_.of(topology_, c))
        for (const std::int32_t place : cell) visit(own[place], rows[place], uvs[place]);
    }
  }

 private:
  [[nodiscard]] static std::vector<std::int32_t> grid(const PatchNumbering& numbering,
                                                      std::int32_t corner) {
    std::vector<std::int32_t> rows(static_cast<std::size_t>(numbering.samples().count()));
    numbering.grid(corner, rows.data());
    return rows;
  }

  const MeshTopology& topology_;
  const PatchNumbering& own_;
  PatchNumbering rows_;
  std::optional<PatchNumbering> uvs_;
  PatchCells cells_;
};

// Faces that are seen, by group: each a primitive.
std::map<std::int32_t, std::vector<std::int32_t>> primitives_of(const FileFaces& faces,
                                                                std::int32_t face_count) {
  std::map<std::int32_t, std::vector<std::int32_t>> primitives;
  for (std::int32_t f = 0; f < face_count; ++f)
    if (faces.hidden.empty() || faces.hidden[f] == 0)
      primitives[faces.groups.empty() ? 0 : faces.groups[f]].push_back(f);
  return primitives;
}

}  // namespace

FileFaces::FileFaces(const PolygonMesh& mesh) : groups(mesh.face_groups) {
  if (!mesh.hole_faces.empty()) hidden = hole_flags(mesh);
  if (!mesh.face_uvs.empty()) uvs.emplace(mesh);
}

// As gltf_vertices() numbers them: one primitive keeps the surface's rows, several have those of
// their faces.
std::vector<std::int32_t> file_vertices(const PatchSurface& patches, const FileFaces& faces) {
  const FileCorners corners(patches, faces);
  const auto primitives = primitives_of(faces, patches.mesh().topology().face_count());
  std::vector<std::int32_t> result(static_cast<std::size_t>(patches.numbering().row_count()), -1);
  std::vector<std::int64_t> first(static_cast<std::size_t>(corners.row_count()), -1);
  std::vector<std::int32_t> uvs;  // of each vertex of the file
  SeamVertices seams(uvs);
  for (const auto& [group, of_group] : primitives) {
    std::vector<std::uint8_t> is_named(first.size(), primitives.size() == 1 ? 1 : 0);
    for (const std::int32_t face : of_group)
      corners.for_face(face,
                       [&](std::int32_t, std::int32_t row, std::int32_t) { is_named[row] = 1; });
    for (std::size_t row = 0; row < first.size(); ++row) {
      if (is_named[row] == 0) continue;
      first[row] = std::ssize(uvs);
      uvs.push_back(-1);
    }
    for (const std::int32_t face : of_group)
      corners.for_face(face, [&](std::int32_t own, std::int32_t row, std::int32_t uv) {
        const std::int64_t vertex =
            corners.has_uvs() ? seams.of_corner(first[row], row, uv) : first[row];
        if (result[own] < 0) result[own] = static_cast<std::int32_t>(vertex);
      });
    seams.next_primitive();
  }
  return result;
}

}  // namespace planish::vulkan
