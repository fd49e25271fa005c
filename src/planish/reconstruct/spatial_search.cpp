#include "planish/reconstruct/spatial_search.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/point_tree.h"

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

namespace {

bool are_single(std::span<const glm::dvec3> points) {
  std::atomic<bool> all = true;
  parallel_for(points.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && all; ++i)
      if (glm::dvec3(glm::vec3(points[i])) != points[i]) all = false;
  });
  return all;
}

}  // namespace

OrderedPoints::OrderedPoints(std::span<const glm::dvec3> points) : given_(spatial_order(points)) {
  const bool single = are_single(points);
  single ? floats_.resize(size()) : doubles_.resize(size());
  parallel_each(size(), [&](std::size_t i) {
    const glm::dvec3& place = points[given_[i]];
    if (single)
      floats_[i] = glm::vec3(place);
    else
      doubles_[i] = place;
  });
}

void OrderedPoints::drop(std::span<const std::uint8_t> is_dropped) {
  drop_marked(given_, is_dropped);
  doubles_.empty() ? drop_marked(floats_, is_dropped) : drop_marked(doubles_, is_dropped);
}

void OrderedPoints::move_to(std::vector<glm::dvec3> places) {
  floats_ = {};
  doubles_ = std::move(places);
}

std::int64_t drop_duplicates(OrderedPoints& points) {
  std::vector<std::uint8_t> repeated(points.size(), 0);
  std::int64_t count = 0;
  for (std::size_t i = 1; i < points.size(); ++i) count += repeated[i] = points[i] == points[i - 1];
  if (count > 0) points.drop(repeated);
  return count;
}

double diagonal_of(const OrderedPoints& points) {
  if (points.size() == 0) return 0;
  glm::dvec3 low = points[0], high = low;
  for (std::size_t i = 1; i < points.size(); ++i) {
    low = glm::min(low, points[i]);
    high = glm::max(high, points[i]);
  }
  return glm::distance(low, high);
}

namespace {

// Based on: J. L. Bentley, "Multidimensional Binary Search Trees Used for Associative Searching",
// 1975; laid out in one array as a balanced tree.

constexpr std::int32_t kPointsOfLeaf = 12;

}  // namespace

struct PointTree::Search {
  glm::dvec3 query;
  std::span<Neighbour> nearest;
  std::size_t count = 0;

  [[nodiscard]] bool wants(double squared_distance) const {
    return count < nearest.size() || squared_distance < nearest[count - 1].squared_distance;
  }
  void offer(double squared_distance, std::int32_t index) {
    if (!wants(squared_distance)) return;
    std::size_t at = count < nearest.size() ? count++ : count - 1;
    for (; at > 0 && nearest[at - 1].squared_distance > squared_distance; --at)
      nearest[at] = nearest[at - 1];
    nearest[at] = {squared_distance, index};
  }
};

PointTree::PointTree(std::span<const glm::dvec3> points)
    : indices_(points.size()), points_(points.begin(), points.end()), axes_(points.size(), 0) {
  std::iota(indices_.begin(), indices_.end(), 0);
  build(0, static_cast<std::int32_t>(points.size()));
  for (std::size_t i = 0; i < indices_.size(); ++i) points_[i] = points[indices_[i]];
}

// While the tree is built, points_ still has the order of the input.
void PointTree::build(std::int32_t begin, std::int32_t end) {
  if (end - begin <= kPointsOfLeaf) return;
  glm::dvec3 low = points_[indices_[begin]], high = low;
  for (std::int32_t i = begin + 1; i < end; ++i) {
    low = glm::min(low, points_[indices_[i]]);
    high = glm::max(high, points_[indices_[i]]);
  }
  const glm::dvec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::int32_t middle = begin + (end - begin) / 2;
  // Ties are broken by index: the tree does not depend on the library's nth_element.
  std::nth_element(indices_.begin() + begin, indices_.begin() + middle, indices_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = points_[a][axis], y = points_[b][axis];
                     return x < y || (x == y && a < b);
                   });
  axes_[middle] = static_cast<std::uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

void PointTree::search(std::int32_t begin, std::int32_t end, Search& state) const {
  const auto offer = [&](std::int32_t at) {
    const glm::dvec3 difference = points_[at] - state.query;
    state.offer(glm::dot(difference, difference), indices_[at]);
  };
  if (end - begin <= kPointsOfLeaf) {
    for (std::int32_t at = begin; at < end; ++at) offer(at);
    return;
  }
  const std::int32_t middle = begin + (end - begin) / 2;
  const double beyond = state.query[axes_[middle]] - points_[middle][axes_[middle]];
  beyond < 0 ? search(begin, middle, state) : search(middle + 1, end, state);
  if (!state.wants(beyond * beyond)) return;
  offer(middle);
  beyond < 0 ? search(middle + 1, end, state) : search(begin, middle, state);
}

