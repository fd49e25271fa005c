#include "make_scenes/shapes.h"

#include <gtest/gtest.h>

#include <set>

#include "planish/mesh/check.h"
#include "scenes/topology.h"

namespace planish::shapes {
namespace {

TEST(RandomPolygonMesh, IsClosedAndUsableForEverySeed) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const PolygonMesh mesh =
        random_polygon_mesh({.seed = seed, .level = 2, .merged_share = 0.015 * seed});
    EXPECT_TRUE(check(mesh).empty()) << "seed " << seed;
    const Topology topology = topology_of(mesh);
    EXPECT_EQ(topology.euler_characteristic(), 2) << "seed " << seed;
    EXPECT_EQ(topology.border_edge_count, 0) << "seed " << seed;
    EXPECT_EQ(topology.vertex_count, mesh.vertex_count()) << "seed " << seed;
    EXPECT_GT(volume_of(mesh), 3.0) << "seed " << seed;
  }
}

TEST(RandomPolygonMesh, MixesFaceSizesUpToTheLargest) {
  const PolygonMesh mesh = random_polygon_mesh({.merged_share = 0.7, .largest_face = 6});
  std::set<std::int32_t> sizes;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) sizes.insert(mesh.face_size(f));
  EXPECT_EQ(sizes, (std::set<std::int32_t>{3, 4, 5, 6}));
}

TEST(RandomPolygonMesh, DependsOnTheSeedAlone) {
  const PolygonMesh a = random_polygon_mesh({.seed = 7});
  const PolygonMesh b = random_polygon_mesh({.seed = 7});
  const PolygonMesh c = random_polygon_mesh({.seed = 8});
  EXPECT_EQ(a.face_vertices, b.face_vertices);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_NE(a.face_vertices, c.face_vertices);
}

TEST(MixedPolygons, AreUsableForEverySeed) {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const PolygonMesh mesh = mixed_polygons(seed);
    EXPECT_TRUE(check(mesh).empty()) << "seed " << seed;
    EXPECT_EQ(topology_of(mesh).euler_characteristic(), 2) << "seed " << seed;
  }
}

}  // namespace
}  // namespace planish::shapes
