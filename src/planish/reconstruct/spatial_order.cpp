#include "planish/reconstruct/spatial_order.h"

#include <algorithm>
#include <utility>

#include "planish/reconstruct/bounding_cube.h"

namespace planish {
namespace {

constexpr int kBits = 21;  // of each axis: three fit into 64

// Puts two zeros before each of the lowest 21 bits.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffffu;
  bits = (bits | bits << 16) & 0x001f0000ff0000ffu;
  bits = (bits | bits << 8) & 0x100f00f00f00f00fu;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3u;
  return (bits | bits << 2) & 0x1249249249249249u;
}

}  // namespace

std::vector<std::int32_t> spatial_order(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  const auto [low, side] = bounding_cube(points);
  const double scale = side > 0 ? ((1 << kBits) - 1) / side : 0;
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 cell = scale * (points[i] - low);
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key |= spread(static_cast<std::uint64_t>(cell[axis])) << axis;
    keys[i] = {key, static_cast<std::int32_t>(i)};
  }
  std::ranges::sort(keys);
  std::vector<std::int32_t> order;
  order.reserve(points.size());
  for (const auto& [key, index] : keys) order.push_back(index);
  return order;
}

}  // namespace planish
