#include "planish/solve/packed_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <random>
#include <vector>

#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

using Point = PackedRows::Point;

std::vector<Point> random_lanes(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Point> points(count);
  for (Point& p : points) {
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    p = Point::of({x, y, z});
  }
  return points;
}

// What a plain loop over the table gives, to the bit.
void expect_plain_sums(const StencilView<double>& table, const PackedRows& rows) {
  const std::vector<Point> source = random_lanes(static_cast<std::size_t>(table.source_count));
  std::size_t next = 0;
  for (std::size_t piece = 0; piece < rows.piece_count(); ++piece)
    rows.for_each_sum(piece, source.data(), [&](std::size_t row, const Point& sum) {
      ASSERT_EQ(row, next++);
      Point expected{};
      for (std::int32_t k = 0; k < table.sizes[row]; ++k) {
        const std::int32_t at = table.offsets[row] + k;
        const Point term = static_cast<float>(table.weights[at]) * source[table.indices[at]];
        expected = expected + term;
      }
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(std::bit_cast<std::uint32_t>(float(sum.xyz0[c])),
                  std::bit_cast<std::uint32_t>(float(expected.xyz0[c])))
            << row;
    });
  EXPECT_EQ(next, table.sizes.size());
}

StencilTable masks_of(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  return limit_masks(Subdivision(topology, features, Weights::DooSabin));
}

TEST(PackedRows, OfMasksAreSmallAndTheSameBits) {
  const PolygonMesh meshes[] = {test::torus(120, 90, 2, 0.7), test::icosphere(4)};
  for (const PolygonMesh& mesh : meshes) {
    const StencilTable masks = masks_of(mesh);
    const PackedRows rows(masks.view());
    expect_plain_sums(masks.view(), rows);
    EXPECT_EQ(rows.plain_row_count(), 0u);
    const double entries = static_cast<double>(masks.view().indices.size());
    EXPECT_LE(static_cast<double>(rows.packed_bytes()), 3.5 * entries);
  }
}

TEST(PackedRows, OfUnevenMeshesAreTheSameBits) {
  const PolygonMesh meshes[] = {test::cube(), test::random_closed_mesh(3),
                                test::with_random_creases(test::random_open_mesh(2), 0.1, 3)};
  for (const PolygonMesh& mesh : meshes) {
    const StencilTable masks = masks_of(mesh);
    expect_plain_sums(masks.view(), PackedRows(masks.view()));
  }
}

// Rows of `size` sources each by `index(row, k)`, of weights by `weight(row, k)`.
template <class Size, class Index, class Weight>
StencilTable table_of(std::int32_t rows, const Size& size, const Index& index,
                      const Weight& weight) {
  StencilTable made;
  for (std::int32_t i = 0; i < rows; ++i) {
    made.sizes.push_back(size(i));
    for (std::int32_t k = 0; k < size(i); ++k) {
      made.indices.push_back(index(i, k) % rows);
      made.weights.push_back(weight(i, k));
    }
  }
  made.close(rows);
  return made;
}

TEST(PackedRows, EveryLengthIsTheSameBits) {
  // From none to beyond the longest, also at the table's very end.
  for (const std::int32_t last : {0, 1, 7, 8, 9, 10, 13, 16, 17}) {
    const StencilTable table = table_of(
        300, [&](std::int32_t i) { return i == 299 ? last : i % 20; },
        [](std::int32_t i, std::int32_t k) { return i + k; },
        [](std::int32_t i, std::int32_t k) { return 0.1 + 0.3 * (i % 3) - 0.01 * k; });
    const PackedRows rows(table.view());
    expect_plain_sums(table.view(), rows);
    // 15 rows each of 0, 17, 18 and 19 sources, but for the last one.
    EXPECT_EQ(rows.plain_row_count(), 60u - 1 + (last == 0 || last == 17 ? 1 : 0));
  }
}

