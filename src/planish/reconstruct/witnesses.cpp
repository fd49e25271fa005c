#include "planish/reconstruct/witnesses.h"

#include <algorithm>
#include <cmath>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

// Searches that start from each other; so many that the first, from the tree's root, does not
// matter.
constexpr std::size_t kSearchesOfPiece = 2048;

using Indices = std::vector<std::int32_t>;

// Calls body(i, hit) for the points of a piece.
template <class PointAt, class Body>
void search_piece(const TriangleTree& tree, std::size_t begin, std::size_t end,
                  const PointAt& point_at, const Body& body) {
  std::int32_t start = -1;
  for (std::size_t i = begin; i < end; ++i) {
    const TriangleTree::Hit hit = tree.nearest(point_at(i), start);
    start = hit.place;
    body(i, hit);
  }
}

TriangleTree tree_of(const OrderedPoints& points, const WitnessedMesh& mesh) {
  std::vector<glm::dvec3> places;
  places.reserve(mesh.vertex_points.size());
  for (const std::int32_t point : mesh.vertex_points) places.push_back(points[point]);
  return {places, mesh.triangles};
}

void append(Indices& all, const Indices& part) { all.insert(all.end(), part.begin(), part.end()); }

}  // namespace

Indices find_carriers(const OrderedPoints& points, WitnessedMesh& mesh, double tolerance,
                      double limit, LoopProgress& progress) {
  mesh.carriers.assign(points.size(), -1);
  if (mesh.triangles.empty() || mesh.vertex_points.size() == points.size()) return {};
  const TriangleTree tree = tree_of(points, mesh);
  const auto beyond_in = [&](std::size_t begin, std::size_t end) {
    Indices beyond;
    auto vertex = std::ranges::lower_bound(mesh.vertex_points, static_cast<std::int32_t>(begin));
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[i]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          const auto point = static_cast<std::int32_t>(i);
          if (vertex != mesh.vertex_points.end() && *vertex == point) {
            ++vertex;
            return;
          }
          if (hit.squared_distance <= tolerance * tolerance) mesh.carriers[i] = hit.triangle;
          if (!(hit.squared_distance <= limit * limit)) beyond.push_back(point);
        });
    progress.add(static_cast<std::int64_t>(end - begin));
    return beyond;
  };
  return ordered_reduce(points.size(), kSearchesOfPiece, Indices(), beyond_in, append);
}

Indices points_beyond(const OrderedPoints& points, std::span<const std::int32_t> asked,
                      const WitnessedMesh& mesh, double limit) {
  if (asked.empty()) return {};
  const TriangleTree tree = tree_of(points, mesh);
  const auto beyond_in = [&](std::size_t begin, std::size_t end) {
    Indices beyond;
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[asked[i]]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          if (!(hit.squared_distance <= limit * limit)) beyond.push_back(asked[i]);
        });
    return beyond;
  };
  return ordered_reduce(asked.size(), kSearchesOfPiece, Indices(), beyond_in, append);
}

PointDistances measure_distances(const OrderedPoints& points, std::span<const Triangle> triangles) {
  if (points.size() == 0) return {};
  PLANISH_ASSERT(!triangles.empty());
  struct Sum {
    double largest = -1, squares = 0;
    std::int64_t farthest = -1;
  };
  const TriangleTree tree(points, triangles);
  const auto sum_of = [&](std::size_t begin, std::size_t end) {
    Sum sum;
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[i]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          sum.squares += hit.squared_distance;
          if (hit.squared_distance <= sum.largest) return;
          sum.largest = hit.squared_distance;
          sum.farthest = static_cast<std::int64_t>(i);
        });
    return sum;
  };
  const auto join = [](Sum& all, const Sum& part) {
    all.squares += part.squares;
    if (part.largest <= all.largest) return;
    all.largest = part.largest;
    all.farthest = part.farthest;
  };
  const Sum sum = ordered_reduce(points.size(), kSearchesOfPiece, Sum(), sum_of, join);
  return {.max = std::sqrt(sum.largest),
          .rms = std::sqrt(sum.squares / static_cast<double>(points.size())),
          .farthest = sum.farthest};
}

}  // namespace planish
