#include "planish/brep/brep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "planish/analytic/spline_point.h"
#include "planish/brep/caps.h"
#include "planish/brep/quad_layout.h"
#include "planish/brep/spline_surface.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/words.h"
#include "planish/mesh/edge_groups.h"
#include "planish/surface/memory_need.h"

namespace planish {
glm::dvec3 point_of(const Brep& brep, const Brep::Face& face, const glm::dvec2& at) {
  const std::size_t rows = point_count(brep.degree, face.knots_u);
  return spline_point<kMostSplineDegree>(
      brep.degree, face.knots_v,
      [&](std::size_t j) {
        return spline_point<kMostSplineDegree>(
            brep.degree, face.knots_u, [&](std::size_t i) { return face.points[i + rows * j]; },
            at.x);
      },
      at.y);
}

glm::dvec3 point_of(const Brep& brep, const Brep::Edge& edge, double t) {
  return spline_point<kMostSplineDegree>(
      brep.degree, edge.knots, [&](std::size_t i) { return edge.points[i]; }, t);
}

namespace {

// The B-spline that a rectangle of quads is, and curves on its sides.
class SplineFace {
 public:
  // All of it must outlive the face.
  SplineFace(const SplineSurface& surface, const QuadLayout& layout, const CapDepths& depths,
             std::int32_t rectangle);

  // Sets knots and points. Lines of Q_1 on which polynomials go on are no knots.
  void fill(Brep::Face& face) const;
  // Sets knots and points of the edge on quads [first, first + count) of a side, in its direction.
  void fill(Brep::Edge& edge, int side, std::int32_t first, std::int32_t count) const;
  [[nodiscard]] Brep::Line line(int side, std::int32_t first, std::int32_t count,
                                bool is_reversed) const;

 private:
  [[nodiscard]] glm::dvec3 blossom(glm::dvec2 inside, const BlossomArguments& x,
                                   const BlossomArguments& y) const;
  [[nodiscard]] std::vector<double> all_knots(bool along_y) const;
  [[nodiscard]] std::vector<double> needed(std::span<const double> knots,
                                           std::span<const double> others, bool along_y) const;

  const SplineSurface& surface_;
  const QuadLayout& layout_;
  const CapDepths& depths_;
  const QuadLayout::Rectangle& cells_;
  std::int32_t rectangle_;
  std::vector<CornerPieces> pieces_;  // by cell
  std::vector<double> knots_x_, knots_y_;
};

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

std::size_t slot(std::int32_t index) { return static_cast<std::size_t>(index); }

// Faces by shells.
void join_faces(Brep& brep) {
  DisjointSets sets(brep.faces.size());
  for (const Brep::Edge& edge : brep.edges)
    if (edge.lines[1].face >= 0) sets.unite(edge.lines[0].face, edge.lines[1].face);
  std::vector<std::int32_t> shell_of(brep.faces.size(), -1);
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    std::int32_t& shell = shell_of[slot(sets.find(static_cast<std::int32_t>(f)))];
    if (shell < 0) {
      shell = static_cast<std::int32_t>(brep.shells.size());
      brep.shells.push_back({{}, true});
    }
    brep.shells[slot(shell)].faces.push_back(static_cast<std::int32_t>(f));
  }
  for (const Brep::Edge& edge : brep.edges) {
    if (edge.lines[1].face < 0)
      brep.shells[slot(shell_of[slot(sets.find(edge.lines[0].face))])].is_closed = false;
  }
}

// The faces of the mesh, through points of the surface, that a shell was made of: near enough to
// tell inside from outside.
struct ShellPolygons {
  std::vector<std::int32_t> faces;
  glm::dvec3 low{std::numeric_limits<double>::max()}, high{-std::numeric_limits<double>::max()};
  double volume = 0;
};

class Nesting {
 public:
  Nesting(const MeshTopology& topology, std::span<const glm::dvec3> points,
          std::span<const std::int32_t> face_of, const Brep& brep)
      : topology_(topology), points_(points), shells_(brep.shells.size()) {
    std::vector<std::int32_t> shell_of(brep.faces.size());
    for (std::size_t s = 0; s < brep.shells.size(); ++s)
      for (const std::int32_t f : brep.shells[s].faces)
        shell_of[slot(f)] = static_cast<std::int32_t>(s);
    for (std::int32_t f = 0; f < topology.face_count(); ++f)
      if (face_of[slot(f)] >= 0) add(f, shells_[slot(shell_of[slot(face_of[slot(f)])])]);
  }

