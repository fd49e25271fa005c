// The viewer's crowd: all levels in one picture, which looks as one of the finest level alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "support/meshes.h"
#include "viewer/crowd.h"
#include "viewer/fixture.h"
#include "viewer/scene.h"

namespace planish::testing {
namespace {

using namespace viewer;

class CrowdTest : public ViewerTest {};

CrowdOptions small_crowd(std::uint32_t count) {
  CrowdOptions options;
  options.extent = {320, 180};
  options.count = count;
  return options;
}

TEST_F(CrowdTest, LooksAsItsFinestLevel) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  std::vector<std::uint8_t> pictures[3];
  std::uint64_t triangles[3];
  for (int i = 0; i < 3; ++i) {
    CrowdOptions options = small_crowd(60);
    options.chord_pixels = 0.1f;
    if (i == 1) options.levels = {4};
    if (i == 2) options.levels = {1};
    Crowd crowd(*device_, scene_of(mesh), options);
    crowd.run(3);
    pictures[i] = crowd.picture();
    triangles[i] = crowd.figures().triangles;
  }
  const auto differing = [&](int i) {
    std::size_t differ = 0;
    for (std::size_t k = 0; k < pictures[0].size(); ++k)
      differ += std::abs(pictures[1][k] - pictures[i][k]) > 6;
    return differ;
  };
  EXPECT_LT(differing(0), pictures[0].size() / 200);
  EXPECT_GT(differing(2), 2 * differing(0));
  EXPECT_LT(5 * triangles[0], triangles[1]);
  EXPECT_GT(triangles[0], triangles[2]);
}

// In one frame: from near to far, and some that nobody sees.
TEST_F(CrowdTest, OfAThousandHasAllLevels) {
  CrowdOptions options = small_crowd(1000);
  Crowd crowd(
      *device_,
      load_scene(PLANISH_SCENES "/cube_with_windows.obj", "", InterpolationMethod::Progressive),
      options);
  crowd.run(1);
  const CrowdFigures figures = crowd.figures();
  EXPECT_EQ(std::accumulate(figures.instances.begin(), figures.instances.end(), figures.unseen),
            1000u);
  EXPECT_GT(figures.unseen, 100u);
  for (std::size_t k = 0; k + 1 < figures.instances.size(); ++k)
    EXPECT_GT(figures.instances[k], 0u) << k;
  // Levels for what is near are for few.
  EXPECT_TRUE(std::is_sorted(figures.instances.rbegin(), figures.instances.rend()));
}

}  // namespace
}  // namespace planish::testing
