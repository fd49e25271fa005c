// The small kernels of the polish by themselves, with numbers that no net drives them to: sums that
// are infinite or none, diagonals of nothing.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

using vulkan::shared::FairParameters;
using vulkan::shared::FairScalars;

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

class FairScalarKernels : public FairReads {
 protected:
  // Runs one work group of `kernel` on both arrays, whose new contents they get; the other arrays
  // that it binds are not read.
  void run(vulkan::Kernel kernel, const FairParameters& parameters, std::vector<float>& floats,
           FairScalars& scalars) {
    vulkan::Context& context = machine_->context;
    const auto bytes_of = [](auto& items) { return std::as_bytes(std::span(items)); };
    vulkan::Buffer first = vulkan::make_bindable(context, 4 * floats.size(), "floats"),
                   second = vulkan::make_bindable(context, sizeof scalars, "scalars");
    std::vector<FairScalars> one{scalars};
    machine_->submitter.upload({first.handle(), 0, 4 * floats.size()}, bytes_of(floats));
    machine_->submitter.upload({second.handle(), 0, sizeof scalars}, bytes_of(one));
    const vulkan::Buffer other = vulkan::make_bindable(context, 64, "not read");
    const auto a = vulkan::whole(first), b = vulkan::whole(second), none = vulkan::whole(other);
    std::vector<vulkan::BoundKernel> bound{{kernel, {a, b}}};
    if (kernel == vulkan::Kernel::FairLines)
      bound[0].buffers = {none, none, none, none, b, none, a};
    if (kernel == vulkan::Kernel::FairDescend)
      bound[0].buffers = {none, none, none, none, none, b, none, a};
    const vulkan::DescriptorSets sets(context, bound);
    const vulkan::Pipeline pipeline = context.pipelines().specialised(kernel, {});
    machine_->submitter.run([&](VkCommandBuffer commands) {
      vulkan::record_dispatch(context, commands, pipeline, sets[0], &parameters, 1);
    });
    floats = download<float>(first, floats.size());
    scalars = download<FairScalars>(second, 1).front();
  }

  FairScalars total(vulkan::Kernel kernel, std::vector<float> partials, FairScalars scalars,
                    bool start = false) {
    // The last work group, which has no elements itself.
    scalars.parts = static_cast<std::uint32_t>(partials.size());
    partials.push_back(kNone);
    FairParameters parameters{};
    parameters.start = start ? 1 : 0;
    parameters.first_partial = scalars.parts;
    parameters.partial_count = scalars.parts + 1;
    run(kernel, parameters, partials, scalars);
    EXPECT_EQ(scalars.parts, 0u);
    return scalars;
  }
};

// Fewer than a work group has lanes, as many, and more.
std::vector<std::vector<float>> some_partials() {
  std::vector<std::vector<float>> all;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(0.5f, 2.0f);
  for (const std::size_t count : {1u, 63u, 64u, 65u, 1024u}) {
    std::vector<float>& partials = all.emplace_back(count);
    for (float& partial : partials) partial = any(random);
  }
  return all;
}

double sum_of(std::span<const float> partials) {
  double sum = 0;
  for (const float partial : partials) sum += double{partial};
  return sum;
}

// Others write no scalars, and leave the sum to the last one.
TEST_P(FairScalarKernels, WorkGroupsBeforeTheLastOneWaitForNothing) {
  for (const vulkan::Kernel kernel : {vulkan::Kernel::FairLines, vulkan::Kernel::FairDescend}) {
    std::vector<float> partials = {3, kNone, 5};
    FairScalars scalars{9, 8, 7, 6, 5, 1};
    FairParameters parameters{};
    parameters.first_partial = 1;
    parameters.partial_count = 3;
    run(kernel, parameters, partials, scalars);
    EXPECT_EQ(partials[1], 0.0f);
    EXPECT_EQ(scalars.parts, 2u);
    EXPECT_EQ(scalars.square, 9.0f);
    EXPECT_EQ(scalars.step, 7.0f);
    EXPECT_EQ(scalars.momentum, 6.0f);
  }
}

TEST_P(FairScalarKernels, MomentumIsTheChangeOfTheSquare) {
  for (const std::vector<float>& partials : some_partials()) {
    const double sum = sum_of(partials);
    const FairScalars begun =
        total(vulkan::Kernel::FairDescend, partials, {9, 9, 9, 9, 9, 0}, /*start=*/true);
    EXPECT_NEAR(begun.square, sum, 1e-6 * sum);
    EXPECT_NEAR(begun.enough, 1e-12 * sum, 1e-18 * sum);
    EXPECT_EQ(begun.step, 0.0f);
    EXPECT_EQ(begun.momentum, 0.0f);
    EXPECT_EQ(begun.largest_bits, 9u);
    const FairScalars next = total(vulkan::Kernel::FairDescend, partials, {3, 4, 5, 6, 7, 0});
    EXPECT_NEAR(next.square, sum, 1e-6 * sum);
    EXPECT_NEAR(next.momentum, sum / 3, 1e-6 * sum);
    EXPECT_EQ(next.enough, 4.0f);
    EXPECT_EQ(next.step, 5.0f);
    EXPECT_EQ(next.largest_bits, 7u);
  }
}

