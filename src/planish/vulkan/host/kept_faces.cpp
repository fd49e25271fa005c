#include "planish/vulkan/host/kept_faces.h"

#include <algorithm>
#include <array>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/hole_flags.h"
#include "planish/mesh/triangulate.h"
#include "planish/patches/patch_numbering.h"

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

}  // namespace planish::vulkan
