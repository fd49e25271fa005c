#include "planish/mesh/coherent_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/work.h"

namespace planish {

namespace {

constexpr double kStrongTurn = 0.99 * std::numbers::pi / 3;  // the walls of hexagons
// Of the turns around: what a weaker edge has to be.
constexpr double kTwice = 2;
constexpr double kFlatTurn = std::numbers::pi / 180;
// What lies around vertices of more faces is looked at once.
constexpr std::size_t kHubValence = 64;
// Strips: faces that turn by less are one, up to so many; edges are alike where one turns by about
// half as much as the other or more, nearly parallel. (Where a round begins its edge turns by
// half.)
constexpr double kOnePlaneCosine = 0.9994;  // 2 degrees
constexpr std::size_t kMostFacesOfPlane = 16;
constexpr std::int32_t kMostCornersOfPlane = 128;  // more have no other side
constexpr double kAlikeShare = 0.45;
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

EdgeTurns::Around EdgeTurns::look_around(std::int32_t vertex) const {
  count_work(Work::Pairs, static_cast<std::int64_t>(topology_.corners_at(vertex).size()));
  Around result{};
  for (const std::int32_t c : topology_.corners_at(vertex)) {
    const double own = turn(topology_.edge_of(c));
    if (own <= result.back()) continue;
    result.back() = own;
    std::ranges::sort(result, std::greater<>());
  }
  return result;
}

EdgeTurns::EdgeTurns(const PolygonMesh& mesh, const MeshTopology& topology,
                     std::span<const glm::dvec3> face_normals)
    : mesh_(mesh), topology_(topology), normals_(face_normals) {
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    if (topology.corners_at(v).size() > kHubValence) hubs_.emplace(v, look_around(v));
}

EdgeTurns::Around EdgeTurns::around(std::int32_t vertex) const {
  if (topology_.corners_at(vertex).size() <= kHubValence) return look_around(vertex);
  return hubs_.at(vertex);
}

// Where three lines end or fewer, as on blocks with chamfers, they speak for themselves: 0 then.
double EdgeTurns::third_turn(std::int32_t vertex) const {
  const Around turns = around(vertex);
  return turns.back() < kFlatTurn ? 0 : turns[2];
}

// The plane of a face up to another edge, across it, that turns, or turns alike and the same way.
EdgeTurns::Strip EdgeTurns::strip(std::int32_t edge, std::int32_t face, Across across) const {
  const auto [v, w] = topology_.edge_vertices(edge);
  const double own = signed_turn(edge);
  const std::int32_t corner = topology_.corner_of(edge);
  // As the face goes around.
  const glm::dvec3 direction = topology_.face_of(corner) == face ? along(edge) : -along(edge);
  std::vector<std::int32_t> plane{face};
  std::int32_t corners = 0;
  for (std::size_t i = 0; i < plane.size() && plane.size() <= kMostFacesOfPlane; ++i) {
    const std::int32_t first = topology_.first_corner(plane[i]),
                       size = topology_.face_size(plane[i]);
    corners += size;
    if (corners > kMostCornersOfPlane) break;
    count_work(Work::Pairs, size);
    for (std::int32_t c = first; c < first + size; ++c) {
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
      const bool is_alike = turned >= kAlikeShare && turned <= 1 / kAlikeShare;
      const glm::dvec3 back = topology_.corner_of(other) == c ? along(other) : -along(other);
      if ((is_alike || across == Across::Any) && glm::dot(back, direction) <= -kParallelCosine) {
        const glm::dvec3 between = middle_of(other) - middle_of(edge);
        return {glm::length(between - glm::dot(between, direction) * direction), other, next};
      }
    }
  }
  return {};
}

// Whether at both ends lines cross, one of them strong.
bool EdgeTurns::ends_at_walls(std::int32_t edge) const {
  const double own = turn(edge);
  const auto is_at_wall = [&](std::int32_t vertex) {
    const Around turns = around(vertex);
    const std::size_t largest_other = turns.front() == own ? 1 : 0;
    return turns[largest_other] >= kStrongTurn && turns.back() >= kAlikeShare * own;
  };
  const auto [v, w] = topology_.edge_vertices(edge);
  return is_at_wall(v) && is_at_wall(w);
}

bool EdgeTurns::bounds_chamfer(std::int32_t edge) const {
  if (topology_.is_boundary_edge(edge)) return false;
  const std::int32_t corner = topology_.corner_of(edge);
  const std::array faces{topology_.face_of(corner), topology_.face_of(topology_.twin(corner))};
  for (const std::size_t side : {0, 1}) {
    const Strip own = strip(edge, faces[side], Across::Alike);
    if (own.far_edge < 0) continue;
    const auto is_wide_beyond = [&](std::int32_t line, std::int32_t face) {
      const Strip other = strip(line, face, Across::Any);
      return other.far_edge < 0 || other.width >= kMostWidths * own.width;
    };
    if (is_wide_beyond(edge, faces[1 - side]) && is_wide_beyond(own.far_edge, own.far_face) &&
        (ends_at_walls(edge) || ends_at_walls(own.far_edge)))
      return true;
  }
  return false;
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
  if (own < kTwice * std::min(third_turn(v), third_turn(w))) return bounds_chamfer(edge);
  const std::int32_t corner = topology_.corner_of(edge);
  const Strip left = strip(edge, topology_.face_of(corner), Across::Alike);
  const Strip right = strip(edge, topology_.face_of(topology_.twin(corner)), Across::Alike);
  const auto is_strong = [&](const Strip& side) {
    return side.far_edge >= 0 && turn(side.far_edge) >= kStrongTurn;
  };
  if (is_strong(left) && is_strong(right)) return true;  // no round has a single edge
  return kMostWidths * std::min(left.width, right.width) <= std::max(left.width, right.width);
}

}  // namespace planish
