#include "planish/adaptive/adaptive_cells.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/patches/bezier_net.h"

namespace planish {
namespace {

// Beyond it a piece is no height field worth the name.
constexpr double kLeastCosine = 0.3;

// The mean direction and the least cosine to it; below 0 where there is none.
struct Cone {
  glm::dvec3 axis{0.0};
  double cosine = -1;
};

Cone cone_of(std::span<const glm::dvec3> directions) {
  Cone cone;
  for (const glm::dvec3& d : directions) cone.axis += d;
  const double length = glm::length(cone.axis);
  if (!(length > 0)) return cone;
  cone.axis /= length;
  double least = 1;
  for (const glm::dvec3& d : directions) {
    const double size = glm::length(d);
    if (!(size > 0)) return cone;
    least = std::min(least, glm::dot(d, cone.axis) / size);
  }
  cone.cosine = least;
  return cone;
}

// Between any two of its directions.
double turn_of(const Cone& cone) {
  return cone.cosine > 0 ? 2 * portable::acos(std::min(cone.cosine, 1.0)) : std::numbers::pi;
}

double slope(double cosine) { return std::sqrt(std::max(0.0, 1 - cosine * cosine)) / cosine; }

// The largest of some second derivatives: whole, along the cone's axis each way, and across it.
struct Largest {
  double whole = 0, up = 0, down = 0, across = 0;

  void add(const glm::dvec3& d, const glm::dvec3& axis) {
    const double height = glm::dot(d, axis);
    whole = std::max(whole, glm::length(d));
    up = std::max(up, height);
    down = std::max(down, -height);
    across = std::max(across, glm::length(d - height * axis));
  }
  [[nodiscard]] double along() const { return std::max(up, down); }
};

}  // namespace

void add_normals(const BezierNet& net, std::span<glm::dvec3, 36> normals) {
  std::size_t at = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const glm::dvec3 du = net[3 * j + i + 1] - net[3 * j + i];
      for (std::size_t l = 0; l < 2; ++l) {
        for (std::size_t k = 0; k < 3; ++k)
          normals[at++] = glm::cross(du, net[3 * (l + 1) + k] - net[3 * l + k]);
      }
    }
  }
}

double spread_of(std::span<const glm::dvec3> directions) { return turn_of(cone_of(directions)); }

CellBound bound_of(const BezierNet& net) {
  const BoundPiece piece{net, 1, 1};
  return bound_of(std::span(&piece, 1));
}

CellBound bound_of(std::span<const BoundPiece> pieces) {
  std::array<glm::dvec3, 36 * kMostPieces> normals;
  std::size_t count = 0;
  for (const BoundPiece& piece : pieces) {
    add_normals(piece.net, std::span(normals).subspan(count).first<36>());
    count += 36;
  }
  const Cone cone = cone_of(std::span(normals).first(count));
  Largest uu, uv, vv;
  for (const auto& [net, u, v] : pieces) {
    for (std::size_t k = 0; k < 3; ++k) {
      uu.add(u * u * 2.0 * (net[3 * k] - 2.0 * net[3 * k + 1] + net[3 * k + 2]), cone.axis);
      vv.add(v * v * 2.0 * (net[k] - 2.0 * net[k + 3] + net[k + 6]), cone.axis);
    }
    for (const std::size_t k : {0, 1, 3, 4})
      uv.add(u * v * 4.0 * (net[k + 4] - net[k + 3] - net[k + 1] + net[k]), cone.axis);
  }
  CellBound bound;
  bound.distance = (uu.whole + 2 * uv.whole + vv.whole) / 8;
  bound.turn = turn_of(cone);
  bound.by_uu = uu.whole / 8;
  bound.by_vv = vv.whole / 8;
  if (cone.cosine > kLeastCosine) {
    const double steep = slope(cone.cosine);
    // Where u and v are curved against one another, what they are off by is too.
    const double height = (std::max(uu.up + vv.up, uu.down + vv.down) + 2 * uv.along()) / 8;
    // So far along the surface, which rises by no more than its slope on the way.
    const double aside = (uu.across + 2 * uv.across + vv.across) / 8;
    const double with_slope = height + steep * aside;
    if (with_slope < bound.distance) {
      bound.distance = with_slope;
      bound.by_uu = uu.along() / 8;
      bound.by_vv = vv.along() / 8;
    }
  }
  bound.u_is_worse = bound.by_uu > bound.by_vv;
  return bound;
}

