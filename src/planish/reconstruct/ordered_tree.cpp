#include "planish/reconstruct/ordered_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "planish/core/parallel.h"

namespace planish {
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

}  // namespace planish
