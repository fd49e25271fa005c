#include "planish/solve/backend.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "planish/solve/stencil_builder.h"

namespace planish {
namespace {

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
    EXPECT_EQ(apart->cg_begin(initial, valences), together->cg_begin(initial, valences));
    EXPECT_LT(glm::length(apart->cg_apply() - together->cg_apply()), kCount * most);
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

TEST(CpuBackend, AppliesTablesAtAnOffset) {
  const auto table = random_masks(300, 3);
  const auto source = random_points(300, 5);
  const auto backend = make_cpu_backend();
  const auto from = backend->upload(source);
  const auto to = backend->allocate(310);
  backend->apply(table.view(), *from, *to, 10);
  const auto result = backend->download(*to);
  EXPECT_EQ(result[3], glm::dvec3(0.0));
  const auto view = table.view();
  for (std::int32_t i = 0; i < 300; ++i) {
    glm::dvec3 sum(0.0);
    for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      sum += view.weights[k] * source[view.indices[k]];
    }
    EXPECT_EQ(result[10 + i], sum);
  }
}

TEST(CpuBackend, LimitNormalsAreUnitOrZeroWhereTangentsAreParallel) {
  StencilTable table;
  table.sizes = {3, 3};
  table.indices = {0, 1, 2, 0, 1, 2};
  table.weights = {1, 0, 0, 0, 0.5, 0.5};
  table.du_weights = {-1, 1, 0, -1, 1, 0};
  table.dv_weights = {-1, 0, 1, -2, 2, 0};
  table.close(3);
  const auto backend = make_cpu_backend();
  const auto source = backend->upload(std::vector<glm::dvec3>{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}});
  std::vector<glm::dvec3> positions(2);
  std::vector<glm::vec3> normals(2);
  backend->apply_limit(table.view(), *source, positions, normals);
  EXPECT_EQ(positions[1], glm::dvec3(1, 1.5, 0));
  EXPECT_EQ(normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(normals[1], glm::vec3(0, 0, 0));
}

}  // namespace
}  // namespace planish