double curve_bound(std::span<const BezierCurve> curves) {
  std::array<glm::dvec3, 4> tangents;
  PLANISH_ASSERT(2 * curves.size() <= tangents.size());
  std::size_t count = 0;
  for (const auto& [a, b, c] : curves) {
    tangents[count++] = b - a;
    tangents[count++] = c - b;
  }
  const Cone cone = cone_of(std::span(tangents).first(count));
  double bound = 0;
  for (const auto& [a, b, c] : curves) {
    const glm::dvec3 second = 2.0 * (a - 2.0 * b + c) / 8.0;
    const double whole = glm::length(second);
    double of_curve = whole;
    if (cone.cosine > kLeastCosine) {
      const double along = glm::dot(second, cone.axis);
      const double across = glm::length(second - along * cone.axis);
      of_curve = std::min(whole, across + slope(cone.cosine) * std::abs(along));
    }
    bound = std::max(bound, of_curve);
  }
  return bound;
}

CellBound hull_bound(std::span<const glm::dvec3> points, std::span<const glm::dvec3> normals,
                     double aside) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Cone cone = cone_of(normals);
  glm::dvec3 low(kFar), high(-kFar);
  double lowest = kFar, highest = -kFar;
  for (const glm::dvec3& p : points) {
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], p[d]);
      high[d] = std::max(high[d], p[d]);
    }
    const double height = glm::dot(p, cone.axis);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  CellBound bound{.distance = glm::length(high - low), .turn = turn_of(cone)};
  if (!(glm::dot(cone.axis, cone.axis) > 0.5)) return bound;
  // Surface and triangles are both within the slab. What of the surface is beside the triangles is
  // over those of the neighbours, which begin at the same chords and rise by no more than its
  // slope.
  const double steep = slope(std::max(cone.cosine, kLeastCosine));
  bound.distance = std::min(bound.distance, highest - lowest + steep * aside);
  return bound;
}

namespace {

constexpr std::size_t kCornersTogether = 256;
// Cells turn with the surface, whose piece is seen along one normal here: so much less may do. And
// one cell may take in four corners.
constexpr double kSurelyNeeded = 0.25;

// Of a polynomial. A cell of a by b of its square is accepted where a^2 |S_uu| / 8 and
// b^2 |S_vv| / 8, along the normal, are within the distance; the least of each counts.
double cells_of_net(const BezierNet& net, double distance) {
  const glm::dvec3 across =
      glm::cross(net[2] - net[0] + net[8] - net[6], net[6] - net[0] + net[8] - net[2]);
  const double length = glm::length(across);
  if (!(length > 0)) return kSurelyNeeded;
  const glm::dvec3 normal = across / length;
  double uu = HUGE_VAL, vv = HUGE_VAL;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto second = [&](std::size_t a, std::size_t b, std::size_t c) {
      return std::abs(2 * glm::dot(net[a] - 2.0 * net[b] + net[c], normal));
    };
    uu = std::min(uu, second(3 * k, 3 * k + 1, 3 * k + 2));
    vv = std::min(vv, second(k, k + 3, k + 6));
  }
  const auto parts = [&](double value) { return std::max(1.0, std::sqrt(value / 8 / distance)); };
  return kSurelyNeeded * parts(uu) * parts(vv);
}

}  // namespace

