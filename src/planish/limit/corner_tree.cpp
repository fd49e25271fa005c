#include "planish/limit/corner_tree.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "planish/core/parallel.h"
#include "planish/core/stop.h"
#include "planish/limit/patch_box.h"

namespace planish {
namespace {

constexpr std::int32_t kLeaf = 2;
constexpr std::size_t kBoxGrain = 512;
constexpr std::int32_t kSerial = 4096;  // corners below which a subtree is made by one thread

// Nodes of a subtree over so many corners.
std::int32_t node_count(std::int32_t corners) {
  if (corners <= kLeaf) return 1;
  return 1 + node_count(corners / 2) + node_count(corners - corners / 2);
}

float below(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity())
                         : rounded;
}

float above(double value) { return -below(-value); }

CornerBox outward(const PatchBox& box, const glm::dvec3& origin) {
  // Sums of weights are 1 to rounding, which this is far above.
  constexpr double kRounding = 1e-14;
  CornerBox result;
  for (int d = 0; d < 3; ++d) {
    result.low[d] = below(origin[d] + box.low[d] - kRounding);
    result.high[d] = above(origin[d] + box.high[d] + kRounding);
  }
  return result;
}

CornerBox united(const CornerBox& a, const CornerBox& b) {
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

}  // namespace

CornerTree::CornerTree(const LimitSurface& surface) : surface_(surface) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::uint8_t> hidden = surface.surface().hidden();
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    if (hidden.empty() || hidden[static_cast<std::size_t>(topology.face_of(c))] == 0)
      corners_.push_back(c);
  }
  if (corners_.empty()) return;
  for (const PatchForm* form : surface.forms()) reaches_.add(*form);
  RawVector<CornerBox> box_of(static_cast<std::size_t>(topology.corner_count()));
  parallel_for(corners_.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
    LimitSurface::Corner corner(surface);
    for (std::size_t i = begin; i < end; ++i) {
      corner.move_to(corners_[i]);
      box_of[static_cast<std::size_t>(corners_[i])] =
          outward(patch_box(corner.form(), corner.points(), reaches_), corner.own());
    }
  });
  const auto count = static_cast<std::int32_t>(corners_.size());
  nodes_.resize(static_cast<std::size_t>(node_count(count)));
  boxes_.swap(box_of);  // by corner while the tree is made
  build(0, 0, count);
  RawVector<CornerBox> in_order(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i)
    in_order[i] = boxes_[static_cast<std::size_t>(corners_[i])];
  boxes_.swap(in_order);
}

void CornerTree::build(std::int32_t index, std::int32_t first, std::int32_t last) {
  check_stop();
  Node& node = nodes_[static_cast<std::size_t>(index)];
  node = {};
  const auto box = [&](std::int32_t i) -> const CornerBox& {
    return boxes_[static_cast<std::size_t>(corners_[static_cast<std::size_t>(i)])];
  };
  if (last - first <= kLeaf) {
    node.box = box(first);
    for (std::int32_t i = first + 1; i < last; ++i) node.box = united(node.box, box(i));
    node.first = first;
    node.count = last - first;
    return;
  }
  // Middles' extent decides the direction, their median the place: two halves of known size.
  glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
  for (std::int32_t i = first; i < last; ++i) {
    const glm::vec3 middle = box(i).low + box(i).high;
    low = glm::min(low, middle);
    high = glm::max(high, middle);
  }
  const glm::vec3 size = high - low;
  const int along = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::int32_t middle = first + (last - first) / 2;
  std::nth_element(corners_.begin() + first, corners_.begin() + middle, corners_.begin() + last,
                   [&](std::int32_t a, std::int32_t b) {
                     const CornerBox& p = boxes_[static_cast<std::size_t>(a)];
                     const CornerBox& q = boxes_[static_cast<std::size_t>(b)];
                     const float pa = p.low[along] + p.high[along];
                     const float qa = q.low[along] + q.high[along];
                     return pa != qa ? pa < qa : a < b;
                   });
  const std::int32_t left = index + 1, right = left + node_count(middle - first);
  if (last - first > kSerial) {
    const StopScope* const stop = AdoptedStop::current();
    oneapi::tbb::parallel_invoke(
        [&] {
          const AdoptedStop adopted(stop);
          build(left, first, middle);
        },
        [&] {
          const AdoptedStop adopted(stop);
          build(right, middle, last);
        });
  } else {
    build(left, first, middle);
    build(right, middle, last);
  }
  node.right = right;
  node.box = united(nodes_[static_cast<std::size_t>(left)].box,
                    nodes_[static_cast<std::size_t>(right)].box);
}

}  // namespace planish
