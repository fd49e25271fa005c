#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planish/core/error.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/solve/backend.h"
#include "planish/solve/progressive.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/vulkan_backend.h"
#include "shaders/shared.h"
#include "support/meshes.h"
#include "vulkan/apply_table.h"
#include "vulkan/device_cases.h"
#include "vulkan/fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

SliceLimits no_limits() {
  SliceLimits limits;
  limits.range.bytes = limits.max_chunks = std::numeric_limits<std::uint64_t>::max();
  return limits;
}

// Reads the packed slices back as the kernels do; expects every row once, with its own entries.
void expect_same_table(const StencilView<double>& table, const TablePlan& plan) {
  std::vector<int> seen(table.row_count(), 0);
  for (const TableSlice& slice : plan.slices) {
    const PackedSlice packed = pack_slice(table, plan, slice);
    for (std::size_t chunk = 0; chunk < slice.chunk_count; ++chunk) {
      const std::uint32_t* head = &packed.chunks[chunk * shared::kChunkWords];
      for (std::uint32_t lane = 0; lane < shared::kChunkRows; ++lane) {
        const std::uint32_t row = head[2 + lane];
        if (row == shared::kNoRow) continue;
        ++seen[row];
        EXPECT_GE(static_cast<std::int32_t>(row), slice.first_row);
        EXPECT_LT(static_cast<std::int32_t>(row), slice.first_row + slice.row_count);
        for (std::uint32_t k = 0; k < head[1]; ++k) {
          const PackedEntry& entry = packed.entries[(head[0] + k) * shared::kChunkRows + lane];
          if (static_cast<std::int32_t>(k) >= table.sizes[row]) {
            EXPECT_EQ(entry.weight, 0);
            continue;
          }
          const std::size_t at = table.offsets[row] + k;
          EXPECT_EQ(static_cast<std::int32_t>(entry.source) + slice.first_source,
                    table.indices[at]);
          EXPECT_EQ(entry.weight, static_cast<float>(table.weights[at]));
        }
      }
    }
  }
  EXPECT_THAT(seen, ::testing::Each(1));
}

TEST(TableSlices, HoldEveryRowOnce) {
  for (const std::int32_t rows : {1, 63, 64, 65, 1023, 1024, 1025, 5000}) {
    const StencilTable table = random_table(rows, rows);
    const TablePlan plan = plan_table(table.view(), no_limits());
    EXPECT_EQ(plan.slices.size(), 1u);
    expect_same_table(table.view(), plan);
  }
}

TEST(TableSlices, AreNoneForAnEmptyTable) {
  EXPECT_TRUE(plan_table(random_table(0, 7).view(), no_limits()).slices.empty());
}

TEST(TableSlices, EndWhereALimitIsReached) {
  // Rows that read near themselves, so that windows of sources are short.
  StencilTable table;
  const std::int32_t count = 10000;
  for (std::int32_t row = 0; row < count; ++row) {
    table.sizes.push_back(4);
    for (std::int32_t k = 0; k < 4; ++k) {
      table.indices.push_back(std::min(row + 100 * k, count - 1));
      table.weights.push_back(0.25);
    }
  }
  table.close(count);
  SliceLimits by_range = no_limits(), by_chunks = no_limits();
  by_range.range.bytes = 2 * 1024 * 4 * sizeof(PackedEntry);
  by_chunks.max_chunks = 40;  // two windows of 16 chunks
  for (const SliceLimits& limits : {by_range, by_chunks}) {
    const TablePlan plan = plan_table(table.view(), limits);
    EXPECT_EQ(plan.slices.size(), 5u);
    expect_same_table(table.view(), plan);
    for (const TableSlice& slice : plan.slices) {
      EXPECT_LE(slice.row_count, 2048);
      EXPECT_LE(slice.source_count, 2048 + 300 + 64);
      EXPECT_EQ(slice.first_source % 64, 0);
    }
  }
}

TEST(TableSlices, ShrinkToSingleChunksWhereLimitsAreLow) {
  const StencilTable table = random_table(200, 100);
  SliceLimits limits = no_limits();
  limits.range.bytes = 12 * 64 * sizeof(PackedEntry);  // the longest rows, 64 of them
  const TablePlan plan = plan_table(table.view(), limits);
  EXPECT_EQ(plan.slices.size(), 4u);
  expect_same_table(table.view(), plan);
}

TEST(TableSlices, RefuseByTheNameOfTheLimit) {
  const StencilTable table = random_table(5000, 5000);
  SliceLimits by_range = no_limits(), by_chunks = no_limits();
  by_range.range.bytes = 5000;
  by_chunks.max_chunks = 0;
  const std::pair<SliceLimits, const char*> cases[] = {
      {by_range, "maxStorageBufferRange is 5000"},
      {by_chunks, "maxComputeWorkGroupCount allows 0"}};
  for (const auto& [limits, words] : cases) try {
      static_cast<void>(plan_table(table.view(), limits));
      FAIL() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
      EXPECT_EQ(error.element(), 0);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
    }
}

