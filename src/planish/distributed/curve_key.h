#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

namespace planish {

/// Bits of a coordinate in a curve key; three coordinates fill 63.
inline constexpr int kCurveBits = 21;

/// The cell of a position in a grid of 2^21 cells a side over the cube from `low` of that side
/// length, the largest extent of the box of all vertices; the last cell also holds its far side.
[[nodiscard]] inline std::array<std::uint32_t, 3> curve_cell(const glm::dvec3& position,
                                                             const glm::dvec3& low, double side) {
  constexpr double kCells = 1 << kCurveBits;
  std::array<std::uint32_t, 3> cell{};
  for (int c = 0; c < 3; ++c) {
    const double at = side > 0 ? (position[c] - low[c]) / side * kCells : 0.0;
    // The comparison is false for what is not finite.
    cell[c] = at > 0 ? static_cast<std::uint32_t>(std::min(at, kCells - 1)) : 0;
  }
  return cell;
}

/// A cell's place on the Hilbert curve, 63 bits.
/// Source: J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004.
[[nodiscard]] inline std::uint64_t curve_key(std::array<std::uint32_t, 3> cell) {
  constexpr std::uint32_t kTop = 1u << (kCurveBits - 1);
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1) {
    const std::uint32_t lower = bit - 1;
    for (std::uint32_t& coordinate : cell) {
      if (coordinate & bit) {
        cell[0] ^= lower;
      } else {
        const std::uint32_t swapped = (cell[0] ^ coordinate) & lower;
        cell[0] ^= swapped;
        coordinate ^= swapped;
      }
    }
  }
  cell[1] ^= cell[0];
  cell[2] ^= cell[1];
  std::uint32_t turned = 0;
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1)
    if (cell[2] & bit) turned ^= bit - 1;
  for (std::uint32_t& coordinate : cell) coordinate ^= turned;
  std::uint64_t key = 0;
  for (int bit = kCurveBits - 1; bit >= 0; --bit)
    for (const std::uint32_t coordinate : cell) key = key << 1 | ((coordinate >> bit) & 1);
  return key;
}

}  // namespace planish
