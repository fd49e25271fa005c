#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

#include "planish/limit/bezier_net.h"

namespace planish {

/// The square of a point's distance from a piece, a polynomial of degree 4 along u and along v, by
/// its Bernstein coefficients: they bound it and its derivatives over the piece's whole square.
class DistanceNet {
 public:
  DistanceNet(const BezierNet& net, const glm::dvec3& point);

  /// No place's is less, but for rounding.
  [[nodiscard]] double least() const { return *std::ranges::min_element(values_); }
  [[nodiscard]] double largest() const { return *std::ranges::max_element(values_); }
  /// Where along u and v, of 0 to 1, the least coefficient stands.
  [[nodiscard]] std::array<double, 2> place_of_least() const;
  /// The least at the square's corners, which are places.
  [[nodiscard]] double least_at_corners() const;

  /// 1 where it surely rises along a direction all over the square, -1 where it falls; else 0.
  [[nodiscard]] int slope(bool along_v) const;
  /// Whether it surely is convex, along one direction or over the square.
  [[nodiscard]] bool is_convex_along(bool along_v) const;
  [[nodiscard]] bool is_convex() const;
  /// Whether it bends more along v than along u.
  [[nodiscard]] bool bends_more_along_v() const;

  /// That of one half of the square.
  [[nodiscard]] DistanceNet half(bool along_v, bool upper) const;
  /// Of the border at 0 or, `upper`, at 1: constant along the direction.
  [[nodiscard]] DistanceNet border(bool along_v, bool upper) const;

 private:
  static constexpr std::size_t kSide = 5;
  // The least and the largest in magnitude of the second differences along a direction.
  struct Bend {
    double least, most;
  };
  [[nodiscard]] Bend bend(bool along_v) const;
  [[nodiscard]] double rounding() const;

  std::array<double, kSide * kSide> values_{};  // (i, j) at i + 5 j
};

}  // namespace planish