  [[nodiscard]] const ShellPolygons& shell(std::size_t index) const { return shells_[index]; }
  [[nodiscard]] bool holds(std::size_t index, const glm::dvec3& point) const {
    const ShellPolygons& shell = shells_[index];
    if (glm::any(glm::lessThan(point, shell.low)) || glm::any(glm::lessThan(shell.high, point)))
      return false;
    double turns = 0;
    for (const std::int32_t f : shell.faces) {
      check_stop();
      each_triangle(f, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        turns += solid_angle(a - point, b - point, c - point);
      });
    }
    return std::abs(turns) > 2 * std::numbers::pi;
  }
  [[nodiscard]] const glm::dvec3& any_point(std::size_t index) const {
    return points_[slot(topology_.face(shells_[index].faces.front())[0])];
  }

 private:
  template <class Use>
  void each_triangle(std::int32_t face, const Use& use) const {
    const auto vertices = topology_.face(face);
    for (std::size_t i = 1; i + 1 < vertices.size(); ++i)
      use(points_[slot(vertices[0])], points_[slot(vertices[i])], points_[slot(vertices[i + 1])]);
  }
  void add(std::int32_t face, ShellPolygons& shell) {
    shell.faces.push_back(face);
    for (const std::int32_t v : topology_.face(face)) {
      shell.low = glm::min(shell.low, points_[slot(v)]);
      shell.high = glm::max(shell.high, points_[slot(v)]);
    }
    const glm::dvec3 about = points_[slot(topology_.face(shell.faces.front())[0])];
    each_triangle(face, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
      shell.volume += glm::dot(a - about, glm::cross(b - about, c - about)) / 6;
    });
  }
  // Van Oosterom and Strackee 1983.
  static double solid_angle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double x = glm::length(a), y = glm::length(b), z = glm::length(c);
    return 2 * portable::atan2(
                   glm::dot(a, glm::cross(b, c)),
                   x * y * z + glm::dot(a, b) * z + glm::dot(b, c) * x + glm::dot(c, a) * y);
  }

  const MeshTopology& topology_;
  std::span<const glm::dvec3> points_;  // by vertex
  std::vector<ShellPolygons> shells_;
};

// What find_shells() wants to know of faces that rectangles of quads became.
void make_shells(const MeshTopology& topology, const QuadLayout& layout, Brep& brep) {
  std::vector<glm::dvec3> points(brep.places.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Brep::Place& place = brep.places[v];
    if (place.face >= 0) points[v] = point_of(brep, brep.faces[slot(place.face)], place.at);
  }
  std::vector<std::int32_t> face_of(static_cast<std::size_t>(topology.face_count()), -1);
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const std::int32_t corner = topology.first_corner(f);
    if (!layout.is_hidden(corner)) face_of[slot(f)] = layout.rectangle_of(corner);
  }
  find_shells(topology, points, face_of, brep);
}

// An edge's place in a face.
struct EdgePlace {
  std::int32_t edge = 0;
  int side = 0;
  std::int32_t first = 0, count = 0;
};

struct FaceEdges {
  std::vector<EdgePlace> own;    // which the face makes
  std::vector<EdgePlace> other;  // which the face across makes
};

void check(const BrepOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, what);
  };
  if (!(options.angle > 0 && options.angle <= kMostBrepAngle))
    refuse("the angle at a B-rep's edges is above 0 and at most 90 degrees");
  if (!(options.deviation > 0 && options.deviation <= 1))
    refuse("the deviation of a B-rep is above 0 and at most 1 of the diagonal");
  if (options.face_size < 1 || options.face_size > kMostFaceSize)
    refuse("a B-rep's face has 1 to 4096 quads a side");
}

