#include "viewer/renderer.h"

#include <gmock/gmock.h>

#include "support/meshes.h"

namespace planish::testing {
namespace {

using viewer::nearest_given;
using viewer::NearestGiven;

std::vector<std::uint32_t> rows_of(const NearestGiven& nearest, std::size_t vertex) {
  return {nearest.rows.begin() + nearest.offsets[vertex],
          nearest.rows.begin() + nearest.offsets[vertex + 1]};
}

TEST(NearestGiven, OfAGivenPointIsItself) {
  vulkan::SystemOptions options;
  for (options.level = 0; options.level < 3; ++options.level) {
    const vulkan::System system(test::torus(9, 6, 2, 0.7), options);
    const NearestGiven nearest = nearest_given(system);
    ASSERT_EQ(nearest.offsets.size(), static_cast<std::size_t>(system.vertex_count()) + 1);
    for (std::uint32_t i = 0; i < system.used_vertices().size(); ++i)
      EXPECT_THAT(rows_of(nearest, i), ::testing::ElementsAre(i));
  }
}

TEST(NearestGiven, OfTheCubesLevelOneAreEdgeEndsAndFaceCorners) {
  vulkan::SystemOptions options;
  options.level = 1;
  const vulkan::System system(test::cube(), options);  // 8 corners, 12 edges, 6 faces
  ASSERT_EQ(system.vertex_count(), 26);
  std::vector<std::size_t> sizes;
  const NearestGiven nearest = nearest_given(system);
  for (std::size_t i = 8; i < 26; ++i) sizes.push_back(rows_of(nearest, i).size());
  EXPECT_EQ(std::ranges::count(sizes, 2u), 12);
  EXPECT_EQ(std::ranges::count(sizes, 4u), 6);
}

// Every face stands alone there: most of its corners are copies of vertices in other faces.
TEST(NearestGiven, ReachesEveryFaceOfACubeWithCreasedEdges) {
  PolygonMesh cube = test::cube();
  for (std::int32_t f = 0; f < cube.face_count(); ++f)
    for (std::int32_t k = 0; k < 4; ++k)
      cube.creases.push_back({cube.face(f)[k], cube.face(f)[(k + 1) % 4]});
  for (std::int32_t v = 0; v < 8; ++v) cube.corners.push_back({v});
  vulkan::SystemOptions options;
  options.level = 1;
  const vulkan::System system(cube, options);
  ASSERT_EQ(system.vertex_count(), 6 * 9);  // 9 in each face, none shared
  const NearestGiven nearest = nearest_given(system);
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < 54; ++i) sizes.push_back(rows_of(nearest, i).size());
  EXPECT_EQ(std::ranges::count(sizes, 1u), 24);
  EXPECT_EQ(std::ranges::count(sizes, 2u), 24);
  EXPECT_EQ(std::ranges::count(sizes, 4u), 6);
}

}  // namespace
}  // namespace planish::testing
