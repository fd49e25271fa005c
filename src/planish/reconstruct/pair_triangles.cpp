// Based on: C. Berge, "Two Theorems in Graph Theory", 1957 (a matching grows along a path that
// leaves and enters its pairs in turn).
#include "planish/reconstruct/pair_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "planish/reconstruct/triangle_edges.h"

namespace planish {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
// Most pairs that are exchanged to pair two triangles more, and the largest deviation from a right
// angle of what comes in: pairs by exchange are worse quads, and where their corners are wider than
// 130 degrees the progressive surface folds on a third more of its area.
constexpr int kMostExchanges = 2;
constexpr double kWorstExchanged = 40 * kRadians;
constexpr double kNoPair = -1;

// a, d, b, c for the edge a b with the opposite corners c and d.
std::array<std::int32_t, 4> quad_of(std::span<const Triangle> triangles, std::int32_t half_edge,
                                    std::int32_t twin) {
  const auto start = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  return {start(half_edge), start(previous_half_edge(twin)), start(twin),
          start(previous_half_edge(half_edge))};
}

// Largest deviation of a corner from a right angle; none for a quad that may not be.
std::optional<double> badness_of(std::span<const glm::dvec3> positions,
                                 const std::array<std::int32_t, 4>& quad,
                                 const PairOptions& options) {
  const auto place = [&](std::size_t i) { return positions[quad[i % 4]]; };
  const glm::dvec3 n0 = glm::cross(place(1) - place(0), place(2) - place(0));
  const glm::dvec3 n1 = glm::cross(place(2) - place(0), place(3) - place(0));
  const double lengths = glm::length(n0) * glm::length(n1);
  if (!(lengths > 0) || glm::dot(n0, n1) < lengths * std::cos(options.largest_turn * kRadians))
    return std::nullopt;
  const glm::dvec3 normal = n0 + n1;
  double worst = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 ahead = place(i + 1) - place(i), back = place(i + 3) - place(i);
    const glm::dvec3 cross = glm::cross(ahead, back);
    if (!(glm::dot(cross, normal) > 0)) return std::nullopt;
    const double angle = std::atan2(glm::length(cross), glm::dot(ahead, back));
    if (angle > options.largest_angle * kRadians) return std::nullopt;
    worst = std::max(worst, std::abs(angle - std::numbers::pi / 2));
  }
  return worst;
}

// Grows a set of pairs, each a half-edge and its twin.
class Pairing {
 public:
  // `badness` by half-edge, kNoPair where there may be no pair.
  Pairing(std::span<const std::int32_t> twins, std::vector<double> badness)
      : twins_(twins), badness_(std::move(badness)), chosen_(twins.size() / 3, -1) {}

  // A triangle's half-edge to its partner; -1: none.
  [[nodiscard]] std::span<const std::int32_t> chosen() const { return chosen_; }

  void pair_greedily() {
    std::vector<std::int32_t> order;
    for (std::int32_t h = 0; h < static_cast<std::int32_t>(twins_.size()); ++h)
      if (badness_[h] != kNoPair && h < twins_[h]) order.push_back(h);
    std::ranges::stable_sort(order, {}, [&](std::int32_t h) { return badness_[h]; });
    for (const std::int32_t h : order)
      if (chosen_[h / 3] < 0 && chosen_[twins_[h] / 3] < 0) join(h);
  }

  // For each triangle left alone, the least bad way to another with at most so many exchanges.
  void exchange(int most) {
    bool found = true;
    while (found) {
      found = false;
      for (std::int32_t t = 0; t < static_cast<std::int32_t>(chosen_.size()); ++t) {
        if (chosen_[t] >= 0) continue;
        best_.clear();
        best_cost_ = std::numeric_limits<double>::infinity();
        search(t, most, 0);
        for (const std::int32_t h : best_) join(h);
        found = found || !best_.empty();
      }
    }
  }

 private:
  void join(std::int32_t half_edge) {
    chosen_[half_edge / 3] = half_edge;
    chosen_[twins_[half_edge] / 3] = twins_[half_edge];
  }

  // Continues path_ from a triangle that has lost its partner, or has none.
  void search(std::int32_t triangle, int exchanges, double cost) {
    passed_.push_back(triangle);
    for (std::int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
      if (badness_[h] == kNoPair || badness_[h] > kWorstExchanged || h == chosen_[triangle])
        continue;
      const std::int32_t next = twins_[h] / 3;
      if (std::ranges::find(passed_, next) != passed_.end()) continue;
      path_.push_back(h);
      const std::int32_t left = chosen_[next];
      if (left < 0) {
        if (cost + badness_[h] < best_cost_) {
          best_cost_ = cost + badness_[h];
          best_ = path_;
        }
      } else if (exchanges > 0) {
        passed_.push_back(next);
        search(twins_[left] / 3, exchanges - 1, cost + badness_[h] - badness_[left]);
        passed_.pop_back();
      }
      path_.pop_back();
    }
    passed_.pop_back();
  }

  std::span<const std::int32_t> twins_;
  std::vector<double> badness_;
  std::vector<std::int32_t> chosen_;
  std::vector<std::int32_t> path_, passed_, best_;  // half-edges to join; triangles; half-edges
  double best_cost_ = 0;
};

}  // namespace

PolygonMesh pair_triangles(std::span<const glm::dvec3> positions,
                           std::span<const Triangle> triangles, const PairOptions& options) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  std::vector<double> badness(twins.size(), kNoPair);
  for (std::int32_t h = 0; h < static_cast<std::int32_t>(twins.size()); ++h) {
    if (twins[h] < h) continue;
    const auto found = badness_of(positions, quad_of(triangles, h, twins[h]), options);
    if (found) badness[h] = badness[twins[h]] = *found;
  }
  Pairing pairing(twins, std::move(badness));
  pairing.pair_greedily();
  for (int most = 1; most <= kMostExchanges; ++most) pairing.exchange(most);

  PolygonMesh mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::int32_t half_edge = pairing.chosen()[t];
    if (half_edge < 0) {
      mesh.add_face(triangles[t]);
    } else if (half_edge < twins[half_edge]) {
      mesh.add_face(quad_of(triangles, half_edge, twins[half_edge]));
    }
  }
  return mesh;
}

}  // namespace planish