double fewest_cells(const LimitSurface& surface, std::span<const std::uint8_t> hidden,
                    double distance) {
  const auto count = static_cast<std::size_t>(surface.topology().corner_count());
  std::vector<double> of_block((count + kCornersTogether - 1) / kCornersTogether, 0.0);
  parallel_for(of_block.size(), 1, [&](std::size_t begin, std::size_t end) {
    LimitSurface::Corner corner(surface);
    std::vector<glm::dvec3> points;
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t last = std::min(count, (b + 1) * kCornersTogether);
      for (std::size_t c = b * kCornersTogether; c < last; ++c) {
        if (hidden[c] != 0) continue;
        corner.move_to(static_cast<std::int32_t>(c));
        const PatchForm& form = corner.form();
        if (form.is_polynomial()) {
          of_block[b] += cells_of_net(bezier_net(form, corner.points()), distance);
          continue;
        }
        // A corner may be one cell: quarters count where they are more.
        double quarters = 0;
        for (int q = 0; q < 4; ++q) {
          const PatchForm& quarter = *form.quarters[q];
          if (!quarter.is_polynomial()) continue;
          quarter_points(form, q, corner.points(), points);
          const BezierNet net = bezier_net(quarter, points);
          quarters += std::max(0.0, cells_of_net(net, distance) - 1);
        }
        of_block[b] += 1 + quarters;
      }
    }
  });
  double sum = 0;
  for (const double cells : of_block) sum += cells;
  return sum;
}

namespace {

// Where a surface folds its normals turn however small a cell is: no side becomes shorter for them.
// Where it only bends, which is sure of normals within a right angle, each halving helps: most
// needles are followed to their tips by then, and whole faces of noise take no more than memory.
constexpr int kMostFoldHalvings = 7, kMostBendHalvings = 10;
constexpr double kSurelyBends = std::numbers::pi / 2;
std::int32_t least_turn_side(const CellBound& bound) {
  return kCellSide >> (bound.turn < kSurelyBends ? kMostBendHalvings : kMostFoldHalvings);
}
// A side so many times as long as the other is split first, so that triangles do not get longer
// than what the surface is curved along asks for.
constexpr double kLongest = 8;
// Triangles beside a border are off along the surface as well as across it.
const double kBorderShare = std::sqrt(0.5);

// Part `part` of so many along u or v.
BezierNet part_of_net(const BezierNet& net, bool along_v, int part, int parts) {
  if (parts == 1) return net;
  return net_between(net, along_v, static_cast<double>(part) / parts,
                     static_cast<double>(part + 1) / parts);
}

AdaptiveCell part_of_cell(const AdaptiveCell& cell, int a, int parts_u, int b, int parts_v) {
  const std::int32_t u = cell.size_u() / parts_u, v = cell.size_v() / parts_v;
  const auto place = [](std::int32_t value) { return static_cast<std::uint16_t>(value); };
  return {place(cell.u + a * u), place(cell.v + b * v), place(cell.u + (a + 1) * u),
          place(cell.v + (b + 1) * v)};
}

// Which quarter of a cell a piece's own quarter is.
AdaptiveCell quarter_cell(const AdaptiveCell& cell, int quarter, int turns) {
  const auto [a, b] = seen_from((8 - quarter - turns) % 4, 1, 0, 0);
  return part_of_cell(cell, a, 2, b, 2);
}

// Of what is left around a vertex: normals change there ever less.
constexpr int kInnerHalvings = 3;

// Points whose hull holds a patch. Where weights are negative it leaves the hull of its control
// points, by no more than their reach about any middle.
void add_hull(std::span<const glm::dvec3> points, double reach, std::vector<glm::dvec3>& hull) {
  constexpr double kNone = 1 + 1e-9;
  if (reach <= kNone) {
    hull.insert(hull.end(), points.begin(), points.end());
    return;
  }
  glm::dvec3 middle(0.0);
  for (const glm::dvec3& p : points) middle += p / static_cast<double>(points.size());
  for (const glm::dvec3& p : points) {
    hull.push_back(middle + reach * (p - middle));
    hull.push_back(middle - reach * (p - middle));
  }
}

// Of a patch that is no polynomial, as far as polynomials around its vertex tell: what a few
// halvings lead to.
void add_inner_normals(const PatchForm& form, std::span<const glm::dvec3> points, int halvings,
                       std::vector<glm::dvec3>& normals) {
  if (form.is_polynomial()) {
    std::array<glm::dvec3, 36> products;
    add_normals(bezier_net(form, points), products);
    normals.insert(normals.end(), products.begin(), products.end());
    return;
  }
  if (halvings == 0) return;
  std::vector<glm::dvec3> inner;
  for (int q = 0; q < 4; ++q) {
    quarter_points(form, q, points, inner);
    add_inner_normals(*form.quarters[q], inner, halvings - 1, normals);
  }
}

// The quarters of a patch that is no polynomial: what polynomials there are, and the points of the
// others.
struct Quarters {
  std::array<BezierNet, 4> nets;
  std::array<std::vector<glm::dvec3>, 4> points;
};

}  // namespace

