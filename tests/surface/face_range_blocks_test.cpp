#include "planish/surface/mesh_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "planish/surface/doo_sabin_surface.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

void expect_part_of(const SurfaceMesh& whole, const SurfaceBlocks& blocks, RowRange faces) {
  const FaceRangeBlocks part(blocks, faces);
  const SurfaceMesh made = collect(part, {});
  const std::span<const std::int32_t> rows = part.surface_rows();
  ASSERT_EQ(made.face_count(), faces.count);
  ASSERT_EQ(made.positions.size(), rows.size());
  ASSERT_TRUE(std::ranges::is_sorted(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(made.positions[i], whole.positions[rows[i]]);
    ASSERT_EQ(made.normals[i], whole.normals[rows[i]]);
    ASSERT_EQ(made.colors[i], whole.colors[rows[i]]);
    const auto row = static_cast<std::size_t>(rows[i]);
    for (std::size_t k = 0; k < 2; ++k)
      for (const int first : {0, 4})
        ASSERT_EQ(made.attributes[k].four(i, first), whole.attributes[k].four(row, first));
    ASSERT_EQ(i < made.base_vertices.size(), row < whole.base_vertices.size());
    if (i < made.base_vertices.size()) {
      ASSERT_EQ(made.base_vertices[i], whole.base_vertices[row]);
    }
  }
  const std::int64_t first = blocks.info().first_corner(faces.first);
  std::vector<bool> is_named(rows.size(), false);
  for (std::size_t c = 0; c < made.face_vertices.size(); ++c) {
    const std::size_t there = static_cast<std::size_t>(first) + c;
    const std::int32_t row = made.face_vertices[c];
    is_named[row] = true;
    ASSERT_EQ(rows[row], whole.face_vertices[there]);
    ASSERT_EQ(made.uvs[made.face_uvs[c]], whole.uvs[whole.face_uvs[there]]);
  }
  EXPECT_TRUE(std::ranges::all_of(is_named, [](bool named) { return named; }));
  for (std::int64_t f = 0; f < faces.count; ++f)
    ASSERT_EQ(made.face_groups[f], whole.face_groups[faces.first + f]);
}

TEST(FaceRangeBlocks, HaveTheSurfacesBits) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const PolygonMesh mesh = test::laden_mesh(seed);
    const DooSabinSurface base(mesh, {});
    for (const int level : {0, 1, 2, 3}) {
      SCOPED_TRACE(level);
      const auto blocks = base.level(level);
      const SurfaceMesh whole = collect(*blocks, {});
      const std::int64_t count = blocks->info().face_count;
      for (const RowRange faces : {RowRange{0, count}, RowRange{count / 3, count / 2},
                                   RowRange{count - 1, 1}, RowRange{0, 1}})
        expect_part_of(whole, *blocks, faces);
    }
  }
}

TEST(FaceRangeBlocks, NumbersKnowTheirPlaces) {
  SubsetNumbers numbers(200);
  numbers.add(std::array<std::int32_t, 5>{199, 3, 64, 63, 3});
  numbers.add(std::array<std::int32_t, 2>{128, 0});
  numbers.finish();
  EXPECT_EQ(std::vector<std::int32_t>(numbers.all().begin(), numbers.all().end()),
            (std::vector<std::int32_t>{0, 3, 63, 64, 128, 199}));
  EXPECT_EQ(numbers.place_of(0), 0);
  EXPECT_EQ(numbers.place_of(64), 3);
  EXPECT_EQ(numbers.place_of(199), 5);
}

}  // namespace
}  // namespace planish
