#include "planish/reconstruct/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"

namespace planish {
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
