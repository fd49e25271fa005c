#include "planish/brep/step_numbers.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "planish/brep/square_piece.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::int64_t kPlaneEntities = 4, kUnknown = 0;

// The control point of these arguments, ascending; kNone where none has them.
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
std::size_t point_of_arguments(std::size_t degree, std::span<const double> knots,
                               std::span<const double> wanted) {
  const auto found = std::ranges::lower_bound(knots, wanted.back());
  if (found == knots.end() || *found != wanted.back()) return kNone;
  // Behind the last knot's first one, each has it once more.
  auto i = static_cast<std::size_t>(found - knots.begin());
  if (i + 1 == knots.size())
    i += static_cast<std::size_t>(std::ranges::count(wanted, wanted.back())) - 1;
  const BlossomArguments own = knot_arguments(degree, knots, i);
  return std::equal(wanted.begin(), wanted.end(), own.begin()) ? i : kNone;
}

}  // namespace

StepNumbers::StepNumbers(const Brep& brep, std::int64_t first) : brep_(brep), first_(first) {
  for (const Brep::Edge& edge : brep.edges)
    for (const Brep::Line& line : edge.lines)
      if (has_curve(line)) lines_.push_back(plane_line(line));
  std::ranges::sort(lines_);
  lines_.erase(std::unique(lines_.begin(), lines_.end()), lines_.end());
  vertices_ = first + 3 * std::ssize(lines_);

  std::int64_t id = vertices_ + 2 * std::ssize(brep.vertices);
  for (const Brep::Edge& edge : brep.edges) {
    edges_.push_back(id);
    id += of_edge(edge);
  }
  edges_.push_back(id);
  std::vector<std::int64_t> own(brep.faces.size());
  parallel_for(own.size(), 64, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int64_t> numbers;
    for (std::size_t f = begin; f < end; ++f) {
      own[f] =
          brep.faces[f].plane ? kPlaneEntities : points(static_cast<std::int64_t>(f), numbers) + 1;
    }
  });
  for (std::size_t f = 0; f < own.size(); ++f) {
    faces_.push_back(id);
    id += own[f] + std::ssize(brep.faces[f].loop) + 3;
  }
  faces_.push_back(id);
}

std::int64_t StepNumbers::surface(std::int64_t f) const {
  return first_of_face(f + 1) - 4 - std::ssize(brep_.faces[f].loop);
}

// Inner points, the curve, where it is on B-splines its curves in their parameters and what names
// them all, and the edge.
std::int64_t StepNumbers::of_edge(const Brep::Edge& edge) const {
  const std::int64_t curves =
      (has_curve(edge.lines[0]) ? 1 : 0) + (has_curve(edge.lines[1]) ? 1 : 0);
  return std::ssize(edge.points) + curves + (curves > 0 ? 1 : 0);
}

StepNumbers::PlaneLine StepNumbers::plane_line(const Brep::Line& line) {
  return {static_cast<std::int32_t>(line.from.x), static_cast<std::int32_t>(line.from.y),
          line.direction};
}

std::int64_t StepNumbers::line(const Brep::Line& line) const {
  const auto found = std::ranges::lower_bound(lines_, plane_line(line));
  return first_ + 3 * (found - lines_.begin()) + 2;
}

std::int64_t StepNumbers::points(std::int64_t f, std::vector<std::int64_t>& numbers) const {
  const Brep::Face& face = brep_.faces[f];
  const std::size_t rows = point_count(brep_.degree, face.knots_u),
                    columns = point_count(brep_.degree, face.knots_v);
  numbers.assign(face.points.size(), kUnknown);
  for (const Brep::Use& use : face.loop) {
    const Brep::Edge& edge = brep_.edges[use.edge];
    const Brep::Line& line = edge.lines[use.is_reversed ? 1 : 0];
    const bool along_u = line.direction % 2 == 0;
    const double sign = line.direction < 2 ? 1 : -1;
    const double from = along_u ? line.from.x : line.from.y;
    const double across = along_u ? line.from.y : line.from.x;
    const std::size_t place = across == 0 ? 0 : (along_u ? columns : rows) - 1;
    const std::size_t last = edge.points.size() - 1;
    for (std::size_t j = 0; j <= last; ++j) {
      BlossomArguments own = knot_arguments(brep_.degree, edge.knots, j);
      const std::span<double> there(own.data(), brep_.degree);
      for (double& t : there) t = from + sign * t;
      std::ranges::sort(there);
      const std::size_t i =
          point_of_arguments(brep_.degree, along_u ? face.knots_u : face.knots_v, there);
      if (i == kNone) continue;
      numbers[along_u ? i + rows * place : place + rows * i] =
          j == 0      ? first_of_vertex(edge.from)
          : j == last ? first_of_vertex(edge.to)
                      : first_of_edge(use.edge) + static_cast<std::int64_t>(j) - 1;
    }
  }
  // Not known yet while it is counted.
  const bool is_counted = static_cast<std::size_t>(f) < faces_.size();
  std::int64_t own = is_counted ? first_of_face(f) : 1;
  const std::int64_t begin = own;
  for (std::int64_t& number : numbers)
    if (number == kUnknown) number = own++;
  return own - begin;
}

}  // namespace planish