// Numbers edges and vertices, and sets loops, shells and ends of edges.
std::vector<FaceEdges> make_topology(const QuadLayout& layout, std::size_t half_edge_count,
                                     Brep& brep) {
  std::vector<std::int32_t> edge_at(half_edge_count, -1);  // by its first half edge
  std::vector<std::int32_t> vertex_of(static_cast<std::size_t>(layout.vertex_count()), -1);
  std::int32_t vertex_count = 0;
  const auto vertex = [&](std::int32_t v) {
    std::int32_t& number = vertex_of[v];
    if (number < 0) number = vertex_count++;
    return number;
  };
  const auto& rectangles = layout.rectangles();
  std::vector<FaceEdges> edges(rectangles.size());
  brep.faces.resize(rectangles.size());
  for (std::size_t f = 0; f < rectangles.size(); ++f) {
    for (int s = 0; s < 4; ++s) {
      const std::vector<std::int32_t> side = rectangles[f].side(s);
      for (std::size_t i = 0; i < side.size();) {
        std::size_t j = i + 1;
        while (j < side.size() && !layout.is_end(layout.origin(side[j]))) ++j;
        const auto first = static_cast<std::int32_t>(i), count = static_cast<std::int32_t>(j - i);
        const std::int32_t back = layout.twin(side[j - 1]);
        const std::int32_t known = back < 0 ? -1 : edge_at[back];
        if (known >= 0) {
          edges[f].other.push_back({known, s, first, count});
          brep.faces[f].loop.push_back({known, true});
        } else {
          const auto edge = static_cast<std::int32_t>(brep.edges.size());
          edge_at[side[i]] = edge;
          edges[f].own.push_back({edge, s, first, count});
          brep.faces[f].loop.push_back({edge, false});
          Brep::Edge made;
          made.from = vertex(layout.origin(side[i]));
          made.to = vertex(layout.target(side[j - 1]));
          made.half_edge = side[i];
          brep.edges.push_back(std::move(made));
        }
        i = j;
      }
    }
  }
  brep.vertices.resize(static_cast<std::size_t>(vertex_count));
  return edges;
}

// What faces and edges take at most: all knots are counted, of which some will not be needed.
void require_memory_for(const QuadLayout& layout, const CapDepths& depths) {
  double bytes = 0;
  for (const QuadLayout::Rectangle& rectangle : layout.rectangles()) {
    double inside = static_cast<double>(layout.degree()) + 1;
    for (int s = 0; s < 4; ++s) {
      const std::int32_t vertex = layout.origin(rectangle.side(s).front());
      if (layout.is_extraordinary(vertex)) inside += 0.5 * depths.of_vertex[vertex];
    }
    const double u = rectangle.width + inside, v = rectangle.height + inside;
    bytes += sizeof(glm::dvec3) * (u * v + u + v) + 1000;
  }
  const auto free = available_memory_bytes();
  if (bytes <= static_cast<double>(free)) return;
  const auto mebibytes = [](double count) {
    return std::to_string(static_cast<std::uint64_t>(count) >> 20);
  };
  throw Error(ErrorCode::OutOfMemory,
              counted(std::ssize(layout.rectangles()), "B-spline face") + " need about " +
                  mebibytes(bytes) + " MiB of memory where " + mebibytes(double(free)) +
                  " are free; allow a larger angle and deviation, or take a coarser mesh");
}

// Places on a face's border, around it as its loop: at its knots and between them.
std::vector<glm::dvec3> border_of(const Brep& brep, const Brep::Face& face) {
  std::vector<glm::dvec3> border;
  for (int side = 0; side < 4; ++side) {
    const bool along_v = side % 2 == 1, is_back = side >= 2;
    const std::vector<double>& knots = along_v ? face.knots_v : face.knots_u;
    const double across = side == 1 ? face.knots_u.back() : side == 2 ? face.knots_v.back() : 0;
    const std::size_t last = 2 * (knots.size() - 1);
    for (std::size_t i = 0; i < last; ++i) {
      const std::size_t place = is_back ? last - i : i;
      const double t = 0.5 * (knots[place / 2] + knots[(place + 1) / 2]);
      border.push_back(
          point_of(brep, face, along_v ? glm::dvec2(across, t) : glm::dvec2(t, across)));
    }
  }
  return border;
}

