#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace planish {

/// The corners of a polygon that turn inward, to ask which of them lies in a triangle. A tree over
/// their places, halved at the median: a question takes time of the order of the root of their
/// number at most where it is answered by none, mostly of its logarithm.
class ReflexCorners {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// `places`: of all corners of the polygon; must outlive it. `corners`: numbers of some of them.
  ReflexCorners(std::span<const glm::dvec2> places, std::vector<std::uint32_t> corners);

  /// Nothing where it is none of them, or no longer.
  void erase(std::uint32_t corner);

  /// One that lies in the triangle or on its sides, whose corners turn left; kNone: there is none.
  /// Those at its corners do not count: they are the seam of a polygon that touches itself.
  [[nodiscard]] std::uint32_t inside(const std::array<glm::dvec2, 3>& triangle) const;

 private:
  struct Node {
    glm::dvec2 low, high;
    std::uint32_t begin, end, left;  // of corners_; `left`: how many are still there
  };
  void split(std::size_t node, std::uint32_t begin, std::uint32_t end);
  // `asked` counts nodes and corners.
  [[nodiscard]] std::uint32_t inside(std::size_t node, const std::array<glm::dvec2, 3>& triangle,
                                     std::int64_t& asked) const;

  std::span<const glm::dvec2> places_;
  std::vector<std::uint32_t> corners_;
  std::vector<Node> nodes_;             // the halves of node i are 2 i + 1 and 2 i + 2
  std::vector<std::uint32_t> leaf_of_;  // by corner of the polygon; kNone: not among them
};

}  // namespace planish