void refuse_count(std::uint64_t most) {
  throw Error(ErrorCode::OutOfMemory,
              formatted("the tessellation has more than {} cells, which is all that memory and "
                        "32-bit indices take; allow a larger chord error or angle",
                        most));
}

bool CellSplitter::is_on_border(const AdaptiveCell& cell) const {
  return (borders_.leading && cell.v == 0) || (borders_.trailing && cell.u == 0);
}

double CellSplitter::limit_at(const AdaptiveCell& cell) const {
  return is_on_border(cell) ? kBorderShare * limits_.distance : limits_.distance;
}

void CellSplitter::refuse_depth() const {
  throw Error(ErrorCode::InvalidArgument,
              formatted("the surface at corner {} keeps a chord error of {} of the diagonal only "
                        "in cells below 2^-{} of half an edge; allow a larger one",
                        number_, shortest(limits_.distance), kMaxHalvings));
}

void CellSplitter::emit(const AdaptiveCell& cell) {
  if (cells_->size() >= most_) refuse_count(most_);
  cells_->push_back(cell);
}

// Of the cell's sides that are borders, which are one polynomial each: known from three points.
double CellSplitter::border_bound(const AdaptiveCell& cell) {
  double largest = 0;
  const auto add = [&](double u0, double v0, double u1, double v1) {
    const glm::dvec3 a = corner_.at({u0, v0}).position, c = corner_.at({u1, v1}).position;
    const glm::dvec3 middle = corner_.at({0.5 * (u0 + u1), 0.5 * (v0 + v1)}).position;
    const BezierCurve curve{a, 2.0 * middle - 0.5 * (a + c), c};
    largest = std::max(largest, curve_bound(std::span(&curve, 1)));
  };
  const double u0 = double(cell.u) / kCellSide, u1 = double(cell.end_u) / kCellSide;
  const double v0 = double(cell.v) / kCellSide, v1 = double(cell.end_v) / kCellSide;
  if (borders_.leading && cell.v == 0) add(u0, 0, u1, 0);
  if (borders_.trailing && cell.u == 0) add(0, v0, 0, v1);
  return largest;
}

// How far the cell's sides leave their chords, by their middles.
double CellSplitter::sides_aside(const AdaptiveCell& cell) {
  // The cell's places at its ends and middles: 0, 1, 2 along each side.
  const auto at = [&](int i, int j) {
    return corner_
        .at({(cell.u + 0.5 * i * cell.size_u()) / kCellSide,
             (cell.v + 0.5 * j * cell.size_v()) / kCellSide})
        .position;
  };
  const std::array<glm::dvec3, 8> around{at(0, 0), at(1, 0), at(2, 0), at(2, 1),
                                         at(2, 2), at(1, 2), at(0, 2), at(0, 1)};
  double largest = 0;
  for (std::size_t i = 1; i < 8; i += 2) {
    // Along a chord it does not matter where its middle lies: beside vertices of valence 2 far off.
    const glm::dvec3 chord = around[(i + 1) % 8] - around[i - 1],
                     offset = around[i] - around[i - 1];
    const double square = glm::dot(chord, chord);
    const double along = square > 0 ? std::clamp(glm::dot(offset, chord) / square, 0.0, 1.0) : 0.0;
    largest = std::max(largest, glm::distance(offset, along * chord));
  }
  return largest;
}

bool CellSplitter::keeps(const CellBound& bound, const AdaptiveCell& cell) const {
  const double limit = limit_at(cell);
  if (limit > 0 && !(bound.distance <= limit)) return false;
  const bool is_small = std::max(cell.size_u(), cell.size_v()) <= least_turn_side(bound);
  return limits_.turn == 0 || bound.turn <= limits_.turn || is_small;
}

