#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <glm/geometric.hpp>
#include <random>
#include <set>

#include "planish/files/tiles/tile.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

TEST(CurveOrder, CellsThatFollowOneAnotherShareAFace) {
  // The 16^3 largest cubes of the curve, by any of their cells, in its order.
  struct Cube {
    std::uint64_t key;
    int x, y, z;
  };
  std::vector<Cube> cubes;
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      for (int z = 0; z < 16; ++z) {
        const auto cell = [](int i) { return static_cast<std::uint32_t>(i) << (kCurveBits - 4); };
        cubes.push_back({hilbert_key(cell(x), cell(y), cell(z)) >> 3 * (kCurveBits - 4), x, y, z});
      }
  std::ranges::sort(cubes, {}, &Cube::key);
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    ASSERT_EQ(cubes[i].key, i);  // each place once
    if (i == 0) continue;
    const Cube &a = cubes[i - 1], &b = cubes[i];
    ASSERT_EQ(std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z), 1) << i;
  }
}

TEST(CurveOrder, SmallestCellsShareAFaceToo) {
  // A corner of 8 cells has 8 places that follow one another.
  std::set<std::uint64_t> keys;
  for (std::uint32_t i = 0; i < 8; ++i)
    keys.insert(hilbert_key(1234560 + (i & 1), 42 + (i >> 1 & 1), 2000000 + (i >> 2)));
  EXPECT_EQ(keys.size(), 8u);
  EXPECT_EQ(*keys.rbegin() - *keys.begin(), 7u);
  EXPECT_EQ(*keys.begin() % 8, 0u);
  EXPECT_LT(hilbert_key(0x1fffff, 0x1fffff, 0x1fffff), std::uint64_t{1} << 63);
}

