#include "planish/reconstruct/reconstruct_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

namespace planish {
namespace {

using testing::IsEmpty;

const auto kNoEdges = [](std::int32_t, std::int32_t) { return false; };

TEST(FillHole, CutsAFoldedQuadAlongItsRidge) {
  // Two roof halves meet in the ridge from 0 to 2; the rim continues them outwards.
  const std::vector<glm::dvec3> positions = {{0, 0, 0.2}, {0.5, 1, 0}, {1, 0, 0.2}, {0.5, -1, 0}};
  const glm::dvec3 right = glm::normalize(glm::dvec3(0, 0.2, 1));
  const glm::dvec3 left = glm::normalize(glm::dvec3(0, -0.2, 1));
  const Hole hole{.loop = {0, 3, 2, 1}, .normals = {left, left, right, right}};
  const auto patch = fill_hole(positions, hole, kNoEdges);
  ASSERT_EQ(patch.size(), 2u);
  for (const Triangle& t : patch) {
    EXPECT_NE(std::ranges::find(t, 0), t.end());
    EXPECT_NE(std::ranges::find(t, 2), t.end());
  }
  // That edge is taken: the other way.
  const auto other = fill_hole(positions, hole, [](std::int32_t a, std::int32_t b) {
    return std::min(a, b) == 0 && std::max(a, b) == 2;
  });
  ASSERT_EQ(other.size(), 2u);
  for (const Triangle& t : other) EXPECT_NE(std::ranges::find(t, 1), t.end());
}

TEST(FillHole, KeepsTheLoopsDirection) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Hole hole{.loop = {2, 0, 1}, .normals = std::vector(3, glm::dvec3(0, 0, 1))};
  const auto patch = fill_hole(positions, hole, kNoEdges);
  ASSERT_EQ(patch.size(), 1u);
  EXPECT_EQ(patch[0], (Triangle{2, 0, 1}));
}

TEST(FillHole, GivesUpWhereNoPatchExists) {
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_THAT(fill_hole(line, {{0, 1, 2}, std::vector(3, glm::dvec3(0, 0, 1))}, kNoEdges),
              IsEmpty());
  const std::vector<glm::dvec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_THAT(fill_hole(square, {{0, 1, 2, 3}, std::vector(4, glm::dvec3(0, 0, 1))},
                        [](std::int32_t, std::int32_t) { return true; }),
              IsEmpty());
}

}  // namespace
}  // namespace planish
