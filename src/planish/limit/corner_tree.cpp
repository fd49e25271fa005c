#include "planish/limit/corner_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <optional>

#include "planish/core/eigenvectors.h"
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

// By how much less area boxes along other axes must have.
constexpr double kWorthTurning = 0.5;

// The chance of a ray to meet boxes is as their areas.
double area_of(std::span<const CornerBox> boxes) {
  double area = 0;
  for (const CornerBox& box : boxes) {
    const glm::dvec3 size = glm::dvec3(box.high) - glm::dvec3(box.low);
    area += size.x * size.y + size.y * size.z + size.z * size.x;
  }
  return area;
}

// Principal axes of the boxes' middles where these reach much less far along one than along
// another.
std::optional<glm::dmat3> axes_of_thin(std::span<const CornerBox> boxes) {
  constexpr double kThin = 1.0 / 16;
  const auto middle = [](const CornerBox& box) {
    return 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
  };
  const double count = static_cast<double>(boxes.size());
  glm::dvec3 mean(0.0);
  for (const CornerBox& box : boxes) mean += middle(box) / count;
  glm::dmat3 spread(0.0);
  for (const CornerBox& box : boxes) {
    const glm::dvec3 off = middle(box) - mean;
    spread += glm::outerProduct(off, off) / count;
  }
  const glm::dmat3 axes = eigenvectors(spread);
  const auto [least, most] = std::minmax({spread[0][0], spread[1][1], spread[2][2]});
  if (!(least < kThin * kThin * most)) return std::nullopt;
  return axes;
}

}  // namespace

CornerTree::CornerTree(const LimitSurface& surface) : surface_(surface) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::uint8_t> hidden = surface.surface().hidden();
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    if (hidden.empty() || hidden[topology.face_of(c)] == 0) corners_.push_back(c);
  }
  for (const PatchForm* form : surface.forms()) reaches_.add(*form);
  rebuild();
}

void CornerTree::make_boxes(std::span<const std::int32_t> corners,
                            std::span<CornerBox> boxes) const {
  parallel_for(corners.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
    LimitSurface::Corner corner(surface_);
    std::vector<glm::dvec3> points;
    for (std::size_t i = begin; i < end; ++i) {
      corner.move_to(corners[i]);
      std::span<const glm::dvec3> given = corner.points();
      if (is_turned_) {
        points.clear();
        for (const glm::dvec3& point : given) points.push_back(turned(point));
        given = points;
      }
      boxes[i] = outward(patch_box(corner.form(), given, reaches_), turned(corner.own()));
    }
  });
}

void CornerTree::rebuild() {
  place_of_corner_.clear();
  std::ranges::sort(corners_);
  if (corners_.empty()) return;
  RawVector<CornerBox> in_order(corners_.size());
  is_turned_ = false;
  make_boxes(corners_, in_order);
  choose_axes(in_order);
  boxes_.resize(static_cast<std::size_t>(surface_.topology().corner_count()));
  for (std::size_t i = 0; i < corners_.size(); ++i)  // by corner while the tree is made
    boxes_[corners_[i]] = in_order[i];
  const auto count = static_cast<std::int32_t>(corners_.size());
  nodes_.resize(static_cast<std::size_t>(node_count(count)));
  build(0, 0, count);
  for (std::size_t i = 0; i < corners_.size(); ++i) in_order[i] = boxes_[corners_[i]];
  boxes_.swap(in_order);
}

void CornerTree::choose_axes(RawVector<CornerBox>& boxes) {
  const auto axes = axes_of_thin(boxes);
  if (!axes) return;
  axes_ = *axes;
  is_turned_ = true;
  RawVector<CornerBox> along(boxes.size());
  make_boxes(corners_, along);
  if (area_of(along) < kWorthTurning * area_of(boxes)) {
    boxes.swap(along);
  } else {
    is_turned_ = false;
  }
}

std::int64_t CornerTree::refit(std::span<const std::int32_t> corners) {
  if (nodes_.empty() || corners.empty()) return 0;
  if (place_of_corner_.empty()) number_places();
  places_.clear();
  for (const std::int32_t corner : corners)
    if (const std::int32_t place = place_of_corner_[corner]; place >= 0) places_.push_back(place);
  std::ranges::sort(places_);
  of_places_.clear();
  for (const std::int32_t place : places_) of_places_.push_back(corners_[place]);
  new_boxes_.resize(places_.size());
  make_boxes(of_places_, new_boxes_);
  for (std::size_t i = 0; i < places_.size(); ++i) boxes_[places_[i]] = new_boxes_[i];
  return refit_node(0, 0, static_cast<std::int32_t>(corners_.size()), places_);
}

void CornerTree::number_places() {
  place_of_corner_.assign(static_cast<std::size_t>(surface_.topology().corner_count()), -1);
  for (std::size_t i = 0; i < corners_.size(); ++i)
    place_of_corner_[corners_[i]] = static_cast<std::int32_t>(i);
}

// The node over corners_[first] to corners_[last - 1], some of which have other boxes.
std::int64_t CornerTree::refit_node(std::int32_t index, std::int32_t first, std::int32_t last,
                                    std::span<const std::int32_t> places) {
  if (places.empty()) return 0;
  Node& node = nodes_[index];
  if (node.count > 0) {
    node.box = boxes_[first];
    for (std::int32_t i = first + 1; i < last; ++i) node.box = united(node.box, boxes_[i]);
    return 1;
  }
  const std::int32_t middle = first + (last - first) / 2;
  const auto split =
      static_cast<std::size_t>(std::ranges::lower_bound(places, middle) - places.begin());
  const std::int64_t count = 1 + refit_node(index + 1, first, middle, places.first(split)) +
                             refit_node(node.right, middle, last, places.subspan(split));
  node.box = united(nodes_[index + 1].box, nodes_[node.right].box);
  return count;
}

void CornerTree::build(std::int32_t index, std::int32_t first, std::int32_t last) {
  check_stop();
  Node& node = nodes_[index];
  node = {};
  const auto box = [&](std::int32_t i) -> const CornerBox& { return boxes_[corners_[i]]; };
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
                     const CornerBox& p = boxes_[a];
                     const CornerBox& q = boxes_[b];
                     const float pa = p.low[along] + p.high[along];
                     const float qa = q.low[along] + q.high[along];
                     return pa != qa ? pa < qa : a < b;
                   });
  const std::int32_t left = index + 1, right = left + node_count(middle - first);
  if (last - first > kSerial) {
    parallel_each(2, 1, [&](std::size_t half) {
      half == 0 ? build(left, first, middle) : build(right, middle, last);
    });
  } else {
    build(left, first, middle);
    build(right, middle, last);
  }
  node.right = right;
  node.box = united(nodes_[left].box, nodes_[right].box);
}

}  // namespace planish
