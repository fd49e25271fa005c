#include "planish/limit/cell_splitter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <string>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/unit_vector.h"
#include "planish/patches/quarter_turn.h"

namespace planish {
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

}  // namespace planish