// The fewest parts of two and three along a side that all keep the limits; none where that takes
// more.
CellSplitter::Split CellSplitter::fewest_parts(const BezierNet& net, const CellBound& bound,
                                               const AdaptiveCell& cell) const {
  constexpr Split kBySize[] = {{1, 2}, {2, 1}, {1, 3}, {3, 1}, {2, 2}, {2, 3}, {3, 2}, {3, 3}};
  const double limit = limit_at(cell);
  if (!(limit > 0)) return {0, 0};
  for (const Split& split : kBySize) {
    if (cell.size_u() % split.u != 0 || cell.size_v() % split.v != 0) continue;
    if (!(bound.distance_in(split.u, split.v) <= limit)) continue;
    bool all_keep = true;
    for (int b = 0; b < split.v && all_keep; ++b) {
      const BezierNet row = part_of_net(net, true, b, split.v);
      for (int a = 0; a < split.u && all_keep; ++a)
        all_keep = keeps(bound_of(part_of_net(row, false, a, split.u)),
                         part_of_cell(cell, a, split.u, b, split.v));
    }
    if (all_keep) return split;
  }
  return {0, 0};
}

// The fewest parts that will keep the limits; else halves along the side that is worse.
CellSplitter::Split CellSplitter::split_of(const BezierNet& net, const AdaptiveCell& cell) const {
  const auto halves = [&](bool along_u) { return along_u ? Split{2, 1} : Split{1, 2}; };
  if (limits_.distance > 0) {
    const double limit = kBorderShare * limits_.distance;
    const auto is_far = [&](const BezierCurve& curve) {
      return !(curve_bound(std::span(&curve, 1)) <= limit);
    };
    if (borders_.leading && cell.v == 0 && is_far({net[0], net[1], net[2]})) return halves(true);
    if (borders_.trailing && cell.u == 0 && is_far({net[0], net[3], net[6]})) return halves(false);
  }
  const CellBound bound = bound_of(net);
  if (keeps(bound, cell)) return {};
  const Split best = fewest_parts(net, bound, cell);
  const double along_u = std::max(glm::length(net[2] - net[0]), glm::length(net[8] - net[6]));
  const double along_v = std::max(glm::length(net[6] - net[0]), glm::length(net[8] - net[2]));
  const bool is_slim = std::max(along_u * best.v, along_v * best.u) >
                       kLongest * std::min(along_u * best.v, along_v * best.u);
  if (best.u > 0 && !is_slim) return best;
  bool across_u = bound.u_is_worse;
  if (along_v > kLongest * along_u) across_u = false;
  if (along_u > kLongest * along_v) across_u = true;
  // What only turns too much is not cut below the least side, but along the other.
  const bool is_near = !(limits_.distance > 0) || bound.distance <= limit_at(cell);
  if (is_near && (across_u ? cell.size_u() : cell.size_v()) <= least_turn_side(bound))
    across_u = !across_u;
  return halves(across_u);
}

void CellSplitter::split_net(const BezierNet& net, const AdaptiveCell& cell) {
  Split split = split_of(net, cell);
  if (split.u == 1 && split.v == 1) {
    emit(cell);
    return;
  }
  const auto possible = [&](int parts, std::int32_t size) {
    if (parts == 1 || size % parts == 0) return parts;
    if (size != 3) refuse_depth();
    return 3;
  };
  split = {possible(split.u, cell.size_u()), possible(split.v, cell.size_v())};
  for (int b = 0; b < split.v; ++b) {
    const BezierNet row = part_of_net(net, true, b, split.v);
    for (int a = 0; a < split.u; ++a)
      split_net(part_of_net(row, false, a, split.u), part_of_cell(cell, a, split.u, b, split.v));
  }
}

