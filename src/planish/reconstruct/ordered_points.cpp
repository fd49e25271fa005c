#include "planish/reconstruct/ordered_points.h"

#include <algorithm>
#include <atomic>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/core/drop_marked.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/spatial_order.h"

namespace planish {
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

}  // namespace planish
