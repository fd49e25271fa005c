#include "planish/reconstruct/reconstruct_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planish/reconstruct/reconstruct.h"
#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

constexpr std::int32_t kSize = 40;

test::TriangleMesh wave() {
  return test::grid_mesh(kSize, [](double i, double) { return 4 * std::cos(0.15 * i); });
}

std::int32_t at(std::int32_t i, std::int32_t j) { return i * (kSize + 1) + j; }

// Over the rim's bay at j = 0, from one of its ends.
std::vector<Triangle> flap() {
  std::vector<Triangle> triangles;
  for (std::int32_t i = 2; i < kSize - 1; ++i)
    triangles.push_back({at(1, 0), at(i + 1, 0), at(i, 0)});
  return triangles;
}

std::vector<std::uint8_t> bridges_of(const test::TriangleMesh& mesh) {
  return open_bridges(mesh.positions, mesh.triangles);
}

TEST(OpenBridges, AreFlapsOverABay) {
  test::TriangleMesh mesh = wave();
  const std::size_t sheet = mesh.triangles.size();
  EXPECT_EQ(std::ranges::count(bridges_of(mesh), 1), 0);
  for (const Triangle& t : flap()) mesh.triangles.push_back(t);
  const std::vector<std::uint8_t> bridges = bridges_of(mesh);
  EXPECT_EQ(std::ranges::count(bridges, 1),
            std::ranges::count(bridges.begin() + sheet, bridges.end(), 1));
  // The first ones are no longer than the sheet's own.
  EXPECT_EQ(std::ranges::count(bridges.begin() + sheet + 4, bridges.end(), 0), 0);
  const RepairedTriangles repaired =
      repair_triangles(mesh.positions, mesh.triangles, {.longest_filled_loop = 0});
  EXPECT_EQ(repaired.dropped_triangle_count, std::ranges::count(bridges, 1));
}

TEST(OpenBridges, AreStripsAcrossAHoleButNotWhatClosesIt) {
  test::TriangleMesh mesh = wave();
  std::vector<std::int32_t> loop;  // counter-clockwise about the hole from 10 to 30
  for (std::int32_t k = 10; k < 30; ++k) loop.push_back(at(k, 10));
  for (std::int32_t k = 10; k < 30; ++k) loop.push_back(at(30, k));
  for (std::int32_t k = 30; k > 10; --k) loop.push_back(at(k, 30));
  for (std::int32_t k = 30; k > 10; --k) loop.push_back(at(10, k));
  std::erase_if(mesh.triangles, [](const Triangle& t) {
    return std::ranges::all_of(t, [](std::int32_t v) {
      const std::int32_t i = v / (kSize + 1), j = v % (kSize + 1);
      return i >= 10 && i <= 30 && j >= 10 && j <= 30;
    });
  });
  const std::size_t rest = mesh.triangles.size(), count = loop.size();
  test::TriangleMesh closed = mesh, strip = mesh;
  const auto middle = static_cast<std::int32_t>(mesh.positions.size());
  closed.positions.emplace_back(20, 20, 4 * std::cos(3));
  for (std::size_t k = 0; k < count; ++k)
    closed.triangles.push_back({middle, loop[k], loop[(k + 1) % count]});
  EXPECT_EQ(std::ranges::count(bridges_of(closed), 1), 0);
  strip.triangles.push_back({loop[30], loop[70], loop[69]});
  strip.triangles.push_back({loop[30], loop[31], loop[69]});
  std::vector<std::uint8_t> bridges = bridges_of(strip);
  EXPECT_EQ(std::ranges::count(bridges, 1), 2);
  EXPECT_TRUE(bridges[rest] && bridges[rest + 1]);
}

// A strip of two triangles from the wave to rows of another, 20 away.
test::TriangleMesh joined(std::int32_t rows) {
  test::TriangleMesh mesh = wave();
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  const test::TriangleMesh other = wave();
  for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + glm::dvec3(0, 60, 0));
  for (const Triangle& t : other.triangles)
    if (std::ranges::all_of(t, [&](std::int32_t v) { return v % (kSize + 1) <= rows; }))
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  mesh.triangles.push_back({at(10, kSize), at(11, kSize), first + at(10, 0)});
  mesh.triangles.push_back({at(11, kSize), first + at(11, 0), first + at(10, 0)});
  return mesh;
}

TEST(OpenBridges, AreWhatJoinsTwoSheetsButNotWhatHoldsAScrap) {
  EXPECT_EQ(std::ranges::count(bridges_of(joined(kSize)), 1), 2);
  test::TriangleMesh mesh = joined(0);
  const auto first = static_cast<std::int32_t>(mesh.positions.size()) / 2;
  for (const std::int32_t i : {9, 10, 11})
    mesh.triangles.push_back({first + at(i, 0), first + at(i + 1, 0), first + at(i, 1)});
  EXPECT_EQ(std::ranges::count(bridges_of(mesh), 1), 0);
  for (const Triangle& t : flap()) mesh.triangles.push_back(t);
  EXPECT_GT(std::ranges::count(bridges_of(mesh), 1), 30);
}

}  // namespace
}  // namespace planish