std::size_t PointTree::find_nearest(const glm::dvec3& query, std::span<Neighbour> nearest) const {
  Search state{.query = query, .nearest = nearest};
  if (!nearest.empty()) search(0, static_cast<std::int32_t>(points_.size()), state);
  return state.count;
}

namespace {

constexpr std::size_t kRun = 8;  // points of a box, and boxes of one
constexpr std::size_t kBoxGrain = 1024;

// Outwards by a unit in the last place at least: coordinates may be doubles.
float below(double x) {
  constexpr float kLowest = std::numeric_limits<float>::lowest();
  return x <= kLowest ? -std::numeric_limits<float>::infinity()
                      : std::nextafter(static_cast<float>(x), kLowest);
}
float above(double x) { return -below(-x); }

}  // namespace

struct OrderedTree::Search {
  glm::dvec3 query;
  std::size_t first_run;  // searched already
  std::span<Neighbour> nearest;
  std::size_t count = 0;

  [[nodiscard]] bool wants(double squared_distance) const {
    return count < nearest.size() || squared_distance <= nearest[count - 1].squared_distance;
  }
  void offer(double squared_distance, std::int32_t index) {
    const auto is_nearer = [&](const Neighbour& other) {
      return squared_distance < other.squared_distance ||
             (squared_distance == other.squared_distance && index < other.index);
    };
    if (count == nearest.size() && !is_nearer(nearest[count - 1])) return;
    std::size_t at = count < nearest.size() ? count++ : count - 1;
    for (; at > 0 && is_nearer(nearest[at - 1]); --at) nearest[at] = nearest[at - 1];
    nearest[at] = {squared_distance, index};
  }
  void offer_run(const OrderedPoints& points, std::size_t run) {
    const std::size_t end = std::min((run + 1) * kRun, points.size());
    for (std::size_t i = run * kRun; i < end; ++i) {
      const glm::dvec3 difference = points[i] - query;
      offer(glm::dot(difference, difference), static_cast<std::int32_t>(i));
    }
  }
};

OrderedTree::OrderedTree(const OrderedPoints& points) : points_(points) {
  std::vector<Box> boxes((points.size() + kRun - 1) / kRun);
  parallel_each(boxes.size(), kBoxGrain, [&](std::size_t b) {
    glm::dvec3 low = points[b * kRun], high = low;
    for (std::size_t i = b * kRun; i < std::min((b + 1) * kRun, points.size()); ++i) {
      low = glm::min(low, points[i]);
      high = glm::max(high, points[i]);
    }
    boxes[b] = {{below(low.x), below(low.y), below(low.z)},
                {above(high.x), above(high.y), above(high.z)}};
  });
  while (boxes.size() > 1) {
    std::vector<Box> wider((boxes.size() + kRun - 1) / kRun);
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      Box& box = wider[b / kRun];
      box = b % kRun == 0 ? boxes[b]
                          : Box{glm::min(box.low, boxes[b].low), glm::max(box.high, boxes[b].high)};
    }
    levels_.push_back(std::exchange(boxes, std::move(wider)));
  }
  levels_.push_back(std::move(boxes));
}

void OrderedTree::visit(std::size_t level, std::size_t box, Search& search) const {
  if (level == 0) {
    if (box != search.first_run) search.offer_run(points_, box);
    return;
  }
  std::array<std::pair<double, std::size_t>, kRun> children;
  std::size_t count = 0;
  const std::vector<Box>& below_it = levels_[level - 1];
  const std::size_t end = std::min((box + 1) * kRun, below_it.size());
  for (std::size_t child = box * kRun; child < end; ++child) {
    const glm::dvec3 low(below_it[child].low), high(below_it[child].high);
    const glm::dvec3 outside =
        glm::max(glm::max(low - search.query, search.query - high), glm::dvec3(0.0));
    const double squared = glm::dot(outside, outside);
    if (!search.wants(squared)) continue;
    std::size_t at = count++;
    for (; at > 0 && children[at - 1].first > squared; --at) children[at] = children[at - 1];
    children[at] = {squared, child};
  }
  for (std::size_t i = 0; i < count && search.wants(children[i].first); ++i)
    visit(level - 1, children[i].second, search);
}

std::size_t OrderedTree::find_nearest(const glm::dvec3& query, std::int32_t start,
                                      std::span<Neighbour> nearest) const {
  if (nearest.empty() || points_.size() == 0) return 0;
  Search search{
      .query = query, .first_run = static_cast<std::size_t>(start) / kRun, .nearest = nearest};
  search.offer_run(points_, search.first_run);
  visit(levels_.size() - 1, 0, search);
  return search.count;
}