// Where all control points lie within `reach` of a plane, which the whole border tells: at a corner
// of half a turn both sides have one direction. None of what is no wider than that, where rounding
// would choose the plane.
std::optional<Brep::Plane> plane_of(const Brep& brep, const Brep::Face& face, double reach,
                                    double& off) {
  const glm::dvec3 origin = face.points.front();
  const std::vector<glm::dvec3> border = border_of(brep, face);
  glm::dvec3 area(0.0), longest(0.0);  // twice the area, as Newell has it
  double around = 0;
  for (std::size_t i = 0; i < border.size(); ++i) {
    const glm::dvec3& next = border[(i + 1) % border.size()];
    area += glm::cross(border[i] - origin, next - origin);
    const glm::dvec3 along = next - border[i];
    if (glm::length(along) > glm::length(longest)) longest = along;
    around += glm::length(along);
  }
  if (!(glm::length(area) > 2 * reach * around)) return std::nullopt;
  Brep::Plane plane;
  plane.normal = glm::normalize(area);
  for (const glm::dvec3& p : face.points)
    off = std::max(off, std::abs(glm::dot(p - origin, plane.normal)));
  if (off > reach) return std::nullopt;
  plane.along = glm::normalize(longest - glm::dot(longest, plane.normal) * plane.normal);
  return plane;
}

// Of a rectangle's cells whose quad's vertex is one of the mesh.
void place_vertices(const QuadLayout& layout, std::int32_t face, Brep& brep) {
  constexpr std::array<glm::dvec2, 4> kOrigin{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
  const QuadLayout::Rectangle& cells = layout.rectangles()[face];
  for (std::int32_t y = 0; y < cells.height; ++y) {
    for (std::int32_t x = 0; x < cells.width; ++x) {
      const QuadLayout::Cell& cell = cells.cell(x, y);
      brep.places[layout.origin(4 * cell.corner)] = {face, glm::dvec2(x, y) + kOrigin[cell.turn]};
    }
  }
}

}  // namespace

Brep make_brep(const SplineSurface& surface, const BrepOptions& options, const Callbacks& callbacks,
               std::span<const std::int32_t> groups) {
  check(options);
  const HostScope host(callbacks);
  callbacks.report("faces", 0);
  const QuadLayout layout(surface, options.face_size, groups, options.has_corners);
  constexpr double kDepthsShare = 0.4;  // of the time
  const Callbacks depths_callbacks = share_of(callbacks, 0, kDepthsShare);
  const CapDepths depths =
      cap_depths(surface, layout, {options.angle, options.deviation}, depths_callbacks);
  require_memory_for(layout, depths);
  Brep brep;
  brep.degree = surface.degree();
  brep.extraordinary = depths.count;
  brep.moved = depths.moved;
  brep.deepest = depths.deepest;
  const auto spot = [&](const Brep::Spot& unit) {
    return Brep::Spot{surface.placement().to_model(unit.position), unit.face};
  };
  brep.max_angle = depths.worst.angle;
  brep.max_angle_at = spot(depths.worst.angle_at);
  brep.max_deviation = depths.worst.deviation;
  brep.max_deviation_at = spot(depths.worst.deviation_at);
  const auto half_edges = 4 * static_cast<std::size_t>(surface.topology().corner_count());
  const std::vector<FaceEdges> edges = make_topology(layout, half_edges, brep);
  brep.places.resize(static_cast<std::size_t>(surface.topology().vertex_count()));
  for (std::size_t f = 0; f < brep.faces.size(); ++f)
    place_vertices(layout, static_cast<std::int32_t>(f), brep);
  // Within what no program tells from nothing.
  constexpr double kFlat = 1e-9;  // of the diagonal
  const double diagonal = surface.placement().diagonal,
               flat = diagonal * std::min(kFlat, options.deviation);
  std::vector<double> off_planes(brep.faces.size());
  LoopProgress progress(callbacks, "faces", kDepthsShare, 1, std::ssize(brep.faces));
  parallel_each(brep.faces.size(), 1, [&](std::int32_t f) {
    const SplineFace spline(surface, layout, depths, f);
    Brep::Face& face = brep.faces[f];
    spline.fill(face);
    face.plane = plane_of(brep, face, flat, off_planes[f]);
    if (!face.plane) off_planes[f] = 0;
    if (!groups.empty()) {
      const std::int32_t corner = layout.rectangles()[f].cells.front().corner;
      face.group = groups[surface.topology().face_of(corner)];
    }
    for (const EdgePlace& own : edges[f].own) {
      Brep::Edge& edge = brep.edges[own.edge];
      spline.fill(edge, own.side, own.first, own.count);
      edge.lines[0] = spline.line(own.side, own.first, own.count, false);
    }
    for (const EdgePlace& other : edges[f].other) {
      brep.edges[other.edge].lines[1] = spline.line(other.side, other.first, other.count, true);
    }
    progress.add();
  });
  for (const Brep::Edge& edge : brep.edges) {
    brep.vertices[edge.from] = edge.points.front();
    brep.vertices[edge.to] = edge.points.back();
  }
  for (std::size_t f = 0; f < off_planes.size(); ++f) {
    if (off_planes[f] > diagonal * brep.max_deviation) {
      brep.max_deviation = off_planes[f] / diagonal;
      brep.max_deviation_at = {
          brep.faces[f].points.front(),
          surface.topology().face_of(layout.rectangles()[f].cells.front().corner)};
    }
  }
  make_shells(surface.topology(), layout, brep);
  callbacks.report("faces", 1);
  return brep;
}

