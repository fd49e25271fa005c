#include "planish/reconstruct/fill_hole.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {
namespace {

// What a partial triangulation costs; smaller is better, the angle first.
struct Cost {
  double turn = 2;  // 1 - cosine of the largest dihedral angle's supplement: 0 flat, 2 folded
  double area = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool operator<(const Cost& other) const {
    return turn < other.turn || (turn == other.turn && area < other.area);
  }
};

class HoleFiller {
 public:
  HoleFiller(std::span<const glm::dvec3> positions, const Hole& hole,
             const std::function<bool(std::int32_t, std::int32_t)>& is_edge)
      : positions_(positions),
        hole_(hole),
        is_edge_(is_edge),
        count_(static_cast<int>(hole.loop.size())),
        costs_(hole.loop.size() * hole.loop.size()),
        splits_(hole.loop.size() * hole.loop.size(), -1) {}

  std::vector<Triangle> fill() {
    for (int i = 0; i + 1 < count_; ++i) costs_[at(i, i + 1)] = {.turn = 0, .area = 0};
    for (int span = 2; span < count_; ++span)
      for (int i = 0; i + span < count_; ++i) choose(i, i + span);
    std::vector<Triangle> triangles;
    if (splits_[at(0, count_ - 1)] >= 0) collect(0, count_ - 1, triangles);
    return triangles;
  }

 private:
  [[nodiscard]] std::size_t at(int i, int k) const {
    return static_cast<std::size_t>(i) * count_ + k;
  }
  [[nodiscard]] glm::dvec3 cross(int i, int j, int k) const {
    const glm::dvec3 a = positions_[hole_.loop[i]];
    return glm::cross(positions_[hole_.loop[j]] - a, positions_[hole_.loop[k]] - a);
  }
  // Normal of what lies beyond the side from i to j of a triangle inside i..j.
  [[nodiscard]] glm::dvec3 beyond(int i, int j) const {
    if (j == i + 1) return hole_.normals[i];
    return glm::normalize(cross(i, splits_[at(i, j)], j));
  }

  // The best middle corner for the part of the loop from i to k.
  void choose(int i, int k) {
    const bool is_rim = i == 0 && k == count_ - 1;
    if (!is_rim && is_edge_(hole_.loop[i], hole_.loop[k])) return;
    for (int j = i + 1; j < k; ++j) {
      const Cost& left = costs_[at(i, j)];
      const Cost& right = costs_[at(j, k)];
      if (!std::isfinite(left.area) || !std::isfinite(right.area)) continue;
      const glm::dvec3 normal = cross(i, j, k);
      const double doubled_area = glm::length(normal);
      if (!(doubled_area > 0)) continue;
      const auto turn_to = [&](const glm::dvec3& other) {
        return 1 - glm::dot(normal, other) / doubled_area;
      };
      Cost cost{
          .turn = std::max({left.turn, right.turn, turn_to(beyond(i, j)), turn_to(beyond(j, k))}),
          .area = left.area + right.area + 0.5 * doubled_area};
      if (is_rim) cost.turn = std::max(cost.turn, turn_to(hole_.normals[k]));
      if (cost < costs_[at(i, k)]) {
        costs_[at(i, k)] = cost;
        splits_[at(i, k)] = j;
      }
    }
  }

  void collect(int i, int k, std::vector<Triangle>& triangles) const {
    if (k == i + 1) return;
    const int j = splits_[at(i, k)];
    triangles.push_back({hole_.loop[i], hole_.loop[j], hole_.loop[k]});
    collect(i, j, triangles);
    collect(j, k, triangles);
  }

  std::span<const glm::dvec3> positions_;
  const Hole& hole_;
  const std::function<bool(std::int32_t, std::int32_t)>& is_edge_;
  int count_;
  std::vector<Cost> costs_;  // of the best triangulation from i to k
  std::vector<int> splits_;  // its corner between i and k; -1 if there is none
};

}  // namespace

std::vector<Triangle> fill_hole(std::span<const glm::dvec3> positions, const Hole& hole,
                                const std::function<bool(std::int32_t, std::int32_t)>& is_edge) {
  if (hole.loop.size() < 3) return {};
  return HoleFiller(positions, hole, is_edge).fill();
}

}  // namespace planish