// Rows one after another of a piece with equal weights and differences of 16 bits, in runs of at
// least 8 and a multiple of that.
std::size_t alike_rows(const StencilView<double>& table) {
  const auto are_alike = [&](std::size_t a, std::size_t b) {
    if (table.sizes[a] != table.sizes[b]) return false;
    for (std::int32_t k = 0; k < table.sizes[a]; ++k) {
      const std::int32_t in_a = table.offsets[a] + k, in_b = table.offsets[b] + k;
      if (table.weights[in_a] != table.weights[in_b] ||
          table.indices[in_b] - table.indices[in_a] != static_cast<std::int32_t>(b - a))
        return false;
    }
    return true;
  };
  std::size_t count = 0;
  for (std::size_t begin = 0, end = 0; begin < table.sizes.size(); begin = end) {
    const std::size_t piece_end =
        std::min(table.sizes.size(), (begin / PackedRows::kPieceRows + 1) * PackedRows::kPieceRows);
    for (end = begin + 1; end < piece_end && are_alike(end - 1, end);) ++end;
    bool is_packed = table.sizes[begin] > 0 && table.sizes[begin] <= 16;
    for (std::int32_t k = 0; k < table.sizes[begin]; ++k)
      if (std::abs(table.indices[table.offsets[begin] + k] - static_cast<std::int32_t>(begin)) >
          32767)
        is_packed = false;
    if (is_packed) count += (end - begin) / 8 * 8;
  }
  return count;
}

TEST(PackedRows, RowsThatAreAlikeMakeRuns) {
  // 1 to 40 rows of each kind, one after another over the end of a piece.
  std::vector<std::int32_t> kinds;
  for (std::int32_t kind = 0; kinds.size() < 6000; ++kind)
    kinds.insert(kinds.end(), static_cast<std::size_t>(1 + kind % 40), kind);
  const StencilTable table = table_of(
      static_cast<std::int32_t>(kinds.size()), [&](std::int32_t i) { return kinds[i] % 19; },
      [&](std::int32_t i, std::int32_t k) { return i + k * (1 + kinds[i] % 3); },
      [&](std::int32_t i, std::int32_t k) { return 0.1 * (1 + kinds[i] % 2) - 0.01 * k; });
  const PackedRows rows(table.view());
  expect_plain_sums(table.view(), rows);
  EXPECT_GT(rows.alike_row_count(), 3000u);
  EXPECT_EQ(rows.alike_row_count(), alike_rows(table.view()));
}

TEST(PackedRows, OfAGridOfQuadsAreNearlyAllAlike) {
  const StencilTable masks = masks_of(test::torus(300, 200, 2, 0.7));
  const PackedRows rows(masks.view());
  expect_plain_sums(masks.view(), rows);
  EXPECT_EQ(rows.alike_row_count(), alike_rows(masks.view()));
  EXPECT_GT(rows.alike_row_count(), masks.view().sizes.size() * 9 / 10);
  EXPECT_LT(rows.packed_bytes(), 4 * masks.view().sizes.size());
}

TEST(PackedRows, FarSourcesTakeTheTableOrIndices) {
  constexpr std::int32_t kRows = 100'000;
  const auto size = [](std::int32_t) { return 5; };
  const auto weight = [](std::int32_t, std::int32_t k) { return 0.2 + 0.01 * k; };
  // One row in a hundred reaches far.
  const StencilTable few = table_of(
      kRows, size,
      [](std::int32_t i, std::int32_t k) { return i % 100 == 0 && k == 3 ? i + 40'000 : i + k; },
      weight);
  const PackedRows few_rows(few.view());
  expect_plain_sums(few.view(), few_rows);
  // Those whose sources wrap around at the end reach far as well.
  EXPECT_EQ(few_rows.plain_row_count(), 1004u);
  // All do: indices of 4 bytes.
  const StencilTable all = table_of(
      kRows, size, [](std::int32_t i, std::int32_t k) { return i + 40'000 * (k % 2); }, weight);
  const PackedRows all_rows(all.view());
  expect_plain_sums(all.view(), all_rows);
  EXPECT_EQ(all_rows.plain_row_count(), 0u);
  EXPECT_GT(all_rows.packed_bytes(), std::uint64_t{kRows} * 8 * 4);
}

TEST(PackedRows, MoreKindsOfRowsThanAPaletteHoldsAreRead) {
  const StencilTable table = table_of(
      5000, [](std::int32_t) { return 6; }, [](std::int32_t i, std::int32_t k) { return i + k; },
      [](std::int32_t i, std::int32_t k) { return 1.0 / (i + k + 1); });
  const PackedRows rows(table.view());
  expect_plain_sums(table.view(), rows);
  EXPECT_EQ(rows.plain_row_count(), 5000u - 1024 - (5000 - 4096));
}

}  // namespace
}  // namespace planish