TEST_P(FairScalarKernels, MomentumOfWhatIsNoNumberIsNone) {
  const auto momentum = [&](float square, float before) {
    return total(vulkan::Kernel::FairDescend, {1, square, 1}, {before, 0, 0, 9, 0, 0}).momentum;
  };
  EXPECT_EQ(momentum(kInfinite, 1), 0.0f);
  EXPECT_EQ(momentum(kInfinite, kInfinite), 0.0f);
  EXPECT_EQ(momentum(kNone, 1), 0.0f);
  EXPECT_EQ(momentum(1, kNone), 0.0f);
  EXPECT_EQ(momentum(1, kInfinite), 0.0f);
  EXPECT_EQ(momentum(1, 0), 0.0f);
  EXPECT_EQ(momentum(3e38f, 1e-10f), 0.0f);  // the quotient alone is too large
  EXPECT_EQ(momentum(1, 6), 0.5f);
}

TEST_P(FairScalarKernels, StepIsTheSquareByTheCurvature) {
  for (const std::vector<float>& partials : some_partials()) {
    const FairScalars made = total(vulkan::Kernel::FairLines, partials, {3, 1, 9, 6, 7, 0});
    const double step = 3 / sum_of(partials);
    EXPECT_NEAR(made.step, step, 1e-6 * step);
    EXPECT_EQ(made.square, 3.0f);
    EXPECT_EQ(made.momentum, 6.0f);
    const FairScalars begun =
        total(vulkan::Kernel::FairLines, partials, {3, 1, 9, 6, 7, 0}, /*start=*/true);
    EXPECT_EQ(begun.step, 1.0f);
  }
}

TEST_P(FairScalarKernels, NoStepWhereConvergedOrNoNumber) {
  const auto step = [&](float curvature, float square, float enough) {
    return total(vulkan::Kernel::FairLines, {curvature}, {square, enough, 9, 0, 0, 0}).step;
  };
  EXPECT_EQ(step(2, 1, 0), 0.5f);
  EXPECT_EQ(step(2, 1, 1), 0.0f);
  EXPECT_EQ(step(0, 1, 0), 0.0f);
  EXPECT_EQ(step(-2, 1, 0), 0.0f);
  EXPECT_EQ(step(kNone, 1, 0), 0.0f);
  EXPECT_EQ(step(kInfinite, 1, 0), 0.0f);
  EXPECT_EQ(step(kInfinite, kInfinite, 0), 0.0f);
  EXPECT_EQ(step(2, kNone, 0), 0.0f);
  EXPECT_EQ(step(2, kInfinite, 0), 0.0f);
  EXPECT_EQ(step(1e-10f, 3e38f, 0), 0.0f);
}

// Floored at 1e-14 of the largest, on more elements than lanes.
TEST_P(FairScalarKernels, PreconditionIsOneOverTheDiagonal) {
  constexpr float kLargest = 4e6f;
  std::vector<float> diagonals{0, -1, kLargest, 1, 4e-8f, 3e-8f, 1e-20f, kNone, kInfinite};
  while (diagonals.size() < 200) diagonals.push_back(0.37f * float(diagonals.size()));
  const std::vector<float> given = diagonals;
  FairParameters parameters{};
  parameters.count = 199;
  FairScalars scalars{1, 2, 3, 4, std::bit_cast<std::uint32_t>(kLargest), 0};
  run(vulkan::Kernel::FairPrecondition, parameters, diagonals, scalars);
  for (std::size_t i = 0; i < 199; ++i) {
    const double floored = std::max(double{given[i]}, 1e-14 * double{kLargest});
    const double expected = given[i] > 0 ? 1 / floored : 0;  // of NaN, too
    EXPECT_NEAR(diagonals[i], expected, 1e-6 * expected) << i << ": " << given[i];
  }
  EXPECT_EQ(diagonals[199], given[199]);  // beyond the count
  EXPECT_EQ(scalars.square, 1.0f);
}

INSTANTIATE_TEST_SUITE_P(Reads, FairScalarKernels, both_reads(), name_of_reads);

}  // namespace
}  // namespace planish::testing
