#include "planish/limit/face_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/limit/adaptive_cells.h"
#include "planish/limit/bezier_net.h"

namespace planish {
namespace {

// Places are whole numbers: a part may be longer by one than it should be.
constexpr double kUnit = 1.0 / kCellSide;
constexpr int kMostParts = 64;

}  // namespace

bool stands_alone(const MeshTopology& topology, std::int32_t face) {
  struct Other {
    std::int32_t face, place, corner;
  };
  std::vector<Other> others;
  const std::int32_t first = topology.first_corner(face), size = topology.face_size(face);
  for (std::int32_t i = 0; i < size; ++i) {
    for (const std::int32_t c : topology.corners_at(topology.vertex_of(first + i))) {
      if (topology.face_of(c) != face) others.push_back({topology.face_of(c), i, c});
    }
  }
  std::ranges::sort(others, {}, [](const Other& o) { return std::pair(o.face, o.place); });
  for (std::size_t i = 1; i < others.size(); ++i) {
    const Other &a = others[i - 1], &b = others[i];
    if (a.face != b.face) continue;
    if (i + 1 < others.size() && others[i + 1].face == a.face) return false;
    // b's leading edge is that from place a to place b, or the other way round.
    const bool is_edge =
        topology.twin(first + a.place) == b.corner || topology.twin(first + b.place) == a.corner;
    if (!is_edge) return false;
  }
  return true;
}

bool GridFinder::take_nets(std::int32_t face) {
  const MeshTopology& topology = surface_.topology();
  if (topology.face_size(face) != 4) return false;
  std::array<glm::dvec3, 4> at;
  for (int q = 0; q < 4; ++q) {
    corner_.move_to(topology.first_corner(face) + q);
    if (!corner_.form().is_polynomial()) return false;
    const BezierNet net = bezier_net(corner_.form(), corner_.points());
    at[q] = corner_.own() + net[0];
    nets_[q] = turned_net(net, q);
  }
  length_u_ = std::max(glm::length(at[1] - at[0]), glm::length(at[2] - at[3]));
  length_v_ = std::max(glm::length(at[3] - at[0]), glm::length(at[2] - at[1]));
  return true;
}

bool GridFinder::keeps_in(const Region& region, double size_u, double size_v) const {
  std::array<BoundPiece, kMostPieces> pieces;
  std::size_t count = 0;
  for (int q = 0; q < 4; ++q) {
    const double left = q == 1 || q == 2 ? 1 : 0, low = q >= 2 ? 1 : 0;
    const double u0 = std::max(region.u0 - left, 0.0), u1 = std::min(region.u1 - left, 1.0);
    const double v0 = std::max(region.v0 - low, 0.0), v1 = std::min(region.v1 - low, 1.0);
    if (!(u1 - u0 > kUnit) || !(v1 - v0 > kUnit)) continue;
    const BezierNet& net = nets_[q];
    pieces[count++] = {net_between(net_between(net, true, v0, v1), false, u0, u1),
                       size_u / (u1 - u0), size_v / (v1 - v0)};
  }
  const CellBound bound = bound_of(std::span(pieces).first(count));
  if (limits_.distance > 0 && !(bound.distance <= limits_.distance)) return false;
  return limits_.turn == 0 || bound.turn <= limits_.turn;
}

// Chords on the sides that are curves of their own.
bool GridFinder::keeps_borders(int u, int v) const {
  if (limits_.distance == 0) return true;
  for (int side = 0; side < 4; ++side) {
    if (!limits_.borders[side]) continue;
    const double size = 2.0 / (side % 2 == 0 ? u : v) + 2 * kUnit;
    std::array<BezierCurve, 2> halves;
    for (int half = 0; half < 2; ++half) {
      const BezierNet net = turned_net(nets_[(side + half) % 4], (4 - side) % 4);
      halves[half] = {net[0], net[1], net[2]};
    }
    if (!(curve_bound(halves) * size * size <= limits_.distance)) return false;
  }
  return true;
}

bool GridFinder::is_slim(int u, int v) const {
  constexpr double kLongest = 8;
  const double a = length_u_ / u, b = length_v_ / v;
  const auto ratio = [](double s, double t) { return std::max(s, t) / std::min(s, t); };
  return (u > 1 || v > 1) && ratio(a, b) > std::max(kLongest, ratio(length_u_, length_v_));
}

// A triangle within a row of parts has a part's size, but lies anywhere along the row where a side
// has more places than the grid: so rows beside a side are looked at two parts at a time.
bool GridFinder::keeps(int u, int v) {
  if (is_slim(u, v) || !keeps_borders(u, v)) return false;
  const double size_u = 2.0 / u + 2 * kUnit, size_v = 2.0 / v + 2 * kUnit;
  const auto region = [&](int a, int b, int over_u, int over_v) {
    const auto from = [](int i, int n) { return std::max(0.0, 2.0 * i / n - kUnit); };
    const auto to = [](int i, int n) { return std::min(2.0, 2.0 * i / n + kUnit); };
    return Region{from(a, u), from(b, v), to(a + over_u, u), to(b + over_v, v)};
  };
  for (int b = 0; b < v; ++b) {
    for (int a = 0; a < u; ++a) {
      const bool beside_v = b == 0 || b == v - 1, beside_u = a == 0 || a == u - 1;
      const bool wide = beside_v && u > 1, high = beside_u && v > 1;
      if (wide && a + 1 < u && !keeps_in(region(a, b, 2, 1), size_u, size_v)) return false;
      if (high && b + 1 < v && !keeps_in(region(a, b, 1, 2), size_u, size_v)) return false;
      if (!wide && !high && !keeps_in(region(a, b, 1, 1), size_u, size_v)) return false;
    }
  }
  return true;
}

FaceGrid GridFinder::find(std::int32_t face, const Limits& limits) {
  limits_ = limits;
  if (std::ranges::any_of(limits_.borders, [](bool border) { return border; }))
    limits_.distance *= std::sqrt(0.5);  // off along the surface as well as across it
  if (!take_nets(face) || !stands_alone(surface_.topology(), face)) return {};
  if (keeps(1, 1)) return {1, 1};
  if (limits.turn > 0) return {};
  int even = 2;
  const int most = std::min(kMostParts, limits.most);
  while (even <= most && !keeps(even, even)) ++even;
  if (even > most) return {};
  FaceGrid best;
  int fewest = limits.most + 1;
  const auto take = [&](int u, int v) {
    if (u * v >= fewest) return;
    fewest = u * v;
    best = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v)};
  };
  take(even, even);
  // From as many both ways to more one way, then the other.
  for (const bool along_u : {true, false}) {
    int less = even;
    for (int more = even; more <= most && less > 1; ++more) {
      const auto keeps_with = [&](int n) { return along_u ? keeps(more, n) : keeps(n, more); };
      while (less > 1 && keeps_with(less - 1)) {
        --less;
        take(along_u ? more : less, along_u ? less : more);
      }
    }
  }
  return best;
}

}  // namespace planish
