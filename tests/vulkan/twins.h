#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"

/// The kernels again, on the CPU, in the same float arithmetic in the same order.
namespace planish::testing::twin {

[[nodiscard]] std::vector<glm::vec3> rounded(std::span<const glm::dvec3> points);

/// One row of a table applied to points.
[[nodiscard]] glm::vec3 apply_row(const StencilView<double>& table, std::span<const double> weights,
                                  std::span<const glm::vec3> source, std::int32_t row);

[[nodiscard]] std::vector<glm::vec3> apply_stencils(const StencilView<double>& table,
                                                    std::span<const glm::vec3> source);

/// Normal du x dv / |du x dv|, zero where it has no direction.
[[nodiscard]] glm::vec3 limit_normal(const glm::vec3& du, const glm::vec3& dv);

/// The state that interpolation steps go through.
struct Interpolation {
  std::vector<glm::vec3> initial, previous, current;

  /// Measures, then steps. Returns the largest |residual|^2 and the sum of them.
  struct Measure {
    float max_square;
    double square_sum;
  };
  Measure interpolation_step(const StencilView<double>& masks, const StepCoefficients& step);
};

}  // namespace planish::testing::twin
