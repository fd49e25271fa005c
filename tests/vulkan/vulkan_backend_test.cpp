// The backend as a whole: stopping, slicing, NaN, errors, and the CPU backend as its oracle.
#include "planish/vulkan/vulkan_backend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planish/doosabin/limit_masks.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "vulkan/fixture.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

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
  const StencilTable limit = random_rows(rows, rows);
  const std::vector<glm::dvec3> points = random_points(rows);
  const std::vector<StepCoefficients> steps(5, {0.2, 0.8});
  const std::vector<double> weights(rows, 4);

  VulkanBackendOptions by_range, by_groups;
  by_range.max_storage_bytes = rows * 16;  // a fraction of what the masks' entries need
  by_groups.max_work_groups = 16;
  std::vector<std::vector<glm::dvec3>> displacements, images, limits, gradients;
  std::vector<double> errors;
  by_groups.reads = VulkanReads::StorageBuffers;
  for (const VulkanBackendOptions& options : {VulkanBackendOptions{}, by_range, by_groups}) {
    const auto backend = make_backend(options);
    const auto solve = backend->make_solve(masks.view());
    solve->begin(points);
    errors.push_back(solve->run(steps, -1).errors.back().max);
    displacements.push_back(solve->displacement());

    solve->cg_begin(points, weights);
    solve->cg_apply();
    solve->cg_advance({0.5, 0.5, 0.5});
    solve->cg_turn({0.25, 0.25, 0.25});
    solve->cg_apply();
    solve->cg_advance({0.5, 0.5, 0.5});
    gradients.push_back(solve->displacement());

    const auto source = backend->upload(points);
    const auto target = backend->allocate(rows + 7);
    backend->apply(masks.view(), *source, *target, 7);
    images.push_back(backend->download(*target));
    images.back().erase(images.back().begin(), images.back().begin() + 7);

    std::vector<glm::dvec3> positions(rows);
    std::vector<glm::vec3> normals(rows);
    backend->apply_limit(limit.view(), *source, positions, normals);
    positions.insert(positions.end(), normals.begin(), normals.end());
    limits.push_back(positions);
  }
  for (int i : {1, 2}) {
    EXPECT_EQ(errors[i], errors[0]);
    EXPECT_EQ(displacements[i], displacements[0]);
    EXPECT_EQ(gradients[i], gradients[0]);
    EXPECT_EQ(images[i], images[0]);
    EXPECT_EQ(limits[i], limits[0]);
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
  const auto backend = make_backend();
  try {
    // 32 GiB; lavapipe itself would hand it out.
    static_cast<void>(backend->allocate(std::numeric_limits<std::int32_t>::max()));
    GTEST_SKIP() << "the device has that much";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("bytes, but"));
  }
}

TEST_F(VulkanBackend, CountsTheHighestMemoryTaken) {
  const auto backend = make_backend();
  const std::uint64_t before = backend->peak_device_bytes();
  { const auto points = backend->allocate(1 << 20); }
  const std::uint64_t after = backend->peak_device_bytes();
  EXPECT_GE(after, before + (16u << 20));
  { const auto points = backend->allocate(1 << 10); }
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
  const auto backend = make_backend();
  const auto source = backend->upload(points);
  const auto target = backend->allocate(count);
  backend->apply(table.view(), *source, *target, 0);
  const std::vector<glm::dvec3> result = backend->download(*target);
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
