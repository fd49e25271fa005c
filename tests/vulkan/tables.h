#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <random>
#include <vector>

#include "planish/solve/stencil_table.h"

namespace planish::testing {

/// Limit masks of a torus of width x height quads: the tensor product of (1 6 1)/8.
inline StencilTable torus_masks(std::int32_t width, std::int32_t height) {
  constexpr double kCurve[3] = {1 / 8.0, 6 / 8.0, 1 / 8.0};
  StencilTable rows;
  for (std::int32_t y = 0; y < height; ++y)
    for (std::int32_t x = 0; x < width; ++x) {
      rows.sizes.push_back(9);
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
          rows.indices.push_back((y + j + height) % height * width + (x + i + width) % width);
          rows.weights.push_back(kCurve[i + 1] * kCurve[j + 1]);
        }
    }
  rows.close(width * height);
  return rows;
}

/// Rows of 0 to 12 entries anywhere among `source_count` points, weights in [-1, 1] that keep a
/// solve bounded, with derivative weights.
inline StencilTable random_rows(std::int32_t row_count, std::int32_t source_count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> weight(-1, 1);
  StencilTable rows;
  for (std::int32_t row = 0; row < row_count; ++row) {
    const auto size = static_cast<std::int32_t>(random() % 13);
    rows.sizes.push_back(size);
    for (std::int32_t k = 0; k < size; ++k) {
      rows.indices.push_back(static_cast<std::int32_t>(random() % source_count));
      rows.weights.push_back(weight(random) / 6);
      rows.du_weights.push_back(weight(random));
      rows.dv_weights.push_back(weight(random));
    }
  }
  rows.close(source_count);
  return rows;
}

inline StencilTable random_table(std::int32_t row_count, std::int32_t source_count) {
  StencilTable rows = random_rows(row_count, source_count);
  rows.du_weights.clear();
  rows.dv_weights.clear();
  return rows;
}

inline std::vector<glm::dvec3> random_points(std::int32_t count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-0.01, 0.01);
  std::vector<glm::dvec3> points(count);
  for (glm::dvec3& point : points)
    point = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

}  // namespace planish::testing
