#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <vector>

#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/solve/backend.h"
#include "planish/solve/packed_rows.h"
#include "planish/solve/stencil_builder.h"
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

// Seeded rows that sum to 1 with a heavy diagonal, so that iterations converge.
StencilTable random_masks(std::int32_t row_count, std::uint32_t seed) {
  std::mt19937 random(seed);
  StencilTable rows;
  for (std::int32_t i = 0; i < row_count; ++i) {
    const std::int32_t others = std::min<std::int32_t>(row_count - 1, 1 + random() % 9);
    rows.sizes.push_back(others + 1);
    rows.indices.push_back(i);
    rows.weights.push_back(0.6);
    for (std::int32_t k = 0; k < others; ++k) {
      rows.indices.push_back(static_cast<std::int32_t>(random() % row_count));
      rows.weights.push_back(0.4 / others);
    }
  }
  rows.close(row_count);
  return rows;
}

std::vector<glm::dvec3> random_points(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<glm::dvec3> points(count);
  for (auto& p : points) p = {uniform(random), uniform(random), uniform(random)};
  return points;
}

// What Solve promises, written down directly.
struct ReferenceSolve {
  StencilView<double> masks;
  std::vector<glm::dvec3> initial, displacement, step;

  [[nodiscard]] std::vector<glm::dvec3> residual() const {
    auto result = initial;
    for (std::int32_t i = 0; i < masks.row_count(); ++i) {
      for (std::int32_t k = masks.offsets[i]; k < masks.offsets[i] + masks.sizes[i]; ++k) {
        result[i] -= masks.weights[k] * displacement[masks.indices[k]];
      }
    }
    return result;
  }
  void take(const StepCoefficients& c) {
    const auto r = residual();
    for (std::size_t i = 0; i < r.size(); ++i) {
      step[i] = c.momentum * step[i] + c.gain * r[i];
      displacement[i] += step[i];
    }
  }
  [[nodiscard]] double max_error() const {
    double largest = 0;
    for (const auto& r : residual()) largest = std::max(largest, glm::length(r));
    return largest;
  }
};

TEST(CpuSolve, StepsEqualTheirDefinition) {
  for (const std::int32_t count : {1, 63, 64, 65, 20000}) {
    const auto masks = random_masks(count, 3);
    ReferenceSolve reference{masks.view(), random_points(count, 5)};
    reference.displacement.assign(count, glm::dvec3(0.0));
    reference.step = reference.displacement;
    const auto backend = make_cpu_backend();
    const auto solve = backend->make_solve(masks.view());
    solve->begin(reference.initial);
    const std::vector<StepCoefficients> steps{{0, 1}, {0.2, 1.1}, {0.3, 0.9}};
    const StepLog log = solve->run(steps, 0);
    EXPECT_EQ(log.steps_taken, 3);
    ASSERT_EQ(log.errors.size(), 3u);
    for (std::size_t k = 0; k < steps.size(); ++k) {
      EXPECT_NEAR(log.errors[k].max, reference.max_error(), 1e-14);
      reference.take(steps[k]);
    }
    const auto displacement = solve->displacement();
    for (std::int32_t i = 0; i < count; ++i) {
      EXPECT_LT(glm::length(displacement[i] - reference.displacement[i]), 1e-14);
    }
    EXPECT_NEAR(solve->error().max, reference.max_error(), 1e-14);
  }
}

// Rows over points and three sums, against the same rows over points alone.
TEST(CpuSolve, TakesSumsAsItTakesTheirPoints) {
  constexpr std::int32_t kCount = 5000, kSums = 3;
  SummedTable table{random_masks(kCount, 4), random_masks(kSums, 7)};
  for (std::size_t k = 3; k < table.rows.indices.size(); k += 11)
    table.rows.indices[k] = kCount + static_cast<std::int32_t>(k) % kSums;
  for (std::size_t k = 0; k < table.sums.indices.size(); ++k)
    table.sums.indices[k] = static_cast<std::int32_t>(701 * k % kCount);
  table.rows.source_count = kCount + kSums;
  table.sums.source_count = kCount;
  const StencilTable whole = expanded(table.view());
  const auto initial = random_points(kCount, 5);
  for (const auto& [precision, most] :
       {std::pair{Precision::Double, 1e-14}, {Precision::Float, 3e-6}}) {
    const auto backend = make_cpu_backend({precision});
    const auto apart = backend->make_solve(table.view()),
               together = backend->make_solve(whole.view());
    const std::vector<StepCoefficients> steps{{0, 1}, {0.2, 1.1}, {0.3, 0.9}};
    for (Solve* const solve : {apart.get(), together.get()}) {
      solve->begin(initial);
      solve->run(steps, 0);
    }
    EXPECT_NEAR(apart->error().max, together->error().max, 10 * most);
    const auto a = apart->displacement(), b = together->displacement();
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(glm::length(a[i] - b[i]), most);
    const std::vector<double> valences(kCount, 1.0);
    const auto one_step = [&](const SummedView& masks) {
      return conjugate_gradients(precision, masks, initial, valences,
                                 [](const ErrorNorms&) { return false; });
    };
    const auto c = one_step(table.view()), d = one_step(whole.view());
    for (std::size_t i = 0; i < c.size(); ++i) EXPECT_LT(glm::length(c[i] - d[i]), 10 * most);
  }
}

