#include "planish/surface/doo_sabin_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/measure/figures.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"
#include "support/meshes.h"

namespace planish {
namespace {

struct Numbered {
  explicit Numbered(const PolygonMesh& mesh)
      : topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        patches(topology, features),
        numbering(patches, 1) {}
  MeshTopology topology;
  SharpFeatures features;
  PatchMesh patches;
  PatchNumbering numbering;
};

void expect_places_of_face(const Numbered& at, const SharedPoints& points, std::int32_t face) {
  EXPECT_EQ(points.rows()[points.centre()], at.numbering.face_row(face));
  const std::int32_t first = at.topology.first_corner(face);
  for (std::int32_t c = first; c < first + at.topology.face_size(face); ++c) {
    EXPECT_EQ(points.rows()[points.vertex(c)], at.numbering.vertex_row(c));
    EXPECT_EQ(points.rows()[points.midpoint(c)], at.numbering.edge_row(c));
  }
}

TEST(SharedPoints, AreListedOnceEach) {
  const Numbered at(test::torus(7, 5, 1.0, 0.4));
  SharedPoints points(at.topology, at.numbering, at.topology.corner_count());
  for (std::int32_t face = 0; face < at.topology.face_count(); ++face) {
    points.add_face(face);
    expect_places_of_face(at, points, face);
  }
  // A vertex, a centre and two midpoints for each of 35 quads. A vertex whose faces so far touch it
  // across the face's own corner only is listed again.
  std::vector<std::int32_t> rows(points.rows().begin(), points.rows().end());
  std::ranges::sort(rows);
  const auto twice = std::ranges::unique(rows);
  EXPECT_EQ(twice.begin() - rows.begin(), 4 * 35);
  EXPECT_LE(std::ssize(twice), 5 + 7);
}

TEST(SharedPoints, BeginAnewBehindAFaceThatIsLeftOut) {
  const Numbered at(test::torus(7, 5, 1.0, 0.4));
  SharedPoints points(at.topology, at.numbering, at.topology.corner_count());
  for (const std::int32_t face : {3, 4, 9, 10, 2}) {
    points.add_face(face);
    expect_places_of_face(at, points, face);
  }
}

// Figures of ranges that share points are those of each range by itself.
TEST(SharedPoints, DoNotChangeFigures) {
  const PolygonMesh mesh = test::torus(80, 60, 1.0, 0.4);
  const DooSabinSurface base(mesh, {});
  const auto blocks = base.level(1);
  BlockQuality alone(*blocks, mesh, {});
  ASSERT_GT(swept_pieces(blocks->info()).size(), 8u);
  for (const RowRange piece : swept_pieces(blocks->info())) {
    std::vector<glm::dvec3> positions(static_cast<std::size_t>(4 * piece.count));
    std::vector<glm::vec3> normals(positions.size());
    for (std::int64_t i = 0; i < piece.count; ++i) {
      const auto at = static_cast<std::size_t>(4 * i);
      blocks->corners({piece.first + i, 1}, std::span(positions).subspan(at, 4),
                      std::span(normals).subspan(at, 4));
    }
    alone.add(piece, positions, normals);
  }
  const SurfaceQuality wanted = alone.result(), made = surface_quality(*blocks, mesh, {}, {});
  EXPECT_EQ(made.max_normal_deviation, wanted.max_normal_deviation);
  EXPECT_EQ(made.rms_normal_deviation, wanted.rms_normal_deviation);
  EXPECT_EQ(made.bending, wanted.bending);
  EXPECT_EQ(made.folded_area, wanted.folded_area);
}

}  // namespace
}  // namespace planish
