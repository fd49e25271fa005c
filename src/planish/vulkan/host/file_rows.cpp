#include "planish/vulkan/host/file_rows.h"

#include <algorithm>
#include <array>
#include <map>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/seam_vertices.h"

namespace planish::vulkan {
namespace {

// Corners whose grids are made at once.
constexpr std::size_t kFaceCorners = 32;

// The mesh's polygons.
void add_polygons(const PolygonMesh& mesh, const PatchSurface& patches, const PosedSurface& pose,
                  std::vector<std::uint32_t>& triangles) {
  const PatchNumbering& numbering = patches.numbering();
  const MeshTopology& topology = patches.mesh().topology();
  RawVector<glm::dvec3> positions(static_cast<std::size_t>(numbering.row_count()));
  PatchTarget target;
  target.positions = positions;
  patches.rows(pose.state, pose.placement, {0, numbering.row_count()}, target);
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> corners;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f] != 0) continue;
    const std::int32_t first = topology.first_corner(f);
    corners.resize(static_cast<std::size_t>(topology.face_size(f)));
    for (std::size_t i = 0; i < corners.size(); ++i)
      corners[i] = numbering.vertex_row(first + static_cast<std::int32_t>(i));
    const std::size_t end = triangles.size();
    triangles.resize(end + 3 * (corners.size() - 2));
    triangulate(corners, positions, std::span(triangles).subspan(end));
  }
}

// The quads of some corners.
class CornerQuads {
 public:
  CornerQuads(const PatchSurface& patches, const PosedSurface& pose)
      : patches_(patches), pose_(pose), cells_(patches.numbering().level()) {}

  [[nodiscard]] std::size_t per_corner() const {
    return cells_.of(patches_.mesh().topology(), 0).size();
  }
  void write(std::span<const std::int32_t> corners, std::uint32_t* quads,
             std::uint32_t* triangles) const {
    const PatchSamples& samples = patches_.numbering().samples();
    const auto count = static_cast<std::size_t>(samples.count());
    thread_local RawVector<glm::dvec3> positions;
    thread_local std::vector<std::int32_t> rows;
    positions.resize(corners.size() * count);
    rows.resize(count);
    PatchTarget target;
    target.positions = positions;
    patches_.grids(pose_.state, pose_.placement, corners, target);
    const std::int32_t side = samples.side() + 1;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      patches_.numbering().grid(corners[i], rows.data());
      for (const auto& cell : cells_.of(patches_.mesh().topology(), corners[i])) {
        std::array<glm::dvec3, 4> p;
        for (std::size_t k = 0; k < 4; ++k) {
          *quads++ = static_cast<std::uint32_t>(rows[cell[k]]);
          p[k] = positions[i * count +
                           static_cast<std::size_t>(samples.index(cell[k] % side, cell[k] / side))];
        }
        for (const std::uint8_t k : split_quad(p[0], p[1], p[2], p[3]))
          *triangles++ = static_cast<std::uint32_t>(rows[cell[k]]);
      }
    }
  }

 private:
  const PatchSurface& patches_;
  const PosedSurface& pose_;
  PatchCells cells_;
};

}  // namespace

std::vector<std::int32_t> kept_corners(const PolygonMesh& mesh, const MeshTopology& topology) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> corners;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    if (is_hole[topology.face_of(c)] == 0) corners.push_back(c);
  return corners;
}

KeptFaces kept_faces(const PolygonMesh& mesh, const PatchSurface& patches,
                     const PosedSurface& pose) {
  KeptFaces faces;
  if (patches.numbering().level() == 0) {
    add_polygons(mesh, patches, pose, faces.triangles);
    return faces;
  }
  const std::vector<std::int32_t> corners = kept_corners(mesh, patches.mesh().topology());
  if (corners.empty()) return faces;
  const CornerQuads writer(patches, pose);
  const std::size_t quads = writer.per_corner();
  faces.quads.resize(4 * quads * corners.size());
  faces.triangles.resize(6 * quads * corners.size());
  const std::size_t pieces = (corners.size() + kFaceCorners - 1) / kFaceCorners;
  parallel_each(pieces, 1, [&](std::size_t i) {
    const std::size_t first = i * kFaceCorners;
    const std::size_t count = std::min(kFaceCorners, corners.size() - first);
    writer.write(std::span(corners).subspan(first, count), faces.quads.data() + 4 * quads * first,
                 faces.triangles.data() + 6 * quads * first);
  });
  return faces;
}

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
