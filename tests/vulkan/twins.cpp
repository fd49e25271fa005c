#include "vulkan/twins.h"

#include <algorithm>
#include <cmath>

namespace planish::testing::twin {

std::vector<glm::vec3> rounded(std::span<const glm::dvec3> points) {
  return {points.begin(), points.end()};
}

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

glm::vec3 limit_normal(const glm::vec3& du, const glm::vec3& dv) {
  const auto largest = [](const glm::vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  if (!(largest(du) > 0) || !(largest(dv) > 0)) return glm::vec3(0);
  const glm::vec3 a = du / largest(du), b = dv / largest(dv);
  const glm::vec3 c(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  const auto length = [](const glm::vec3& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  };
  return length(c) >= 1e-6f * length(a) * length(b) ? c / length(c) : glm::vec3(0);
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

}  // namespace planish::testing::twin