TEST(CurveOrder, PointsOfOnePlaceKeepTheirOrder) {
  const std::vector<glm::dvec3> points{{1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  const auto order = curve_order(points);
  EXPECT_EQ(order, (std::vector<std::int32_t>{1, 3, 0, 2}));
  const std::vector<glm::dvec3> same(3, glm::dvec3(7.0));
  EXPECT_EQ(curve_order(same), (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(CurveOrder, DoesNotDependOnThreads) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-3, 3);
  std::vector<glm::dvec3> points(50'000);
  for (glm::dvec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  for (std::size_t i = 0; i < 1000; ++i) points[49'999 - i] = points[i];
  using oneapi::tbb::global_control;
  const auto with = [&](std::size_t threads) {
    const global_control limit(global_control::max_allowed_parallelism, threads);
    return curve_order(points);
  };
  const auto one = with(1);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(5));
  auto sorted = one;
  std::ranges::sort(sorted);
  for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], static_cast<int>(i));
}

TEST(LocalNumbers, ArePlacesAmongThoseThatOccur) {
  std::mt19937 random(3);
  std::vector<std::int32_t> numbers(20'000);
  for (std::int32_t& n : numbers) n = static_cast<std::int32_t>(random() % 5000) * 429'496;
  std::vector<std::int32_t> local = numbers;
  const RawVector<std::int32_t> rows = make_local(local);
  const std::set<std::int32_t> occur(numbers.begin(), numbers.end());
  EXPECT_TRUE(std::ranges::equal(rows, occur));
  for (std::size_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(rows[local[i]], numbers[i]);
}

TEST(TileGrid, DifferencesToAnOriginAreFloats) {
  const double far = 3e6, reach = 12.7;
  const TileGrid grid(reach, far + reach);
  EXPECT_LE(grid.step(), reach * std::ldexp(1.0, -22));
  const glm::dvec3 origin = grid.snap(glm::dvec3(far, -far, 0.1));
  std::mt19937 random(8);
  std::uniform_real_distribution<double> offset(-reach, reach);
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 wanted = origin + glm::dvec3(offset(random), offset(random), offset(random));
    const glm::dvec3 snapped = grid.snap(wanted);
    const glm::dvec3 local = snapped - origin;
    ASSERT_EQ(glm::dvec3(glm::vec3(local)), local);
    ASSERT_EQ(origin + local, snapped);
    ASSERT_LE(glm::length(snapped - wanted), 0.87 * grid.step());
  }
  EXPECT_EQ(TileGrid(1.0, 1.0).step(), std::ldexp(1.0, -23));
  EXPECT_GE(TileGrid(1.0, 1.0).reach(), 1.0);
  EXPECT_EQ(TileGrid(1.0, 1.0, 15).step(), std::ldexp(1.0, -14));
  EXPECT_EQ(TileGrid(1.0, 1.0, 23, 0.01).step(), std::ldexp(1.0, -7)) << "at most 0.01";
  EXPECT_EQ(TileGrid(1e-9, 1024.0).step(), std::ldexp(1.0, 11 - 53)) << "doubles end before";
}

// All that rows may be asked for.
struct AllOfRows {
  explicit AllOfRows(std::size_t count) : positions(count), normals(count), colors(count) {}
  [[nodiscard]] RowTarget target() {
    RowTarget target;
    target.positions = positions;
    target.normals = normals;
    target.colors = colors;
    return target;
  }

  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> colors;
};

TEST(RowsAt, HaveTheBitsOfRowsInRanges) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const PolygonMesh mesh = test::laden_mesh(seed);
    const DooSabinSurface surface(mesh, EvaluateOptions{});
    for (int level = 1; level <= 4; ++level) {
      const DooSabinBlocks blocks(surface, level, nullptr);
      const auto count = static_cast<std::size_t>(blocks.info().row_count);
      AllOfRows all(count);
      (void)blocks.rows({0, blocks.info().row_count}, all.target());
      std::mt19937 random(seed);
      for (const unsigned part : {1u, 3u, 40u}) {
        std::vector<std::int32_t> rows;
        for (std::size_t r = 0; r < count; ++r)
          if (random() % part == 0) rows.push_back(static_cast<std::int32_t>(r));
        AllOfRows some(rows.size());
        (void)blocks.rows_at(rows, some.target());
        for (std::size_t i = 0; i < rows.size(); ++i) {
          ASSERT_EQ(some.positions[i], all.positions[rows[i]]) << level << " " << rows[i];
          ASSERT_EQ(some.normals[i], all.normals[rows[i]]) << level << " " << rows[i];
          ASSERT_EQ(some.colors[i], all.colors[rows[i]]) << level << " " << rows[i];
        }
      }
    }
  }
}

// Four quads of level l in the place of one of level l - 1: corners, middles, the centre.
SurfaceMesh split_quad(const glm::dvec3& lift_of_centre, const glm::dvec3& lift_of_corner) {
  SurfaceMesh mesh;
  mesh.level = 2;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) mesh.positions.emplace_back(i, j, 0);
  mesh.positions[0] += lift_of_corner;
  // Middles and the centre stay on the bilinear quad, but for its own lift.
  mesh.positions[1] += 0.5 * lift_of_corner;
  mesh.positions[3] += 0.5 * lift_of_corner;
  mesh.positions[4] += 0.25 * lift_of_corner + lift_of_centre;
  // Child j at corner j, which keeps its place.
  const int corners[4] = {0, 2, 8, 6}, middles[4] = {1, 5, 7, 3};
  for (int j = 0; j < 4; ++j) {
    int child[4];
    child[j] = corners[j];
    child[(j + 1) % 4] = middles[j];
    child[(j + 2) % 4] = 4;
    child[(j + 3) % 4] = middles[(j + 3) % 4];
    mesh.face_vertices.insert(mesh.face_vertices.end(), child, child + 4);
  }
  return mesh;
}

// Parts of a surface begin at multiples of each other's lengths: their runs met in one place of the
// table, and 250,000 vertices took a minute of CPU.
TEST(LocalNumbers, RunsThatLieAlikeAreFoundQuickly) {
  constexpr std::int32_t kRun = 1 << 14, kApart = 1 << 22, kRuns = 16;
  std::vector<std::int32_t> numbers;
  for (std::int32_t run = kRuns; run-- > 0;)
    for (std::int32_t i = 0; i < kRun; ++i) numbers.push_back(run * kApart + i);
  const std::clock_t begin = std::clock();
  const RawVector<std::int32_t> found = make_local(numbers);
  constexpr double kSeconds = 2;  // 0.02 where it had taken 23
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, kSeconds);
  ASSERT_EQ(found.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    ASSERT_EQ(numbers[i], kRuns * kRun - kRun * (1 + static_cast<std::int32_t>(i) / kRun) +
                              static_cast<std::int32_t>(i) % kRun);
}

TEST(CoarserError, IsTheFarthestMiddleAndAQuarterOfTheTwist) {
  EXPECT_EQ(coarser_error(split_quad({0, 0, 0}, {0, 0, 0})), 0);
  EXPECT_EQ(coarser_error(split_quad({0, 0, 0.5}, {0, 0, 0})), 0.5);
  EXPECT_EQ(coarser_error(split_quad({0, 0, 0}, {0, 0, 4})), 1);
  EXPECT_EQ(coarser_error(split_quad({0, 0, -0.5}, {0, 0, 4})), 1.5);
}

TEST(TilePlan, EachFaceIsInOneTileOfEachLevel) {
  for (const std::uint32_t seed : {4u, 5u}) {
    const PolygonMesh mesh = test::laden_mesh(seed);
    const DooSabinSurface surface(mesh, EvaluateOptions{});
    const auto order = curve_order(surface.mesh().positions);
    std::vector<std::int32_t> places(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = static_cast<std::int32_t>(i);
    const TilePlan plan =
        plan_tiles(surface.topology(), surface.hidden(), places,
                   {.place_count = std::ssize(order), .block_vertices = 10, .level = 3});
    std::vector<std::multiset<std::int32_t>> found(4);
    for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
      const PlannedTile& tile = plan.tiles[i];
      ASSERT_FALSE(plan.faces_of(tile).empty());
      for (const std::int32_t face : plan.faces_of(tile)) {
        found[tile.level].insert(face);
        EXPECT_TRUE(plan.holds(tile, face));
        std::int32_t first = mesh.vertex_count();
        for (const std::int32_t v : surface.topology().face(face))
          first = std::min(first, places[v]);
        EXPECT_EQ(plan.face_places[face], first);
      }
      if (tile.level == 1) continue;
      const PlannedTile& parent = plan.tiles[tile.parent];
      EXPECT_LT(tile.parent, static_cast<std::int32_t>(i));
      EXPECT_EQ(parent.level, tile.level - 1);
      EXPECT_EQ(parent.block, tile.block);
      EXPECT_EQ(parent.quarter, tile.quarter / 4);
    }
    std::multiset<std::int32_t> visible;
    for (std::int32_t f = 0; f < surface.topology().face_count(); ++f)
      if (surface.hidden()[f] == 0) visible.insert(f);
    for (int level = 1; level <= 3; ++level) EXPECT_EQ(found[level], visible) << level;
  }
}

// A finer level may be off by more than its coarser one, as where a fold shows at level 3 alone.
TEST(PassErrorsUp, ParentsAreOffByNoLessThanAnyBelow) {
  std::vector<PlannedTile> tiles(4);
  tiles[1].level = tiles[2].level = 2;
  tiles[3].level = 3;
  tiles[1].parent = tiles[2].parent = 0;
  tiles[3].parent = 1;
  std::vector<WrittenTile> written(4);
  written[1].coarser_error = 0.25;
  written[2].coarser_error = 0.5;
  written[3].coarser_error = 2;
  for (const int level : {3, 2}) pass_errors_up(tiles, level, written);
  EXPECT_EQ(written[3].record.error, 0);
  EXPECT_EQ(written[1].record.error, 2);
  EXPECT_EQ(written[2].record.error, 0);
  EXPECT_EQ(written[0].record.error, 2);
  written[2].coarser_error = 7;
  pass_errors_up(tiles, 2, written);
  EXPECT_EQ(written[0].record.error, 7);
}

}  // namespace
}  // namespace planish