void CellSplitter::split_form(const PatchForm& form, std::span<const glm::dvec3> points, int turns,
                              const AdaptiveCell& cell) {
  if (form.is_polynomial()) {
    split_net(turned_net(bezier_net(form, points), turns), cell);
    return;
  }
  Quarters quarters;
  std::vector<glm::dvec3> hull, normals;
  for (int q = 0; q < 4; ++q) {
    const PatchForm& inner = *form.quarters[q];
    auto& of_quarter = quarters.points[q];
    quarter_points(form, q, points, of_quarter);
    if (inner.is_polynomial()) {
      BezierNet& net = quarters.nets[q];
      net = bezier_net(inner, of_quarter);
      hull.insert(hull.end(), net.begin(), net.end());
      std::array<glm::dvec3, 36> products;
      add_normals(net, products);
      normals.insert(normals.end(), products.begin(), products.end());
      continue;
    }
    add_hull(of_quarter, reaches_.of(inner), hull);
    if (limits_.turn > 0) add_inner_normals(inner, of_quarter, kInnerHalvings, normals);
  }
  CellBound bound = hull_bound(hull, normals, sides_aside(cell));
  if (is_on_border(cell) && limits_.distance > 0)
    bound.distance = std::max(bound.distance, border_bound(cell));
  if (keeps(bound, cell)) {
    emit(cell);
    return;
  }
  if (cell.size_u() % 2 != 0) refuse_depth();
  for (int q = 0; q < 4; ++q) {
    const auto at = static_cast<std::size_t>(q);
    const PatchForm& inner = *form.quarters[at];
    const AdaptiveCell part = quarter_cell(cell, q, turns);
    const int inner_turns = (turns + q) % 4;
    if (inner.is_polynomial()) {
      split_net(turned_net(quarters.nets[at], inner_turns), part);
    } else {
      split_form(inner, quarters.points[at], inner_turns, part);
    }
  }
}

void CellSplitter::run(std::int32_t corner, const CornerBorders& borders,
                       std::vector<AdaptiveCell>& cells) {
  corner_.move_to(corner);
  number_ = corner;
  borders_ = borders;
  cells_ = &cells;
  split_form(corner_.form(), corner_.points(), 0, {0, 0, kCellSide, kCellSide});
}

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
  constexpr double kSlim = 8;
  const double a = length_u_ / u, b = length_v_ / v;
  const auto ratio = [](double s, double t) { return std::max(s, t) / std::min(s, t); };
  return (u > 1 || v > 1) && ratio(a, b) > std::max(kSlim, ratio(length_u_, length_v_));
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

namespace {

// Faces a task: their cells are kept together until all are counted.
constexpr std::size_t kFaceGrain = 64;
// A grid has no places of neighbours on its sides that its own do not fit: so it may take this many
// times as many parts as there are cells.
constexpr double kGridShare = 1.1;
// What a cell takes with its share of vertices and triangles while a tessellation is made.
constexpr std::uint64_t kCellBytes = 150;
// Two triangles a cell and some beside finer ones; their corners are counted in 32 bits.
constexpr std::uint64_t kMostCells = std::uint64_t{1} << 28;

// Twice as much as would be refused, and two digits: what surely is enough.
std::string larger_error(double distance, double cells, std::uint64_t most) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", 2 * distance * cells / static_cast<double>(most));
  return text;
}

void require_count(double cells, const CellLimits& limits, std::uint64_t most) {
  if (!(cells > static_cast<double>(most))) return;
  char count[32];
  std::snprintf(count, sizeof count, "%.1e", 2 * cells);
  throw Error(ErrorCode::OutOfMemory,
              formatted("a chord error of {} of the diagonal takes at least {} triangles, but "
                        "memory and 32-bit indices take {}; allow an error of {} or more",
                        shortest(limits.distance), count, 2 * most,
                        larger_error(limits.distance, cells, most)));
}

// The cells of faces, one block of them after the other.
class FaceCells {
 public:
  FaceCells(const LimitSurface& surface, const CellLimits& limits, std::uint64_t most,
            const PatchReaches& reaches, AdaptiveCells& result)
      : surface_(surface),
        topology_(surface.topology()),
        limits_(limits),
        result_(result),
        splitter_(surface, reaches, limits, most),
        finder_(surface) {}

