#pragma once

#include <utility>

namespace planish {

/// A place of a square of this side as it is seen from the square's corner 0 to 3, counted
/// counter-clockwise, with the first axis along the side that leads on from it. Back again: by
/// (4 - corner) % 4. A vector: with side 0.
template <class Number>
[[nodiscard]] constexpr std::pair<Number, Number> seen_from(int corner, Number side, Number a,
                                                            Number b) {
  switch (corner) {
    case 0:
      return {a, b};
    case 1:
      return {b, side - a};
    case 2:
      return {side - a, side - b};
    default:
      return {side - b, a};
  }
}

}  // namespace planish
