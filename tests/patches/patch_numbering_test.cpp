#include "planish/patches/patch_plan.h"

#include <gtest/gtest.h>

#include <set>

#include "patches/patch_oracle.h"

namespace planish::test {
namespace {

using Part = PatchNumbering::Part;

// Rows that the visible corners name, with what names each: a position of the surface and side.
std::set<std::int32_t> named_rows(const PatchMesh& mesh, const PatchNumbering& numbering) {
  std::set<std::int32_t> rows;
  const std::int32_t n = numbering.samples().side();
  std::vector<std::int32_t> grid(static_cast<std::size_t>((n + 1) * (n + 1)));
  for (std::int32_t c = 0; c < mesh.topology().corner_count(); ++c) {
    if (numbering.is_hidden(mesh.topology().face_of(c))) continue;
    numbering.grid(c, grid.data());
    for (std::int32_t b = 0; b <= n; ++b) {
      for (std::int32_t a = 0; a <= n; ++a) {
        EXPECT_EQ(grid[b * (n + 1) + a], numbering.row(c, a, b));
        rows.insert(numbering.row(c, a, b));
      }
    }
  }
  return rows;
}

std::vector<std::uint8_t> hidden_faces(const PolygonMesh& mesh, std::int32_t every) {
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) hidden[f] = f % every < 2;
  return hidden;
}

void expect_each_row_named(const PolygonMesh& mesh, std::int32_t hide_every) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  const PatchMesh patches(topology, features);
  const auto hidden = hide_every > 0 ? hidden_faces(mesh, hide_every) : std::vector<std::uint8_t>{};
  for (int level = 1; level <= 3; ++level) {
    const PatchNumbering numbering(patches, level, hidden);
    const std::set<std::int32_t> rows = named_rows(patches, numbering);
    ASSERT_EQ(static_cast<std::int64_t>(rows.size()), numbering.row_count()) << level;
    EXPECT_EQ(*rows.begin(), 0);
    EXPECT_EQ(*rows.rbegin(), numbering.row_count() - 1);
  }
}

TEST(PatchNumbering, EachRowIsNamed) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    expect_each_row_named(mesh, 0);
  }
}

TEST(PatchNumbering, RowsOfHiddenFacesAreLeftOut) {
  for (const auto& [name, mesh] : all_meshes()) {
    if (mesh.face_count() < 4) continue;
    SCOPED_TRACE(name);
    expect_each_row_named(mesh, 3);
    expect_each_row_named(mesh, 5);
  }
}

TEST(PatchNumbering, VerticesComeFirstThenFacesThenEdgesThenCorners) {
  const PolygonMesh mesh = cube();
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  const PatchMesh patches(topology, features);
  const PatchNumbering numbering(patches, 2);
  EXPECT_EQ(numbering.row(0, 0, 0), mesh.face_vertices[0]);
  EXPECT_EQ(numbering.row(0, 2, 2), 8);
  EXPECT_EQ(numbering.row(0, 2, 0), 8 + 6);
  EXPECT_EQ(numbering.row(5, 1, 0), 8 + 6 + 12 + 5 * 3);
  EXPECT_EQ(numbering.row(5, 1, 1), 8 + 6 + 12 + 5 * 3 + 1);
  EXPECT_EQ(numbering.row(5, 2, 1), 8 + 6 + 12 + 5 * 3 + 2);
  EXPECT_EQ(numbering.row_count(), 98);
}

// A crease has the rows of both its sides, seams of texture coordinates those of theirs.
TEST(PatchNumbering, SeamsOfTextureCoordinatesAreCuts) {
  const PolygonMesh mesh = flat_grid(2, 1);
  const MeshTopology topology(mesh);
  // Vertices 1 and 4 lie between the two quads: joined, then cut.
  const std::vector<std::int32_t> joined = mesh.face_vertices;
  std::vector<std::int32_t> cut = joined;
  for (int i = 4; i < 8; ++i) cut[i] += 6;
  for (int level = 0; level <= 3; ++level) {
    const PatchNumbering one(topology, joined, 6, level);
    const PatchNumbering two(topology, cut, 12, level);
    const std::int64_t n = level == 0 ? 1 : std::int64_t{1} << level;  // cells along an edge
    EXPECT_EQ(one.row_count(), level == 0 ? 6 : (2 * n + 1) * (n + 1)) << level;
    EXPECT_EQ(two.row_count(), level == 0 ? 12 : 2 * (n + 1) * (n + 1) + 4) << level;
  }
}

}  // namespace
}  // namespace planish::test