  // Appends a face's cells, and tells how many a corner has; or sets its grid.
  void run(std::int32_t face, std::vector<AdaptiveCell>& cells, std::span<std::int64_t> sizes) {
    const std::int32_t first = topology_.first_corner(face), size = topology_.face_size(face);
    const std::size_t before = cells.size();
    for (std::int32_t c = first; c < first + size; ++c) {
      const std::size_t start = cells.size();
      splitter_.run(c, {.leading = is_border(c), .trailing = is_border(topology_.prev(c))}, cells);
      sizes[c] = static_cast<std::int64_t>(cells.size() - start);
    }
    const FaceGrid grid = grid_of(face, cells.size() - before);
    if (!grid.exists()) return;
    result_.grids[face] = grid;
    cells.resize(before);
    std::ranges::fill(
        sizes.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size)), 0);
  }

 private:
  // Whether a corner's leading edge ends the surface or is sharp.
  [[nodiscard]] bool is_border(std::int32_t corner) const {
    const std::int32_t other = topology_.twin(corner);
    return other < 0 || result_.hidden[other] != 0 || surface_.surface().patches().is_sharp(corner);
  }
  [[nodiscard]] FaceGrid grid_of(std::int32_t face, std::size_t cells) {
    if (topology_.face_size(face) != 4) return {};
    GridFinder::Limits limits{.distance = limits_.distance, .turn = limits_.turn};
    for (std::int32_t i = 0; i < 4; ++i)
      limits.borders[i] = is_border(topology_.first_corner(face) + i);
    limits.most = static_cast<int>(std::min(kGridShare * static_cast<double>(cells), 1e6));
    return finder_.find(face, limits);
  }

  const LimitSurface& surface_;
  const MeshTopology& topology_;
  const CellLimits& limits_;
  AdaptiveCells& result_;
  CellSplitter splitter_;
  GridFinder finder_;
};

std::vector<std::uint8_t> hidden_corners(const LimitSurface& surface) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::uint8_t> faces = surface.surface().hidden();
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(topology.corner_count()), 0);
  for (std::size_t c = 0; c < hidden.size() && !faces.empty(); ++c)
    hidden[c] = faces[topology.face_of(static_cast<std::int32_t>(c))];
  return hidden;
}

}  // namespace

AdaptiveCells make_cells(const LimitSurface& surface, const CellLimits& limits,
                         std::uint64_t memory_limit_bytes, const Callbacks& callbacks) {
  const MeshTopology& topology = surface.topology();
  const auto count = static_cast<std::size_t>(topology.face_count());
  AdaptiveCells result;
  result.hidden = hidden_corners(surface);
  result.grids.resize(count);
  PatchReaches reaches;
  for (const PatchForm* form : surface.forms()) reaches.add(*form);
  const std::size_t blocks = (count + kFaceGrain - 1) / kFaceGrain;
  std::vector<std::vector<AdaptiveCell>> of_block(blocks);
  std::vector<std::int64_t> sizes(result.hidden.size(), 0);
  const std::uint64_t most = std::min(memory_limit_bytes / kCellBytes, kMostCells);
  // Before cells are made: they would be as many as memory takes by the time that it is known.
  if (limits.distance > 0)
    require_count(fewest_cells(surface, result.hidden, limits.distance), limits, most);
  std::atomic<std::uint64_t> total{0};
  LoopProgress progress(callbacks, "evaluate", 0.1, 0.9, static_cast<std::int64_t>(blocks));
  parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end) {
    FaceCells faces(surface, limits, most, reaches, result);
    for (std::size_t b = begin; b < end; ++b) {
      std::vector<AdaptiveCell>& cells = of_block[b];
      for (std::size_t i = b * kFaceGrain; i < std::min(count, (b + 1) * kFaceGrain); ++i) {
        const auto face = static_cast<std::int32_t>(i);
        if (result.hidden[topology.first_corner(face)] != 0) continue;
        const std::size_t before = cells.size();
        faces.run(face, cells, sizes);
        const FaceGrid& grid = result.grids[i];
        const std::uint64_t more =
            cells.size() - before + static_cast<std::uint64_t>(grid.u) * grid.v;
        if (total.fetch_add(more) + more > most) refuse_count(most);
      }
      progress.add();
    }
  });
  result.first.assign(1, 0);
  for (const std::int64_t size : sizes) result.first.push_back(result.first.back() + size);
  result.cells.resize(static_cast<std::size_t>(result.first.back()));
  auto to = result.cells.begin();
  for (std::vector<AdaptiveCell>& cells : of_block) {
    to = std::copy(cells.begin(), cells.end(), to);
    cells = {};
  }
  return result;
}

}  // namespace planish