TEST(CpuSolve, StopsAtTheFirstErrorThatIsLowEnough) {
  const auto masks = random_masks(1000, 3);
  const auto initial = random_points(1000, 5);
  const auto backend = make_cpu_backend();
  const std::vector<StepCoefficients> steps(40, {0, 1});
  const auto full = backend->make_solve(masks.view());
  full->begin(initial);
  const StepLog all = full->run(steps, 0);
  const auto stopped = backend->make_solve(masks.view());
  stopped->begin(initial);
  const StepLog some = stopped->run(steps, all.errors[7].max);
  EXPECT_EQ(some.steps_taken, 7);
  EXPECT_EQ(some.errors.size(), 8u);
  EXPECT_DOUBLE_EQ(stopped->error().max, all.errors[7].max);
}

TEST(CpuSolve, CarriesOnFromCallToCall) {
  const auto masks = random_masks(500, 3);
  const auto initial = random_points(500, 5);
  const auto backend = make_cpu_backend();
  const std::vector<StepCoefficients> steps{{0, 1}, {0.3, 1}, {0.2, 1.1}, {0.4, 0.7}};
  const auto once = backend->make_solve(masks.view());
  once->begin(initial);
  once->run(steps, 0);
  const auto twice = backend->make_solve(masks.view());
  twice->begin(initial);
  twice->run(std::span(steps).first(1), 0);
  twice->run(std::span(steps).subspan(1), 0);
  EXPECT_EQ(once->displacement(), twice->displacement());
}

TEST(CpuSolve, IsTheSameToTheBitForEveryThreadCount) {
  // Pieces enough for eight threads, and those threads where there are fewer cores: pieces end in
  // any order.
  const oneapi::tbb::global_control wide(oneapi::tbb::global_control::max_allowed_parallelism, 8);
  const auto masks = random_masks(300000, 11);
  const auto initial = random_points(300000, 5);
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    std::vector<glm::dvec3> expected;
    double expected_rms = 0;
    for (const int threads : {1, 2, 3, 8}) {
      const auto backend = make_cpu_backend({precision, threads});
      const auto solve = backend->make_solve(masks.view());
      solve->begin(initial);
      const StepLog log = solve->run(std::vector<StepCoefficients>(5, {0.1, 1}), 0);
      if (threads == 1) {
        expected = solve->displacement();
        expected_rms = log.errors.back().rms;
      }
      EXPECT_EQ(solve->displacement(), expected) << threads;
      EXPECT_EQ(log.errors.back().rms, expected_rms) << threads;
    }
  }
}

TEST(CpuBackend, SaysHowManyThreadsItTakes) {
  EXPECT_EQ(make_cpu_backend({.thread_count = 1})->description().name, "1 thread");
  EXPECT_EQ(make_cpu_backend({.thread_count = 3})->description().name, "3 threads");
}

TEST(CpuSolve, InFloatAgreesWithDoubleToItsPrecision) {
  const auto masks = random_masks(5000, 11);
  const auto initial = random_points(5000, 5);
  const auto float_backend = make_cpu_backend({Precision::Float});
  const auto double_backend = make_cpu_backend({Precision::Double});
  for (const StepCoefficients step : {StepCoefficients{0, 1}, {0.3, 1.1}}) {
    const std::vector<StepCoefficients> steps(10, step);
    const auto in_float = float_backend->make_solve(masks.view());
    const auto in_double = double_backend->make_solve(masks.view());
    in_float->begin(initial);
    in_double->begin(initial);
    in_float->run(steps, 0);
    in_double->run(steps, 0);
    const auto a = in_float->displacement(), b = in_double->displacement();
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      largest = std::max(largest, glm::length(a[i] - b[i]));
    EXPECT_LT(largest, 3e-6);
    EXPECT_GT(largest, 0.0);
  }
}

TEST(CpuSolve, ANanCountsAsAnInfiniteError) {
  const auto masks = random_masks(100, 3);
  auto initial = random_points(100, 5);
  initial[50].y = std::numeric_limits<double>::quiet_NaN();
  const auto backend = make_cpu_backend();
  const auto solve = backend->make_solve(masks.view());
  solve->begin(initial);
  const StepLog log = solve->run(std::vector<StepCoefficients>(2, {0, 1}), 1e9);
  EXPECT_EQ(log.steps_taken, 2);
  EXPECT_TRUE(std::isinf(log.errors[0].max));
  EXPECT_TRUE(std::isinf(solve->error().max));
}

}  // namespace
}  // namespace planish
