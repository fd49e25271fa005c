#include "planish/mesh/coherent_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

namespace planish {

namespace {

constexpr double kStrongTurn = std::numbers::pi / 3;
// Of the turns around: what a weaker edge has to be.
constexpr double kTwice = 2;
constexpr double kFlatTurn = std::numbers::pi / 180;
// Edges with fewer faces at both ends, as chamfered blocks have, speak for themselves.
constexpr std::int32_t kTellingValence = 4;
// Strips: faces that turn by less are one, up to so many; edges are alike where one turns by at
// least half as much as the other, nearly parallel.
constexpr double kOnePlaneCosine = 0.9994;  // 2 degrees
constexpr std::size_t kMostOfPlane = 16;
constexpr double kAlikeShare = 0.5;
constexpr double kParallelCosine = 0.94;  // 20 degrees
// Strips of one round are about as wide as each other; a chamfer is narrow beside what it ends.
constexpr double kMostWidths = 2.5;

}  // namespace

glm::dvec3 EdgeTurns::along(std::int32_t edge) const {
  const auto [v, w] = topology_.edge_vertices(edge);
  const glm::dvec3 direction = mesh_.positions[w] - mesh_.positions[v];
  const double length = glm::length(direction);
  return length > 0 ? direction / length : direction;
}

glm::dvec3 EdgeTurns::middle_of(std::int32_t edge) const {
  const auto [v, w] = topology_.edge_vertices(edge);
  return 0.5 * (mesh_.positions[v] + mesh_.positions[w]);
}

double EdgeTurns::turn(std::int32_t edge) const { return std::abs(signed_turn(edge)); }

double EdgeTurns::signed_turn(std::int32_t edge) const {
  if (topology_.is_boundary_edge(edge)) return 0;
  const std::int32_t corner = topology_.corner_of(edge);
  const glm::dvec3& a = normals_[topology_.face_of(corner)];
  const glm::dvec3& b = normals_[topology_.face_of(topology_.twin(corner))];
  if (a == glm::dvec3(0.0) || b == glm::dvec3(0.0)) return 0;
  const glm::dvec3 across = glm::cross(a, b);
  const double angle = std::atan2(glm::length(across), glm::dot(a, b));
  const auto [from, to] = topology_.edge_vertices(edge);
  return glm::dot(across, mesh_.positions[to] - mesh_.positions[from]) < 0 ? -angle : angle;
}

double EdgeTurns::third_turn(std::int32_t vertex) const {
  const auto corners = topology_.corners_at(vertex);
  if (static_cast<std::int32_t>(corners.size()) < kTellingValence) return 0;
  std::array<double, 3> largest{0, 0, 0};
  for (const std::int32_t c : corners) {
    const double own = turn(topology_.edge_of(c));
    if (own <= largest[2]) continue;
    largest[2] = own;
    std::ranges::sort(largest, std::greater<>());
  }
  return largest[2];
}

// How far off, beyond the plane of a face, there is another edge that turns alike and the same way;
// 0: there is none.
double EdgeTurns::strip_width(std::int32_t edge, std::int32_t face) const {
  const auto [v, w] = topology_.edge_vertices(edge);
  const double own = signed_turn(edge);
  const glm::dvec3 direction = along(edge);
  std::vector<std::int32_t> plane{face};
  for (std::size_t i = 0; i < plane.size() && plane.size() <= kMostOfPlane; ++i) {
    const std::int32_t first = topology_.first_corner(plane[i]);
    for (std::int32_t c = first; c < first + topology_.face_size(plane[i]); ++c) {
      const std::int32_t twin = topology_.twin(c), other = topology_.edge_of(c);
      if (twin < 0 || other == edge) continue;
      const std::int32_t next = topology_.face_of(twin);
      const glm::dvec3 &a = normals_[face], &b = normals_[next];
      if (glm::dot(a, b) >= kOnePlaneCosine * glm::length(a) * glm::length(b)) {
        if (std::ranges::find(plane, next) == plane.end()) plane.push_back(next);
        continue;
      }
      const auto [p, q] = topology_.edge_vertices(other);
      if (p == v || p == w || q == v || q == w) continue;
      const double turned = signed_turn(other) / own;
      if (turned >= kAlikeShare && turned <= 1 / kAlikeShare &&
          std::abs(glm::dot(along(other), direction)) >= kParallelCosine) {
        const glm::dvec3 between = middle_of(other) - middle_of(edge);
        return glm::length(between - glm::dot(between, direction) * direction);
      }
    }
  }
  return 0;
}

// Whether the faces at a corner's vertex, from the corner on, are flat up to a boundary or to an
// edge that turns by half of `line` at least. One face alone says nothing. The vertex has such an
// edge.
bool EdgeTurns::is_flat_up_to_line(std::int32_t corner, bool is_ccw, double line) const {
  for (std::int32_t faces = 1;; ++faces) {
    const std::int32_t edge = topology_.edge_of(is_ccw ? topology_.prev(corner) : corner);
    const bool ends = topology_.is_boundary_edge(edge);
    if (ends || turn(edge) >= kFlatTurn) return faces > 1 && (ends || turn(edge) >= line / kTwice);
    corner = is_ccw ? topology_.ccw(corner) : topology_.cw(corner);
  }
}

bool EdgeTurns::is_clear(std::int32_t edge) const {
  const auto [v, w] = topology_.edge_vertices(edge);
  const bool v_ends = topology_.is_boundary_vertex(v), w_ends = topology_.is_boundary_vertex(w);
  if (v_ends && w_ends) return true;  // nothing speaks against it
  if ((!v_ends && third_turn(v) < kFlatTurn) || (!w_ends && third_turn(w) < kFlatTurn)) return true;
  const double own = turn(edge);
  const std::int32_t corner = topology_.corner_of(edge);
  return std::ranges::any_of(std::array{corner, topology_.twin(corner)}, [&](std::int32_t c) {
    return is_flat_up_to_line(c, true, own) && is_flat_up_to_line(topology_.next(c), false, own);
  });
}

bool EdgeTurns::stands_out(std::int32_t edge) const {
  const double own = turn(edge);
  if (own >= kStrongTurn) return true;
  const auto [v, w] = topology_.edge_vertices(edge);
  if (own < kTwice * std::min(third_turn(v), third_turn(w))) return false;
  const std::int32_t corner = topology_.corner_of(edge);
  const double left = strip_width(edge, topology_.face_of(corner));
  const double right = strip_width(edge, topology_.face_of(topology_.twin(corner)));
  return kMostWidths * std::min(left, right) <= std::max(left, right);
}

}  // namespace planish
