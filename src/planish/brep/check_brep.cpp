#include "planish/brep/check_brep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {
namespace {

struct Gap {
  double distance = 0;
  glm::dvec3 at{};

  void add(double other, const glm::dvec3& there) {
    if (other <= distance) return;
    distance = std::isnan(other) ? std::numeric_limits<double>::infinity() : other;
    at = there;
  }
};

glm::dvec2 place_of(const Brep::Line& line, double t) {
  return line.from + t * unit_direction(line.direction);
}

// The parameters in which edge and face are one polynomial each.
std::vector<double> spans_of(const Brep::Edge& edge, const Brep::Face& face,
                             const Brep::Line& line) {
  std::vector<double> spans = edge.knots;
  const bool along_v = line.direction % 2 == 1;
  const glm::dvec2 unit = unit_direction(line.direction);
  for (const double knot : along_v ? face.knots_v : face.knots_u) {
    const double t = along_v ? (knot - line.from.y) * unit.y : (knot - line.from.x) * unit.x;
    if (t > edge.knots.front() && t < edge.knots.back()) spans.push_back(t);
  }
  std::ranges::sort(spans);
  const auto rest = std::ranges::unique(spans);
  spans.erase(rest.begin(), rest.end());
  return spans;
}

void add_gap(const Brep& brep, const Brep::Edge& edge, const Brep::Line& line, Gap& gap) {
  const Brep::Face& face = brep.faces[line.face];
  if (face.plane) {
    for (const glm::dvec3& p : edge.points)
      gap.add(std::abs(glm::dot(p - face.points.front(), face.plane->normal)), p);
    return;
  }
  // As many places as tell a polynomial, which between them is at most so many times larger
  // (Lebesgue's constant of equal steps, degrees 2 and 3).
  const double between = brep.degree == 2 ? 1.25 : 1.632;
  const std::vector<double> spans = spans_of(edge, face, line);
  for (std::size_t i = 0; i + 1 < spans.size(); ++i) {
    for (std::size_t k = i == 0 ? 0 : 1; k <= brep.degree; ++k) {
      const double part = static_cast<double>(k) / static_cast<double>(brep.degree),
                   t = k == brep.degree ? spans[i + 1]
                                        : spans[i] + part * (spans[i + 1] - spans[i]);
      const glm::dvec3 there = point_of(brep, edge, t);
      gap.add(between * glm::length(point_of(brep, face, place_of(line, t)) - there), there);
    }
  }
}

// Each use begins where the one before ends, at vertices and in parameters, and all of them enclose
// the whole rectangle on their left.
bool is_border(const Brep& brep, std::int32_t index) {
  const Brep::Face& face = brep.faces[index];
  const auto end = [&](std::size_t use, bool is_last) {
    const Brep::Use& u = face.loop[use % face.loop.size()];
    const Brep::Edge& edge = brep.edges[u.edge];
    const bool is_to = is_last != u.is_reversed;
    const Brep::Line& line = edge.lines[u.is_reversed ? 1 : 0];
    return std::pair{is_to ? edge.to : edge.from,
                     line.face == index
                         ? place_of(line, is_to ? edge.knots.back() : edge.knots.front())
                         : glm::dvec2(std::numeric_limits<double>::quiet_NaN())};
  };
  double area = 0;
  for (std::size_t i = 0; i < face.loop.size(); ++i) {
    const auto from = end(i, false), to = end(i, true);
    if (to != end(i + 1, false)) return false;
    area += 0.5 * (from.second.x * to.second.y - from.second.y * to.second.x);
    if (to.second.x < face.knots_u.front() || to.second.x > face.knots_u.back() ||
        to.second.y < face.knots_v.front() || to.second.y > face.knots_v.back())
      return false;
  }
  return area == (face.knots_u.back() - face.knots_u.front()) *
                     (face.knots_v.back() - face.knots_v.front());
}

std::int64_t unmatched_edges(const Brep& brep) {
  std::vector<std::array<int, 2>> uses(brep.edges.size());
  for (const Brep::Face& face : brep.faces)
    for (const Brep::Use& use : face.loop) ++uses[use.edge][use.is_reversed ? 1 : 0];
  std::int64_t count = 0;
  for (std::size_t e = 0; e < uses.size(); ++e)
    if (uses[e] != std::array{1, brep.edges[e].lines[1].face < 0 ? 0 : 1}) ++count;
  return count;
}

}  // namespace

BrepCheck check_brep(const Brep& brep, double diagonal) {
  BrepCheck check;
  for (std::int32_t f = 0; f < std::ssize(brep.faces); ++f)
    if (!is_border(brep, f)) ++check.broken_loops;
  check.unmatched_edges = unmatched_edges(brep);
  const Gap gap = ordered_reduce(
      brep.edges.size(), 256, Gap{},
      [&](std::size_t begin, std::size_t end) {
        Gap largest;
        for (std::size_t e = begin; e < end; ++e) {
          const Brep::Edge& edge = brep.edges[e];
          for (const Brep::Line& line : edge.lines)
            if (line.face >= 0) add_gap(brep, edge, line, largest);
          for (const auto& [vertex, point] :
               {std::pair{edge.from, edge.points.front()}, std::pair{edge.to, edge.points.back()}})
            largest.add(glm::length(brep.vertices[vertex] - point), point);
        }
        return largest;
      },
      [](Gap& total, const Gap& one) { total.add(one.distance, one.at); });
  check.largest_gap = gap.distance / diagonal;
  check.largest_gap_at = gap.at;
  return check;
}

}  // namespace planish