// The backend as a whole: stopping, slicing, NaN, errors, and the CPU backend as its oracle.

class VulkanBackend : public VulkanTest {};

double largest_difference(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
  double largest = a.size() == b.size() ? 0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[i][c] - b[i][c]));
  return largest;
}

TEST_F(VulkanBackend, AgreesWithTheCpuBackendInDouble) {
  const StencilTable masks = torus_masks(50, 40);
  const std::vector<glm::dvec3> initial = random_points(2000);
  // More steps than one submission holds.
  const std::vector<StepCoefficients> steps(100, {0.3, 1.2});

  const auto vulkan = make_backend()->make_solve(masks.view());
  const auto cpu_backend = make_cpu_backend();
  const auto cpu = cpu_backend->make_solve(masks.view());
  vulkan->begin(initial);
  cpu->begin(initial);
  const StepLog log = vulkan->run(steps, -1);
  const StepLog expected = cpu->run(steps, -1);

  EXPECT_EQ(log.steps_taken, 100);
  ASSERT_EQ(log.errors.size(), expected.errors.size());
  for (std::size_t i = 0; i < log.errors.size(); ++i) {
    EXPECT_NEAR(log.errors[i].max, expected.errors[i].max, 1e-8) << i;
    EXPECT_NEAR(log.errors[i].rms, expected.errors[i].rms, 1e-8) << i;
  }
  EXPECT_LT(largest_difference(vulkan->displacement(), cpu->displacement()), 1e-6);
  EXPECT_NEAR(vulkan->error().max, cpu->error().max, 1e-8);
}

// The device takes their rows whole; where that is far more than the sums, the host solves, and the
// bits are its own.
TEST_F(VulkanBackend, TakesTheSumsOfLargeFaces) {
  for (const auto& [corners, most] : {std::pair(50, 1e-6), {3000, 0.0}}) {
    const PolygonMesh mesh = test::prism(corners);
    const MeshTopology topology(mesh);
    const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
    const SummedTable masks =
        summed_limit_masks(Subdivision(topology, features, Weights::DooSabin));
    ASSERT_GT(masks.view().sum_count(), 0);
    const std::vector<glm::dvec3> initial = random_points(2 * corners);
    const std::vector<StepCoefficients> steps(10, {0.3, 1.2});
    const auto vulkan = make_backend()->make_solve(masks.view());
    const auto cpu_backend = make_cpu_backend();
    const auto cpu = cpu_backend->make_solve(masks.view());
    vulkan->begin(initial);
    cpu->begin(initial);
    (void)vulkan->run(steps, -1);
    (void)cpu->run(steps, -1);
    EXPECT_LE(largest_difference(vulkan->displacement(), cpu->displacement()), most);
  }
}

TEST_F(VulkanBackend, LeavesConjugateGradientsAndPrimalSurfacesToTheHost) {
  const PolygonMesh mesh = test::icosphere(2);
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  const StencilTable masks = limit_masks(Subdivision(topology, features, Weights::DooSabin));
  const std::vector<double> weights = valences(topology);
  InterpolationOptions options;
  options.solver = Solver::ConjugateGradients;
  options.tolerance = 1e-12;  // beyond float
  options.row_weights = weights;
  const auto vulkan = make_backend(), cpu = make_cpu_backend();
  const Interpolation there = interpolate(*vulkan, masks.view(), mesh.positions, options),
                      here = interpolate(*cpu, masks.view(), mesh.positions, options);
  EXPECT_TRUE(there.converged);
  EXPECT_EQ(there.displacement, here.displacement);
  for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Loop}) {
    EvaluateOptions level;
    level.level = 2;
    level.scheme = scheme;
    const SurfaceMesh by_vulkan = evaluate(mesh, *vulkan, level),
                      by_cpu = evaluate(mesh, *cpu, level);
    EXPECT_EQ(by_vulkan.positions, by_cpu.positions);
    EXPECT_EQ(by_vulkan.normals, by_cpu.normals);
  }
}

TEST_F(VulkanBackend, StopsAtTheFirstErrorThatIsSmallEnough) {
  const StencilTable masks = torus_masks(20, 20);
  const std::vector<glm::dvec3> initial = random_points(400);
  const std::vector<StepCoefficients> steps(90, {0.2, 1.1});
  const auto backend = make_backend();
  const auto free_run = backend->make_solve(masks.view());
  free_run->begin(initial);
  const StepLog all = free_run->run(steps, -1);

  const auto solve = backend->make_solve(masks.view());
  for (const std::int32_t stop : {0, 1, 2, 3, 7}) {
    solve->begin(initial);
    const StepLog log = solve->run(steps, all.errors[stop].max);
    EXPECT_EQ(log.steps_taken, stop);
    ASSERT_EQ(std::ssize(log.errors), stop + 1);
    for (std::int32_t i = 0; i <= stop; ++i) EXPECT_EQ(log.errors[i].max, all.errors[i].max);
    // What is left is what that many steps alone make; and going on takes up where it stopped.
    EXPECT_EQ(solve->error().max, all.errors[stop].max);
    const StepLog rest = solve->run(std::span(steps).first(3), -1);
    for (std::int32_t i = 0; i < 3; ++i) EXPECT_EQ(rest.errors[i].max, all.errors[stop + i].max);
  }
}

