#pragma once

#include <algorithm>

namespace planish::quality {

/// Of two surfaces neither is better where their normals differ by less, in parts and in degrees.
inline constexpr double kAlike = 1.1, kAlikeDegrees = 0.1;

[[nodiscard]] inline bool is_farther_off(double taken, double other) {
  return taken > kAlike * other && taken > other + kAlikeDegrees;
}

/// How often what was taken is as good as the better one, by degrees off the shape's normals.
struct Tally {
  int count = 0, right = 0;
  double excess = 1;  ///< the largest of the taken surface's deviation over the better one's

  void add(double taken, double better) {
    ++count;
    right += !is_farther_off(taken, better);
    // What is right to the last digit is no measure of how wrong another is.
    if (is_farther_off(taken, better))
      excess = std::max(excess, taken / std::max(better, kAlikeDegrees));
  }
};

}  // namespace planish::quality
