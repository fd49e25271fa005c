#include "planish/adaptive/adaptive_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <random>

#include "limit/limit_case.h"

namespace planish::test {
namespace {

constexpr std::int32_t kSide = 2 * kCellSide;

// Places of a side, no two farther apart than `longest`: even ones, or any.
std::vector<std::uint16_t> any_side(std::mt19937& random, std::int32_t parts) {
  std::vector<std::uint16_t> places{0};
  if (random() % 3 == 0) {
    const auto finer = parts + static_cast<std::int32_t>(random() % 5);
    for (std::int32_t i = 1; i < finer; ++i) places.push_back(even_place(i, finer));
    return places;
  }
  const std::int32_t longest = kSide / parts;
  while (kSide - places.back() > longest)
    places.push_back(static_cast<std::uint16_t>(places.back() + 1 +
                                                random() % static_cast<std::uint32_t>(longest)));
  return places;
}

// All vertices of a grid in its square.
std::vector<glm::dvec3> places_of(const FaceGrid& grid,
                                  const std::array<std::vector<std::uint16_t>, 4>& sides) {
  std::vector<glm::dvec3> places;
  for (const double t : sides[0]) places.emplace_back(t, 0, 0);
  for (const double t : sides[1]) places.emplace_back(kSide, t, 0);
  for (const double t : sides[2]) places.emplace_back(kSide - t, kSide, 0);
  for (const double t : sides[3]) places.emplace_back(0, kSide - t, 0);
  for (std::int32_t j = 1; j < grid.v; ++j) {
    for (std::int32_t i = 1; i < grid.u; ++i)
      places.emplace_back(even_place(i, grid.u), even_place(j, grid.v), 0);
  }
  return places;
}

// That is what the bound on a grid's parts is for.
TEST(GridTriangles, AreNoLargerThanPartsAndCoverTheFace) {
  std::mt19937 random(5);
  GridTriangles cutter;
  for (int round = 0; round < 20000; ++round) {
    const FaceGrid grid{static_cast<std::uint8_t>(1 + random() % 6),
                        static_cast<std::uint8_t>(1 + random() % 6)};
    std::array<std::vector<std::uint16_t>, 4> sides;
    for (int s = 0; s < 4; ++s) sides[s] = any_side(random, grid.parts_of_side(s));
    const std::vector<glm::dvec3> places = places_of(grid, sides);
    const auto triangles = cutter.cut(grid, {sides[0], sides[1], sides[2], sides[3]}, places);
    const std::size_t around = places.size() - static_cast<std::size_t>(grid.inside());
    ASSERT_EQ(triangles.size(), around - 2 + 2 * static_cast<std::size_t>(grid.inside()));
    double area = 0;
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    for (const auto& t : triangles) {
      const auto at = [&](std::size_t k) { return places[t[k % 3]]; };
      const glm::dvec3 ab = at(1) - at(0), ac = at(2) - at(0);
      const double twice = ab.x * ac.y - ab.y * ac.x;
      ASSERT_GT(twice, 0);
      area += twice;
      for (int d = 0; d < 2; ++d) {
        const auto [low, high] = std::minmax({at(0)[d], at(1)[d], at(2)[d]});
        ASSERT_LE(high - low, double{kSide} / grid.parts_of_side(d) + 2)
            << int{grid.u} << " by " << int{grid.v};
      }
      for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    ASSERT_EQ(area, 2.0 * kSide * kSide);
    for (const auto& [ends, count] : edges) {
      ASSERT_EQ(count, 1);
      const bool is_side = ends.second == (ends.first + 1) % static_cast<std::int32_t>(around) &&
                           ends.first < static_cast<std::int32_t>(around);
      ASSERT_EQ(edges.contains({ends.second, ends.first}), !is_side);
    }
  }
}

// Flat cells are all ties: between ears, and between the diagonals of parts.
TEST(GridTriangles, AreTheSameHoweverPlacesAreRounded) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> rounding(-1e-12 * kSide, 1e-12 * kSide);
  GridTriangles cutter;
  for (int round = 0; round < 2000; ++round) {
    const FaceGrid grid{static_cast<std::uint8_t>(1 + random() % 4),
                        static_cast<std::uint8_t>(1 + random() % 4)};
    std::array<std::vector<std::uint16_t>, 4> sides;
    for (int s = 0; s < 4; ++s) sides[s] = any_side(random, grid.parts_of_side(s));
    std::vector<glm::dvec3> places = places_of(grid, sides);
    const auto cut = [&] {
      const auto triangles = cutter.cut(grid, {sides[0], sides[1], sides[2], sides[3]}, places);
      return std::vector(triangles.begin(), triangles.end());
    };
    const auto exact = cut();
    for (glm::dvec3& place : places)
      place += glm::dvec3(rounding(random), rounding(random), rounding(random));
    ASSERT_EQ(cut(), exact) << int{grid.u} << " by " << int{grid.v};
  }
}

TEST(GridTriangles, OnlyOfFacesThatShareOneEdgeWithAnother) {
  const auto all_stand_alone = [](const PolygonMesh& mesh) {
    const MeshTopology topology(mesh);
    for (std::int32_t f = 0; f < topology.face_count(); ++f)
      if (!stands_alone(topology, f)) return false;
    return true;
  };
  EXPECT_TRUE(all_stand_alone(cube()));
  EXPECT_TRUE(all_stand_alone(torus(3, 4, 2, 1)));
  // Of a pillow, and of two faces at a vertex of two edges.
  const std::vector<glm::dvec3> places{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {2, 2, 0}};
  EXPECT_FALSE(all_stand_alone(make_mesh(places, {{0, 1, 2, 3}, {3, 2, 1, 0}})));
  EXPECT_FALSE(all_stand_alone(make_mesh(places, {{0, 1, 2, 3}, {1, 4, 3, 2}})));
}

}  // namespace
}  // namespace planish::test
