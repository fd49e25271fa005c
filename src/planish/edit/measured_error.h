#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>

#include "planish/backend/backend.h"
#include "planish/core/parallel.h"

namespace planish {

/// How far a surface is from the points that it passes through, and from which of them the most.
struct MeasuredError {
  ErrorNorms norms;
  std::int64_t worst = -1;
};

/// Of `residual(i)` for i below `count`, summed in a fixed order.
template <class Residual>
[[nodiscard]] MeasuredError measure_error(std::size_t count, const Residual& residual) {
  constexpr std::size_t kGrain = 4096;
  struct Sum {
    double largest = -1, squares = 0;
    std::int64_t worst = -1;
  };
  const Sum all = ordered_reduce(
      count, kGrain, Sum{},
      [&](std::size_t begin, std::size_t end) {
        Sum sum;
        for (std::size_t i = begin; i < end; ++i) {
          const auto r = residual(i);
          const double square = glm::dot(r, r);
          sum.squares += square;
          if (!(square > sum.largest)) continue;
          sum.largest = square;
          sum.worst = static_cast<std::int64_t>(i);
        }
        return sum;
      },
      [](Sum& total, const Sum& piece) {
        total.squares += piece.squares;
        if (!(piece.largest > total.largest)) return;
        total.largest = piece.largest;
        total.worst = piece.worst;
      });
  MeasuredError result;
  if (count == 0) return result;
  result.norms = {std::sqrt(std::max(all.largest, 0.0)),
                  std::sqrt(all.squares / static_cast<double>(count))};
  result.worst = all.worst;
  return result;
}

}  // namespace planish