void find_shells(const MeshTopology& topology, std::span<const glm::dvec3> points,
                 std::span<const std::int32_t> face_of, Brep& brep) {
  brep.shells.clear();
  join_faces(brep);
  const Nesting nesting(topology, points, face_of, brep);
  for (std::size_t s = 0; s < brep.shells.size(); ++s)
    brep.shells[s].is_inside_out = brep.shells[s].is_closed && nesting.shell(s).volume < 0;
  for (std::size_t s = 0; s < brep.shells.size(); ++s) {
    Brep::Shell& shell = brep.shells[s];
    if (!shell.is_inside_out) continue;
    double least = std::numeric_limits<double>::max();
    for (std::size_t o = 0; o < brep.shells.size(); ++o) {
      const double volume = nesting.shell(o).volume;
      if (!brep.shells[o].is_closed || volume <= -nesting.shell(s).volume || volume >= least)
        continue;
      if (!nesting.holds(o, nesting.any_point(s))) continue;
      least = volume;
      shell.outer = static_cast<std::int32_t>(o);
    }
  }
}

Brep make_brep(const LimitSurface& surface, const BrepOptions& options, const Callbacks& callbacks,
               std::span<const std::int32_t> groups) {
  return make_brep(DooSabinSplines(surface), options, callbacks, groups);
}

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
  if (face.surface) {
    for (std::size_t i = 0; i + 1 < edge.knots.size(); ++i) {
      for (const double part : {0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
        const glm::dvec3 there =
            point_of(brep, edge, (1 - part) * edge.knots[i] + part * edge.knots[i + 1]);
        gap.add(std::abs(signed_distance(*face.surface, there)), there);
      }
    }
    return;
  }
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

// Of a curve from the surfaces on both sides and from its ends, at places along it.
void add_curve_gap(const Brep& brep, const Brep::Edge& edge, Gap& gap) {
  const BorderCurve& curve = *edge.curve;
  const glm::dvec3 &from = brep.vertices[edge.from], &to = brep.vertices[edge.to];
  for (const glm::dvec3& end : {from, to}) gap.add(distance_from(curve, from, to, end), end);
  for (const glm::dvec3& place : places_along(curve, from, to)) {
    for (const Brep::Line& line : edge.lines)
      gap.add(std::abs(signed_distance(*brep.faces[line.face].surface, place)), place);
  }
}

// Each use begins where the one before ends.
bool is_closed(const Brep& brep, std::span<const Brep::Use> loop) {
  const auto end = [&](const Brep::Use& use, bool is_last) {
    const Brep::Edge& edge = brep.edges[use.edge];
    return is_last != use.is_reversed ? edge.to : edge.from;
  };
  for (std::size_t i = 0; i < loop.size(); ++i)
    if (end(loop[i], true) != end(loop[(i + 1) % loop.size()], false)) return false;
  return !loop.empty();
}

// The same, at vertices and in parameters, and all of them enclose the whole rectangle on their
// left.
bool is_border(const Brep& brep, std::int32_t index) {
  const Brep::Face& face = brep.faces[index];
  if (face.surface)
    return is_closed(brep, face.loop) &&
           std::ranges::all_of(face.holes, [&](const auto& hole) { return is_closed(brep, hole); });
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
  for (const Brep::Face& face : brep.faces) {
    for (const Brep::Use& use : face.loop) ++uses[use.edge][use.is_reversed ? 1 : 0];
    for (const auto& hole : face.holes)
      for (const Brep::Use& use : hole) ++uses[use.edge][use.is_reversed ? 1 : 0];
  }
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
          if (edge.curve) {
            add_curve_gap(brep, edge, largest);
            continue;
          }
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
