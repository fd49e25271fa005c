#include "planish/brep/freeform_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

namespace planish {
namespace {

constexpr const char* kNoBorder = "its freeform faces do not end where those on its surfaces begin";

double parameter_in(const FreeSpan& span, double behind) {
  return span.from < span.to ? span.from + behind : span.from - behind;
}

}  // namespace

FreeformSide::FreeformSide(const FreeformFaces& freeform, const Placement& placement,
                           std::span<const std::int32_t> faces, std::int32_t first, Brep& part)
    : freeform_(freeform), placement_(placement), faces_(faces), part_(part) {
  for (const std::int32_t f : faces) number_[f] = first++;
}

const AnalyticSurface* FreeformSide::MovedEdge::surface_at(double t) const {
  for (const Beside& of : beside)
    if (t >= of.low && t <= of.high) return of.surface;
  return nullptr;
}

std::int32_t FreeformSide::add_vertex(const glm::dvec3& point) {
  part_.vertices.push_back(point);
  return static_cast<std::int32_t>(part_.vertices.size()) - 1;
}

glm::dvec3 FreeformSide::given_point(std::int32_t edge, double t) const {
  return placement_.to_unit(point_of(freeform_.brep, freeform_.brep.edges[edge], t));
}

std::optional<std::int32_t> FreeformSide::end_of(std::int32_t edge, double t) const {
  const Brep::Edge& of = freeform_.brep.edges[edge];
  if (t == 0) return of.from;
  if (t == of.knots.back()) return of.to;
  return std::nullopt;
}

std::int32_t FreeformSide::vertex_at(std::int32_t edge, double t, const AnalyticSurface& surface) {
  const auto end = end_of(edge, t);
  if (!end) throw NotAnalytic{kNoBorder};
  const auto known = vertex_of_.find(*end);
  if (known != vertex_of_.end()) return known->second;
  return add_vertex(nearest_point(surface, given_point(edge, t)));
}

std::vector<FreeformSide::Split> FreeformSide::add_chain(std::int32_t chain,
                                                         const AnalyticSurface& surface,
                                                         std::int32_t from, std::int32_t to) {
  Chain& own = chains_[chain];
  own.spans = freeform_.spans[chain];
  if (own.spans.empty()) throw NotAnalytic{kNoBorder};
  std::vector<Split> splits;
  own.places.push_back(0);
  for (std::size_t i = 0; i < own.spans.size(); ++i) {
    const FreeSpan& span = own.spans[i];
    const bool is_first = i == 0 && from >= 0, is_last = i + 1 == own.spans.size() && to >= 0;
    const auto mark = [&](double at, std::int32_t given) {
      const std::int32_t vertex = given >= 0 ? given : vertex_at(span.edge, at, surface);
      edges_[span.edge].marks.push_back({at, vertex});
      if (const auto end = end_of(span.edge, at)) vertex_of_[*end] = vertex;
      return vertex;
    };
    const std::int32_t begin = mark(span.from, is_first ? from : -1);
    mark(span.to, is_last ? to : -1);
    edges_[span.edge].beside.push_back(
        {std::min(span.from, span.to), std::max(span.from, span.to), &surface});
    if (!is_first) splits.push_back({own.places.back(), begin});
    own.places.push_back(own.places.back() + std::abs(span.to - span.from));
  }
  return splits;
}

void FreeformSide::move_borders() {
  constexpr double kOnBoth = 1e-8;  // of the diagonal: well within what is one place
  for (auto& [e, moved] : edges_) {
    const std::int32_t edge = e;
    const MovedEdge& of = moved;
    std::vector<double> knots = freeform_.brep.edges[edge].knots;
    std::vector<std::pair<double, glm::dvec3>> shifts;  // two spans may share a mark
    for (const MovedEdge::Mark& mark : of.marks) {
      if (std::ranges::count(shifts, mark.at, &std::pair<double, glm::dvec3>::first) > 0) continue;
      add_fading_knots(mark.at, knots);
      shifts.emplace_back(mark.at,
                          part_.vertices[mark.vertex] -
                              nearest_point(*of.surface_at(mark.at), given_point(edge, mark.at)));
    }
    const auto target = [&](double t) {
      glm::dvec3 p = given_point(edge, t);
      const AnalyticSurface* const surface = of.surface_at(t);
      if (surface == nullptr) return p;
      p = nearest_point(*surface, p);
      for (const auto& [at, shift] : shifts) p += fading(t - at) * shift;
      return nearest_point(*surface, p);
    };
    auto curve = curve_near(std::move(knots), target, kOnBoth);
    if (!curve) throw NotAnalytic{"its freeform faces meet its surfaces along no smooth curve"};
    moved.curve = std::move(*curve);
  }
}

FreeformSide::SpanPlace FreeformSide::span_at(std::int32_t chain, double place,
                                              bool is_second) const {
  const Chain& of = chains_.at(chain);
  const auto begin = of.places.begin() + 1, end = of.places.end() - 1;
  const auto above =
      is_second ? std::upper_bound(begin, end, place) : std::lower_bound(begin, end, place);
  const auto index = static_cast<std::size_t>(above - of.places.begin()) - 1;
  return {of.spans[index], parameter_in(of.spans[index], place - of.places[index])};
}

glm::dvec3 FreeformSide::point(std::int32_t chain, double place) const {
  const SpanPlace at = span_at(chain, place, true);
  return edges_.at(at.span.edge).curve.at(at.parameter);
}

std::int32_t FreeformSide::add_edge(std::int32_t chain, const Split& from, const Split& to,
                                    std::int32_t face) {
  const SpanPlace begin = span_at(chain, from.place, true), end = span_at(chain, to.place, false);
  const std::int32_t old_edge = begin.span.edge;
  const double low = begin.parameter, high = end.parameter;
  MovedEdge& moved = edges_.at(old_edge);
  QuadraticCurve curve = moved.curve.part(low, high);
  Brep::Edge edge;
  edge.from = from.vertex;
  edge.to = to.vertex;
  edge.knots = std::move(curve.knots);
  edge.points = std::move(curve.points);
  edge.points.front() = part_.vertices[edge.from];
  edge.points.back() = part_.vertices[edge.to];
  edge.lines[0].face = face;
  const Brep::Edge& old = freeform_.brep.edges[old_edge];
  const Brep::Line& line = old.lines[number_.contains(old.lines[0].face) ? 0 : 1];
  edge.lines[1] = {number_.at(line.face), line.from + low * unit_direction(line.direction),
                   low < high ? line.direction : (line.direction + 2) % 4};
  const auto number = static_cast<std::int32_t>(part_.edges.size());
  moved.pieces.push_back({std::min(low, high), {number, low > high}});
  part_.edges.push_back(std::move(edge));
  return number;
}

std::int32_t FreeformSide::vertex_of(std::int32_t vertex) {
  const auto [at, is_new] = vertex_of_.try_emplace(vertex, -1);
  if (is_new) at->second = add_vertex(placement_.to_unit(freeform_.brep.vertices[vertex]));
  return at->second;
}

glm::dvec3 FreeformSide::shift_of(std::int32_t vertex) const {
  return part_.vertices[vertex_of_.at(vertex)] -
         placement_.to_unit(freeform_.brep.vertices[vertex]);
}

bool FreeformSide::stays(std::int32_t edge) const {
  const Brep::Edge& old = freeform_.brep.edges[edge];
  return edges_.at(edge).marks.empty() && shift_of(old.from) == glm::dvec3(0.0) &&
         shift_of(old.to) == glm::dvec3(0.0);
}

// Edges at vertices that have moved follow.
void FreeformSide::add_inner_edges() {
  const Brep& brep = freeform_.brep;
  std::vector<std::int32_t> own;
  for (const std::int32_t f : faces_)
    for (const Brep::Use& use : brep.faces[f].loop) own.push_back(use.edge);
  std::ranges::sort(own);
  own.erase(std::ranges::unique(own).begin(), own.end());
  for (const std::int32_t e : own) {
    if (edges_.contains(e)) continue;
    const Brep::Edge& old = brep.edges[e];
    for (const Brep::Line& line : old.lines)
      if (line.face >= 0 && !number_.contains(line.face)) throw NotAnalytic{kNoBorder};
    Brep::Edge edge;
    edge.from = vertex_of(old.from);
    edge.to = vertex_of(old.to);
    edge.lines = old.lines;
    for (Brep::Line& line : edge.lines)
      if (line.face >= 0) line.face = number_.at(line.face);
    const glm::dvec3 first = shift_of(old.from), second = shift_of(old.to);
    const double last = old.knots.back();
    MovedEdge& moved = edges_[e];
    moved.curve.knots = old.knots;
    if (first != glm::dvec3(0.0)) add_fading_knots(0, moved.curve.knots);
    if (second != glm::dvec3(0.0)) add_fading_knots(last, moved.curve.knots);
    moved.curve.points = quadratic_points(moved.curve.knots, [&](double t) {
      return given_point(e, t) + fading(t) * first + fading(last - t) * second;
    });
    edge.knots = moved.curve.knots;
    edge.points = moved.curve.points;
    edge.points.front() = part_.vertices[edge.from];
    edge.points.back() = part_.vertices[edge.to];
    moved.pieces.push_back({0, {static_cast<std::int32_t>(part_.edges.size()), false}});
    part_.edges.push_back(std::move(edge));
  }
  for (auto& [e, moved] : edges_)
    std::ranges::sort(moved.pieces, std::less<>(), &MovedEdge::Piece::low);
}

void FreeformSide::add_face(std::int32_t index) {
  const Brep::Face& old = freeform_.brep.faces[index];
  Brep::Face face = old;
  for (glm::dvec3& p : face.points) p = placement_.to_unit(p);
  face.loop.clear();
  // Edges of each side that move, in the face's parameter along it.
  struct Along {
    double low = 0, high = 0, from = 0, sign = 1;
    std::int32_t edge = 0;
  };
  std::array<std::vector<Along>, 4> along;
  std::array<MovedSide, 4> sides;
  for (const Brep::Use& use : old.loop) {
    const MovedEdge& moved = edges_.at(use.edge);
    for (std::size_t i = 0; i < moved.pieces.size(); ++i) {
      const Brep::Use& piece = moved.pieces[use.is_reversed ? moved.pieces.size() - 1 - i : i].use;
      face.loop.push_back({piece.edge, piece.is_reversed != use.is_reversed});
    }
    if (stays(use.edge)) continue;
    const Brep::Line& line = freeform_.brep.edges[use.edge].lines[use.is_reversed ? 1 : 0];
    const int side = use.is_reversed ? (line.direction + 2) % 4 : line.direction;
    const double from = side % 2 == 0 ? line.from.x : line.from.y,
                 sign = line.direction < 2 ? 1 : -1, to = from + sign * moved.curve.knots.back();
    for (const double t : moved.curve.knots) sides[side].knots.push_back(from + sign * t);
    along[side].push_back({std::min(from, to), std::max(from, to), from, sign, use.edge});
  }
  for (std::size_t s = 0; s < sides.size(); ++s) {
    if (along[s].empty()) continue;
    sides[s].shift = [this, &edges = along[s]](double at) {
      const auto found = std::ranges::find_if(
          edges, [&](const Along& edge) { return at >= edge.low && at <= edge.high; });
      if (found == edges.end()) return glm::dvec3(0.0);
      const double t = found->sign * (at - found->from);
      return edges_.at(found->edge).curve.at(t) - given_point(found->edge, t);
    };
  }
  if (std::ranges::any_of(sides, [](const MovedSide& side) { return !side.knots.empty(); }))
    move_sides(part_, sides, face);
  part_.faces.push_back(std::move(face));
}

void FreeformSide::add_faces() {
  add_inner_edges();
  for (const std::int32_t f : faces_) add_face(f);
}

}  // namespace planish