TEST_F(VulkanBackend, NanCountsAsInfinite) {
  const StencilTable masks = torus_masks(10, 10);
  std::vector<glm::dvec3> initial = random_points(100);
  initial[37].y = std::numeric_limits<double>::quiet_NaN();
  const auto solve = make_backend()->make_solve(masks.view());
  solve->begin(initial);
  const std::vector<StepCoefficients> steps(3, {0, 1});
  const StepLog log = solve->run(steps, 1e-3);
  EXPECT_EQ(log.steps_taken, 3);
  ASSERT_EQ(log.errors.size(), 3u);
  for (const ErrorNorms& error : log.errors) {
    EXPECT_EQ(error.max, std::numeric_limits<double>::infinity());
    EXPECT_EQ(error.rms, std::numeric_limits<double>::infinity());
  }
}

TEST_F(VulkanBackend, SlicesChangeNothing) {
  const std::int32_t rows = 20000;
  const StencilTable masks = random_table(rows, rows);
  const std::vector<glm::dvec3> points = random_points(rows);
  const std::vector<StepCoefficients> steps(5, {0.2, 0.8});

  VulkanBackendOptions by_range, by_groups;
  by_range.max_storage_bytes = rows * 16;  // a fraction of what the masks' entries need
  by_groups.max_work_groups = 16;
  std::vector<std::vector<glm::dvec3>> displacements, images;
  std::vector<double> errors;
  by_groups.reads = VulkanReads::StorageBuffers;
  for (const VulkanBackendOptions& options : {VulkanBackendOptions{}, by_range, by_groups}) {
    const auto machine = make_machine(options);
    const auto backend = vulkan::make_backend(machine);
    const auto solve = backend->make_solve(masks.view());
    solve->begin(points);
    errors.push_back(solve->run(steps, -1).errors.back().max);
    displacements.push_back(solve->displacement());

    images.push_back(applied(*machine, masks, points, std::vector<glm::dvec3>(rows + 7), 7));
  }
  for (int i : {1, 2}) {
    EXPECT_EQ(errors[i], errors[0]);
    EXPECT_EQ(displacements[i], displacements[0]);
    EXPECT_EQ(images[i], images[0]);
  }
}

TEST_F(VulkanBackend, RefusesWhatNoSliceCanMeet) {
  const StencilTable masks = torus_masks(100, 100);
  VulkanBackendOptions options;
  options.max_storage_bytes = 1 << 14;
  const auto backend = make_backend(options);
  try {
    static_cast<void>(backend->make_solve(masks.view()));
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("maxStorageBufferRange is 16384"));
  }
}

TEST_F(VulkanBackend, RefusesMemoryBeforeItIsTaken) {
  const auto machine = make_machine();
  try {
    // Lavapipe itself would hand it out.
    const vulkan::Buffer buffer(machine->context, std::uint64_t(32) << 30,
                                vulkan::MemoryUse::Device);
    GTEST_SKIP() << "the device has that much";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("bytes, but"));
  }
}

TEST_F(VulkanBackend, CountsTheHighestMemoryTaken) {
  const auto machine = make_machine();
  const auto backend = vulkan::make_backend(machine);
  const std::uint64_t before = backend->peak_device_bytes();
  { const vulkan::Buffer buffer(machine->context, 16u << 20, vulkan::MemoryUse::Device); }
  const std::uint64_t after = backend->peak_device_bytes();
  EXPECT_GE(after, before + (16u << 20));
  { const vulkan::Buffer buffer(machine->context, 16u << 10, vulkan::MemoryUse::Device); }
  EXPECT_EQ(backend->peak_device_bytes(), after);
}

TEST_F(VulkanBackend, LongRowsAmongShortOnes) {
  StencilTable table;
  const std::int32_t count = 3000;
  for (std::int32_t row = 0; row < count; ++row) {
    const std::int32_t size = row % 700 == 5 ? 2000 : row % 4;
    table.sizes.push_back(size);
    for (std::int32_t k = 0; k < size; ++k) {
      table.indices.push_back((row + k) % count);
      table.weights.push_back(1.0 / 4096);
    }
  }
  table.close(count);
  std::vector<glm::dvec3> points(count);
  for (std::int32_t i = 0; i < count; ++i) points[i] = {i % 16, 1, i % 3};
  const std::vector<glm::dvec3> result =
      applied(*make_machine(), table, points, std::vector<glm::dvec3>(count));
  // Small integers over a power of two: exact in any order.
  const auto view = table.view();
  for (std::int32_t row = 0; row < count; ++row) {
    glm::dvec3 sum(0);
    for (std::int32_t k = 0; k < view.sizes[row]; ++k) sum += points[(row + k) % count] / 4096.0;
    ASSERT_EQ(result[row], sum) << row;
  }
}

}  // namespace
}  // namespace planish::testing
