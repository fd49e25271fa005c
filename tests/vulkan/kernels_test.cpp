#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"
#include "vulkan/apply_table.h"
#include "vulkan/device_cases.h"
#include "vulkan/fixture.h"

namespace planish::testing::twin {
namespace {

/// The kernels again, on the CPU, in the same float arithmetic in the same order.

// The state that interpolation steps go through.
struct Interpolation {
  std::vector<glm::vec3> initial, previous, current;

  // Measures, then steps. Returns the largest |residual|^2 and the sum of them.
  struct Measure {
    float max_square;
    double square_sum;
  };
  Measure interpolation_step(const StencilView<double>& masks, const StepCoefficients& step);
};

std::vector<glm::vec3> rounded(std::span<const glm::dvec3> points) {
  return {points.begin(), points.end()};
}

// One row of a table applied to points.
glm::vec3 apply_row(const StencilView<double>& table, std::span<const double> weights,
                    std::span<const glm::vec3> source, std::int32_t row) {
  glm::vec3 sum(0);
  for (std::int32_t k = table.offsets[row]; k < table.offsets[row] + table.sizes[row]; ++k)
    sum += static_cast<float>(weights[k]) * source[table.indices[k]];
  return sum;
}

std::vector<glm::vec3> apply_stencils(const StencilView<double>& table,
                                      std::span<const glm::vec3> source) {
  std::vector<glm::vec3> target(table.row_count());
  for (std::int32_t row = 0; row < table.row_count(); ++row)
    target[row] = apply_row(table, table.weights, source, row);
  return target;
}

Interpolation::Measure Interpolation::interpolation_step(const StencilView<double>& masks,
                                                         const StepCoefficients& step) {
  const auto momentum = static_cast<float>(step.momentum);
  const auto gain = static_cast<float>(step.gain);
  std::vector<glm::vec3> next(current.size());
  Measure measure{0, 0};
  for (std::int32_t row = 0; row < masks.row_count(); ++row) {
    const glm::vec3 residual = initial[row] - apply_row(masks, masks.weights, current, row);
    next[row] = current[row] + (momentum * (current[row] - previous[row]) + gain * residual);
    const float square =
        residual.x * residual.x + residual.y * residual.y + residual.z * residual.z;
    measure.max_square = std::max(measure.max_square, square);
    measure.square_sum += square;
  }
  previous = std::move(current);
  current = std::move(next);
  return measure;
}

}  // namespace
}  // namespace planish::testing::twin

namespace planish::testing {
namespace {

// Every kernel against its CPU twin.

using RowsAndReads = std::tuple<std::int32_t, VulkanReads>;

class Kernels : public VulkanTest, public ::testing::WithParamInterface<RowsAndReads> {
 protected:
  std::int32_t rows() const { return std::get<0>(GetParam()); }
  VulkanBackendOptions options() const {
    VulkanBackendOptions result;
    result.reads = std::get<1>(GetParam());
    return result;
  }
};

std::string name_of_case(const ::testing::TestParamInfo<RowsAndReads>& info) {
  return std::to_string(std::get<0>(info.param)) +
         (std::get<1>(info.param) == VulkanReads::TexelBuffers ? "Texel" : "Storage");
}

INSTANTIATE_TEST_SUITE_P(Rows, Kernels,
                         ::testing::Combine(::testing::Values(0, 1, 63, 64, 65, 1000000),
                                            ::testing::Values(VulkanReads::StorageBuffers,
                                                              VulkanReads::TexelBuffers)),
                         name_of_case);

TEST_P(Kernels, InterpolationStepEqualsItsTwinBitForBit) {
  const std::int32_t rows = this->rows();
  const StencilTable masks = random_table(rows, rows);
  const std::vector<glm::dvec3> initial = random_points(rows);
  const std::vector<StepCoefficients> steps = {{0, 1}, {0.25, 0.75}, {0.5, 1.25}, {0.125, 0.3}};

  const auto solve = make_backend(options())->make_solve(masks.view());
  solve->begin(initial);
  const StepLog log = solve->run(steps, /*stop_error=*/-1);
  ASSERT_EQ(log.steps_taken, 4);
  ASSERT_EQ(log.errors.size(), 4u);

  twin::Interpolation twin{twin::rounded(initial), std::vector<glm::vec3>(rows, glm::vec3(0)),
                           std::vector<glm::vec3>(rows, glm::vec3(0))};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto measure = twin.interpolation_step(masks.view(), steps[i]);
    EXPECT_EQ(log.errors[i].max, std::sqrt(static_cast<double>(measure.max_square)));
    const double rms = rows > 0 ? std::sqrt(measure.square_sum / rows) : 0;
    EXPECT_NEAR(log.errors[i].rms, rms, 1e-6 * rms);
  }
  const std::vector<glm::dvec3> displacement = solve->displacement();
  ASSERT_EQ(std::ssize(displacement), rows);
  for (std::int32_t row = 0; row < rows; ++row)
    ASSERT_EQ(glm::vec3(displacement[row]), twin.current[row]) << row;
}

TEST_P(Kernels, ApplyStencilsEqualsItsTwinBitForBit) {
  const std::int32_t rows = this->rows();
  const std::int32_t sources = rows / 2 + 1;
  const std::int32_t first = 5;  // not a multiple of any alignment
  const StencilTable table = random_table(rows, sources);
  const std::vector<glm::dvec3> points = random_points(sources);

  const std::vector<glm::dvec3> result = applied(
      *make_machine(options()), table, points,
      std::vector<glm::dvec3>(static_cast<std::size_t>(rows + first + 3), glm::dvec3(9)), first);
  const std::vector<glm::vec3> expected = twin::apply_stencils(table.view(), twin::rounded(points));
  for (std::int32_t row = 0; row < rows; ++row)
    ASSERT_EQ(glm::vec3(result[row + first]), expected[row]) << row;
  for (std::int32_t i = 0; i < first; ++i) EXPECT_EQ(result[i], glm::dvec3(9));
  for (std::int32_t i = 0; i < 3; ++i) EXPECT_EQ(result[rows + first + i], glm::dvec3(9));
}

}  // namespace
}  // namespace planish::testing
