#include "planish/brep/spline_face.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace planish {
namespace {

// Of differences of the degree over a quad, of the diagonal: rounding of what is one polynomial.
constexpr double kSamePolynomial = 2e-14;

// Of a place of the rectangle's cell, as its quad's corner has it.
struct TurnedArguments {
  BlossomArguments u, v;
};
BlossomArguments mirrored(BlossomArguments arguments) {
  for (double& t : arguments) t = 1 - t;
  return arguments;
}
BlossomArguments less(BlossomArguments arguments, double by) {
  for (double& t : arguments) t -= by;
  return arguments;
}
TurnedArguments turned(std::int32_t turn, const BlossomArguments& x, const BlossomArguments& y) {
  switch (turn) {
    case 0:
      return {x, y};
    case 1:
      return {mirrored(y), x};
    case 2:
      return {mirrored(x), mirrored(y)};
    default:
      return {y, mirrored(x)};
  }
}

double middle(std::span<const double> knots, std::size_t span) {
  return 0.5 * (knots[span] + knots[span + 1]);
}

// A span in which control point i has a say.
std::size_t span_of(std::span<const double> knots, std::size_t i) {
  return std::min(i == 0 ? 0 : i - 1, knots.size() - 2);
}

}  // namespace

SplineFace::SplineFace(const SplineSurface& surface, const QuadLayout& layout,
                       const CapDepths& depths, std::int32_t rectangle)
    : surface_(surface),
      layout_(layout),
      depths_(depths),
      cells_(layout.rectangles()[rectangle]),
      rectangle_(rectangle) {
  const std::unique_ptr<SplinePatch> patch = surface.patch();
  pieces_.reserve(cells_.cells.size());
  for (const QuadLayout::Cell& cell : cells_.cells) {
    patch->move_to(cell.corner);
    pieces_.push_back(pieces_of(*patch, cell.corner, layout, depths));
  }
  const std::vector<double> x = all_knots(false), y = all_knots(true);
  knots_x_ = needed(x, y, false);
  knots_y_ = needed(y, knots_x_, true);
}

std::vector<double> SplineFace::all_knots(bool along_y) const {
  const std::int32_t length = along_y ? cells_.height : cells_.width;
  std::vector<double> knots;
  for (std::int32_t i = 0; i <= length; ++i) knots.push_back(i);
  for (int s = 0; s < 4; ++s) {
    const std::int32_t vertex = layout_.origin(cells_.side(s).front());
    if (!layout_.is_extraordinary(vertex)) continue;
    const bool is_far = along_y ? s >= 2 : s == 1 || s == 2;
    for (int d = 1; d <= depths_.of_vertex[vertex]; ++d)
      knots.push_back(is_far ? length - std::ldexp(1.0, -d) : std::ldexp(1.0, -d));
  }
  std::ranges::sort(knots);
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  return knots;
}

glm::dvec3 SplineFace::blossom(glm::dvec2 inside, const BlossomArguments& x,
                               const BlossomArguments& y) const {
  const std::int32_t i = std::clamp(static_cast<std::int32_t>(inside.x), 0, cells_.width - 1);
  const std::int32_t j = std::clamp(static_cast<std::int32_t>(inside.y), 0, cells_.height - 1);
  const std::int32_t turn = cells_.cell(i, j).turn;
  const double px = inside.x - i, py = inside.y - j;
  const TurnedArguments place = turned(turn, same_arguments(px), same_arguments(py));
  const TurnedArguments at = turned(turn, less(x, i), less(y, j));
  return pieces_[i + cells_.width * j].at(place.u[0], place.v[0]).blossom(at.u, at.v);
}

std::vector<double> SplineFace::needed(std::span<const double> knots,
                                       std::span<const double> others, bool along_y) const {
  const std::size_t degree = surface_.degree();
  std::vector<double> kept{knots.front()};
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    const double t = knots[k], before = middle(knots, k - 1), after = middle(knots, k);
    bool is_needed = false;
    for (std::size_t o = 0; o + 1 < others.size() && !is_needed; ++o) {
      const double across = middle(others, o);
      for (std::size_t p = 0; p <= degree && !is_needed; ++p) {
        const BlossomArguments point = bezier_arguments(degree, p, others[o], others[o + 1]);
        const BlossomArguments next = same_arguments(t + 1);
        const glm::dvec3 apart =
            along_y
                ? blossom({across, before}, point, next) - blossom({across, after}, point, next)
                : blossom({before, across}, next, point) - blossom({after, across}, next, point);
        is_needed = glm::length(apart) > kSamePolynomial;
      }
    }
    if (is_needed) kept.push_back(t);
  }
  kept.push_back(knots.back());
  return kept;
}

void SplineFace::fill(Brep::Face& face) const {
  face.knots_u = knots_x_;
  face.knots_v = knots_y_;
  const std::size_t degree = surface_.degree();
  const std::size_t rows = point_count(degree, knots_x_), columns = point_count(degree, knots_y_);
  face.points.reserve(rows * columns);
  for (std::size_t j = 0; j < columns; ++j) {
    for (std::size_t i = 0; i < rows; ++i) {
      const glm::dvec2 inside{middle(knots_x_, span_of(knots_x_, i)),
                              middle(knots_y_, span_of(knots_y_, j))};
      face.points.push_back(surface_.placement().to_model(blossom(
          inside, knot_arguments(degree, knots_x_, i), knot_arguments(degree, knots_y_, j))));
    }
  }
}

void SplineFace::fill(Brep::Edge& edge, int side, std::int32_t first, std::int32_t count) const {
  const bool along_y = side % 2 == 1, is_back = side >= 2;
  const std::int32_t length = along_y ? cells_.height : cells_.width;
  const double low = is_back ? length - first - count : first, high = low + count;
  std::vector<double> knots{low};
  for (const double t : along_y ? knots_y_ : knots_x_) {
    if (t > low && t < high) knots.push_back(t);
  }
  knots.push_back(high);
  const double line = side == 1 ? cells_.width : side == 2 ? cells_.height : 0;
  const BlossomArguments on_line = same_arguments(line);
  const std::size_t degree = surface_.degree(), count_of_points = point_count(degree, knots);
  for (std::size_t i = 0; i < count_of_points; ++i) {
    const double inside = middle(knots, span_of(knots, i));
    const BlossomArguments along = knot_arguments(degree, knots, i);
    edge.points.push_back(
        surface_.placement().to_model(along_y ? blossom({line, inside}, on_line, along)
                                              : blossom({inside, line}, along, on_line)));
  }
  if (is_back) {
    std::ranges::reverse(edge.points);
    std::ranges::reverse(knots);
  }
  for (const double t : knots) edge.knots.push_back(is_back ? high - t : t - low);
}

Brep::Line SplineFace::line(int side, std::int32_t first, std::int32_t count,
                            bool is_reversed) const {
  const double width = cells_.width, height = cells_.height;
  const double at = is_reversed ? first + count : first;
  Brep::Line line{rectangle_, {}, is_reversed ? (side + 2) % 4 : side};
  if (side == 0) line.from = {at, 0};
  if (side == 1) line.from = {width, at};
  if (side == 2) line.from = {width - at, height};
  if (side == 3) line.from = {0, height - at};
  return line;
}

}  // namespace planish
