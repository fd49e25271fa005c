#include "planish/reconstruct/spatial_order.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <numeric>

#include "planish/core/parallel.h"
#include "planish/core/stop.h"
#include "planish/reconstruct/bounding_cube.h"

namespace planish {
namespace {

constexpr int kBits = 21;  // of each axis: three fit into 64
// Points of one cell that are looked at more finely.
constexpr std::ptrdiff_t kLongRun = 64;

struct KeyedPoint {
  std::uint64_t key;
  std::int32_t index;
  [[nodiscard]] bool operator<(const KeyedPoint& other) const {
    return key < other.key || (key == other.key && index < other.index);
  }
};

// Puts two zeros before each of the lowest 21 bits.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffffu;
  bits = (bits | bits << 16) & 0x001f0000ff0000ffu;
  bits = (bits | bits << 8) & 0x100f00f00f00f00fu;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3u;
  return (bits | bits << 2) & 0x1249249249249249u;
}

// Points at one place follow each other.
bool is_before(const glm::dvec3& a, const glm::dvec3& b, bool at_one_place) {
  for (int axis = 0; axis < 3; ++axis)
    if (a[axis] != b[axis]) return a[axis] < b[axis];
  return at_one_place;
}

// By the highest bits first, so that the host is looked after between short pieces.
void sort_by_key(std::span<KeyedPoint> keyed) {
  constexpr int kHighBits = 15, kLowBits = 3 * kBits - kHighBits;
  if (keyed.size() < std::size_t{1} << kHighBits) {
    std::sort(keyed.begin(), keyed.end());
    return;
  }
  std::vector<std::size_t> ends((std::size_t{1} << kHighBits) + 1, 0);
  for (const KeyedPoint& point : keyed) ++ends[(point.key >> kLowBits) + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  check_stop();
  std::vector<KeyedPoint> sorted(keyed.size());
  for (const KeyedPoint& point : keyed) sorted[ends[point.key >> kLowBits]++] = point;
  // Now each stands at the end of its piece.
  parallel_each(ends.size() - 1, 64, [&](std::size_t b) {
    const auto begin = sorted.begin() + static_cast<std::ptrdiff_t>(b == 0 ? 0 : ends[b - 1]);
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(ends[b]);
    std::sort(begin, end);
    std::copy(begin, end, keyed.begin() + (begin - sorted.begin()));
  });
}

// Within a cube of the points' own. A cloud with a point far away has nearly all of its points in
// one cell: these are sorted again within theirs.
void sort_along_curve(std::span<const glm::dvec3> points, std::span<KeyedPoint> keyed) {
  glm::dvec3 low = points[keyed.front().index], high = low;
  for (const KeyedPoint& point : keyed) {
    low = glm::min(low, points[point.index]);
    high = glm::max(high, points[point.index]);
  }
  const double side = largest_extent(low, high);
  const double scale = ((1 << kBits) - 1) / side;
  if (!(side > 0) || !(scale > 0 && scale <= std::numeric_limits<double>::max())) {
    std::ranges::sort(keyed, {}, &KeyedPoint::index);
    return;
  }
  parallel_each(keyed.size(), [&](std::size_t i) {
    const glm::dvec3 cell = scale * (points[keyed[i].index] - low);
    keyed[i].key = 0;
    for (int axis = 0; axis < 3; ++axis)
      keyed[i].key |= spread(static_cast<std::uint64_t>(cell[axis])) << axis;
  });
  sort_by_key(keyed);
  for (auto begin = keyed.begin(), end = begin; begin != keyed.end(); begin = end) {
    end =
        std::find_if(begin, keyed.end(), [&](const KeyedPoint& p) { return p.key != begin->key; });
    if (end - begin > kLongRun)
      sort_along_curve(points, {begin, end});
    else if (end - begin > 1)
      std::sort(begin, end, [&](const KeyedPoint& a, const KeyedPoint& b) {
        return is_before(points[a.index], points[b.index], a.index < b.index);
      });
  }
}

}  // namespace

std::vector<std::int32_t> spatial_order(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  std::vector<KeyedPoint> keyed(points.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) keyed[i].index = static_cast<std::int32_t>(i);
  sort_along_curve(points, keyed);
  std::vector<std::int32_t> order;
  order.reserve(points.size());
  for (const KeyedPoint& point : keyed) order.push_back(point.index);
  return order;
}

}  // namespace planish