namespace {

constexpr std::int32_t kTrianglesOfLeaf = 4;
constexpr std::size_t kTreeGrain = 512;

double squared_distance_to_box(const glm::dvec3& p, const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 outside = glm::max(glm::max(low - p, p - high), glm::dvec3(0.0));
  return glm::dot(outside, outside);
}

}  // namespace

TriangleTree::TriangleTree(std::span<const glm::dvec3> positions,
                           std::span<const Triangle> triangles) {
  shapes_.reserve(triangles.size());
  for (const Triangle& t : triangles)
    shapes_.emplace_back(positions[t[0]], positions[t[1]], positions[t[2]]);
  build();
}

TriangleTree::TriangleTree(const OrderedPoints& positions, std::span<const Triangle> triangles) {
  shapes_.reserve(triangles.size());
  for (const Triangle& t : triangles)
    shapes_.emplace_back(positions[t[0]], positions[t[1]], positions[t[2]]);
  build();
}

void TriangleTree::build() {
  order_.resize(shapes_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<glm::dvec3> centres;
  centres.reserve(shapes_.size());
  for (const TriangleShape& shape : shapes_)
    centres.push_back(shape.a + (shape.ab + shape.ac) / 3.0);
  if (!shapes_.empty()) build(0, static_cast<std::int32_t>(shapes_.size()), centres);
  std::vector<TriangleShape> ordered;
  ordered.reserve(shapes_.size());
  for (const std::int32_t triangle : order_) ordered.push_back(shapes_[triangle]);
  shapes_ = std::move(ordered);
}

// While the tree is built, shapes_ has the order of the input.
void TriangleTree::build(std::int32_t begin, std::int32_t end,
                         std::span<const glm::dvec3> centres) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t at = nodes_.size();
  Node node{glm::dvec3(kInfinity), glm::dvec3(-kInfinity), begin, end};
  glm::dvec3 low(kInfinity), high(-kInfinity);  // of the centres
  for (std::int32_t i = begin; i < end; ++i) {
    const TriangleShape& shape = shapes_[order_[i]];
    for (const glm::dvec3& corner : {shape.a, shape.a + shape.ab, shape.a + shape.ac}) {
      node.low = glm::min(node.low, corner);
      node.high = glm::max(node.high, corner);
    }
    low = glm::min(low, centres[order_[i]]);
    high = glm::max(high, centres[order_[i]]);
  }
  nodes_.push_back(node);
  if (end - begin <= kTrianglesOfLeaf) return;
  const glm::dvec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = centres[a][axis], y = centres[b][axis];
                     return x < y || (x == y && a < b);
                   });
  build(begin, middle, centres);
  nodes_[at].right = static_cast<std::int32_t>(nodes_.size());
  build(middle, end, centres);
}

TriangleTree::Hit TriangleTree::nearest(const glm::dvec3& point, std::int32_t start) const {
  Hit hit{std::numeric_limits<double>::infinity(), -1, -1};
  if (nodes_.empty()) return hit;
  if (start >= 0) hit = {shapes_[start].squared_distance(point), order_[start], start};
  struct Entry {
    double squared_distance;
    std::int32_t node;
  };
  // Median splits keep the depth below 32, and each level leaves one entry.
  std::array<Entry, 64> stack;
  std::size_t size = 0;
  const auto distance_to = [&](std::int32_t node) {
    return squared_distance_to_box(point, nodes_[node].low, nodes_[node].high);
  };
  stack[size++] = {distance_to(0), 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.squared_distance >= hit.squared_distance) continue;
    const Node& node = nodes_[entry.node];
    if (node.right < 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i) {
        const double squared = shapes_[i].squared_distance(point);
        if (squared < hit.squared_distance) hit = {squared, order_[i], i};
      }
      continue;
    }
    Entry left{distance_to(entry.node + 1), entry.node + 1};
    Entry right{distance_to(node.right), node.right};
    if (left.squared_distance < right.squared_distance) std::swap(left, right);
    stack[size++] = left;
    stack[size++] = right;
  }
  return hit;
}

PointDistances measure_distances(std::span<const glm::dvec3> points,
                                 std::span<const glm::dvec3> positions,
                                 std::span<const Triangle> triangles) {
  if (points.empty()) return {};
  PLANISH_ASSERT(!triangles.empty());
  const TriangleTree tree(positions, triangles);
  std::vector<double> squared(points.size());
  parallel_each(points.size(), kTreeGrain,
                [&](std::size_t i) { squared[i] = tree.nearest(points[i]).squared_distance; });
  const auto farthest = std::ranges::max_element(squared);
  const double sum = std::accumulate(squared.begin(), squared.end(), 0.0);
  return {.max = std::sqrt(*farthest),
          .rms = std::sqrt(sum / static_cast<double>(points.size())),
          .farthest = farthest - squared.begin()};
}

}  // namespace planish
