#include "planish/mesh/convex_faces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "planish/core/work.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/convex_parts.h"
#include "planish/mesh/even_parts.h"
#include "planish/mesh/mesh_arrays.h"
#include "planish/mesh/plane.h"

namespace planish {

namespace {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

// Corners may turn inward by this angle: merged and meshed faces are rarely flat to the last digit.
constexpr double kStraight = 0.05;
// A finely drawn arc turns inward by less at each corner, but may by so much in all.
constexpr double kStraightInAll = 0.1;
// Of larger faces good diagonals are not searched for one by one, which takes time of the order of
// their square, and leaves slivers between those that it takes first.
constexpr std::size_t kMostCorners = 32;

// From a to b counter-clockwise, 0 to a full turn.
double turn_between(const dvec2& a, const dvec2& b) {
  const double angle = std::atan2(cross(a, b), glm::dot(a, b));
  return angle < 0 ? angle + 2 * pi : angle;
}

// The corners of a face, or of a part of it, by their places in the face; and where each place lies
// in the face's plane.
using Part = std::vector<std::size_t>;

std::vector<dvec2> flat_points(const PolygonMesh& mesh, std::int32_t face) {
  const auto vertices = mesh.face(face);
  std::vector<dvec2> points(vertices.size(), dvec2(0.0));
  const dvec3 area = area_vector(mesh.positions, vertices);
  const double size = glm::length(area);
  if (!(size > 0)) return points;
  const dvec3 normal = area / size;
  // Along the axis that the normal is farthest from.
  const dvec3 bent = glm::abs(normal);
  const bool x_is_least = bent.x <= bent.y && bent.x <= bent.z;
  const dvec3 axis = x_is_least         ? dvec3(1, 0, 0)
                     : bent.y <= bent.z ? dvec3(0, 1, 0)
                                        : dvec3(0, 0, 1);
  const dvec3 first = glm::normalize(glm::cross(axis, normal)), second = glm::cross(normal, first);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const dvec3 p = mesh.positions[vertices[i]] - mesh.positions[vertices[0]];
    points[i] = {glm::dot(p, first), glm::dot(p, second)};
  }
  return points;
}

double interior_angle(std::span<const dvec2> points, const Part& part, std::size_t i) {
  const std::size_t m = part.size();
  const dvec2& own = points[part[i]];
  return turn_between(points[part[(i + 1) % m]] - own, points[part[(i + m - 1) % m]] - own);
}

Part whole_face(std::size_t corners) {
  Part part(corners);
  std::iota(part.begin(), part.end(), 0);
  return part;
}

// The widest angle that each corner of a face may have: corners that turn inward a little may,
// until those since the last one that may not do by too much together.
std::vector<double> allowed_angles(std::span<const dvec2> points) {
  const std::size_t m = points.size();
  const Part face = whole_face(m);
  std::vector<double> turns(m);  // inward
  for (std::size_t i = 0; i < m; ++i) turns[i] = interior_angle(points, face, i) - pi;
  std::vector<double> allowed(m, pi + kStraight);
  const auto start =
      static_cast<std::size_t>(std::min_element(turns.begin(), turns.end()) - turns.begin());
  double in_all = 0;
  for (std::size_t k = 0; k < m; ++k) {
    const std::size_t i = (start + k) % m;
    in_all = turns[i] > kStraight ? 0 : std::max(in_all + turns[i], 0.0);
    if (in_all <= kStraightInAll) continue;
    allowed[i] = pi;
    in_all = 0;
  }
  return allowed;
}

// The corner with the widest angle of those that may not have theirs; the part's size where there
// is none.
std::size_t worst_corner(std::span<const dvec2> points, std::span<const double> allowed,
                         const Part& part) {
  constexpr double kRounding = 1e-9;
  std::size_t worst = part.size();
  double largest = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double angle = interior_angle(points, part, i);
    if (angle > allowed[part[i]] + kRounding && angle > largest) {
      largest = angle;
      worst = i;
    }
  }
  return worst;
}

// Whether the segment between corners i and j meets an edge of the part that ends at neither.
bool meets_an_edge(std::span<const dvec2> points, const Part& part, std::size_t i, std::size_t j) {
  const std::size_t m = part.size();
  count_work(Work::Pairs, static_cast<std::int64_t>(m));
  const dvec2& start = points[part[i]];
  const dvec2 way = points[part[j]] - start;
  for (std::size_t e = 0; e < m; ++e) {
    const std::size_t next = (e + 1) % m;
    if (e == i || e == j || next == i || next == j) continue;
    const dvec2 a = points[part[e]], edge = points[part[next]] - a;
    const bool parts_edge = cross(way, a - start) * cross(way, a + edge - start) <= 0;
    const bool parts_way = cross(edge, start - a) * cross(edge, start + way - a) <= 0;
    if (parts_edge && parts_way) return true;
  }
  return false;
}

// How good the diagonal from corner i to corner j is; below every number where it leaves the part.
// Good ones leave wide angles, none of which is nearly straight, and are short.
double merit(std::span<const dvec2> points, const Part& part, std::size_t i, std::size_t j) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  constexpr double kNearlyStraight = 0.9 * pi, kStraightCost = 3.0, kLengthCost = 0.2;
  const std::size_t m = part.size();
  const dvec2& from = points[part[i]];
  const dvec2& to = points[part[j]];
  const dvec2 along = points[part[(i + 1) % m]] - from;
  const double before = turn_between(along, to - from);
  const double after = interior_angle(points, part, i) - before;
  const double far_after = turn_between(points[part[(j + 1) % m]] - to, from - to);
  const double far_before = interior_angle(points, part, j) - far_after;
  const double least = std::min({before, after, far_before, far_after});
  if (!(least > 0) || !(glm::length(along) > 0)) return kNone;
  const double straightest = std::max({before, after, kNearlyStraight}) - kNearlyStraight;
  return least - kStraightCost * straightest -
         kLengthCost * glm::distance(from, to) / glm::length(along);
}

// Cuts faces one after another.
class Cutter {
 public:
  // `faces`: those that will be cut.
  Cutter(const PolygonMesh& mesh, std::span<const std::int32_t> faces) : mesh_(mesh) {
    std::vector<bool> is_theirs(static_cast<std::size_t>(mesh.vertex_count()));
    for (const std::int32_t f : faces)
      for (const std::int32_t v : mesh.face(f)) is_theirs[v] = true;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto vertices = mesh.face(f);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const std::int32_t own = vertices[i], next = vertices[(i + 1) % vertices.size()];
        if (is_theirs[own] && is_theirs[next]) edges_.insert(std::minmax(own, next));
      }
    }
  }

  // The parts of a face; some may still be concave, and `clean` is then false.
  std::vector<Part> cut(std::int32_t face, bool& clean) {
    const std::vector<dvec2> points = flat_points(mesh_, face);
    const std::vector<double> allowed = allowed_angles(points);
    return points.size() > kMostCorners ? cut_large(face, points, allowed, clean)
                                        : cut_small(face, points, allowed, clean);
  }

 private:
  std::vector<Part> cut_small(std::int32_t face, std::span<const dvec2> points,
                              std::span<const double> allowed, bool& clean) {
    std::vector<Part> open{whole_face(points.size())}, done;
    while (!open.empty()) {
      const Part part = std::move(open.back());
      open.pop_back();
      const std::size_t i = worst_corner(points, allowed, part);
      const std::size_t j = i == part.size() ? i : other_end(face, points, part, i);
      if (j == i) {
        clean = clean && i == part.size();
        done.push_back(part);
        continue;
      }
      edges_.insert(vertices_of(face, part[i], part[j]));
      for (const auto& [first, last] : {std::pair(i, j), std::pair(j, i)}) {
        Part piece;
        for (std::size_t k = first;; k = (k + 1) % part.size()) {
          piece.push_back(part[k]);
          if (k == last) break;
        }
        open.push_back(std::move(piece));
      }
    }
    return done;
  }

  [[nodiscard]] std::pair<std::int32_t, std::int32_t> vertices_of(std::int32_t face, std::size_t a,
                                                                  std::size_t b) const {
    return std::minmax(mesh_.face(face)[a], mesh_.face(face)[b]);
  }

  std::vector<Part> cut_large(std::int32_t face, std::span<const dvec2> points,
                              std::span<const double> allowed, bool& clean) {
    const auto may_cut = [&](std::size_t a, std::size_t b) {
      return edges_.insert(vertices_of(face, a, b)).second;
    };
    std::vector<Part> parts;
    for (Part& part : convex_parts(points, allowed, may_cut)) {
      clean = clean && worst_corner(points, allowed, part) == part.size();
      std::ranges::move(even_parts(points, std::move(part), may_cut), std::back_inserter(parts));
    }
    for (Part& part : parts) std::ranges::rotate(part, std::ranges::min_element(part));
    std::ranges::sort(parts);
    return parts;
  }

  // The best corner to cut to from corner i; i where there is none.
  [[nodiscard]] std::size_t other_end(std::int32_t face, std::span<const dvec2> points,
                                      const Part& part, std::size_t i) const {
    std::vector<std::pair<double, std::size_t>> candidates;
    for (std::size_t k = 2; k + 1 < part.size(); ++k) {
      const std::size_t j = (i + k) % part.size();
      const double value = merit(points, part, i, j);
      if (std::isfinite(value)) candidates.emplace_back(-value, j);
    }
    std::sort(candidates.begin(), candidates.end());
    for (const auto& [cost, j] : candidates) {
      if (edges_.contains(vertices_of(face, part[i], part[j]))) continue;
      if (!meets_an_edge(points, part, i, j)) return j;
    }
    return i;
  }

  const PolygonMesh& mesh_;
  std::set<std::pair<std::int32_t, std::int32_t>> edges_;
};

// Appends a part of a face with what rides on its corners.
void add_part(const PolygonMesh& source, std::int32_t face, const Part& part, ConvexMesh& result) {
  PolygonMesh& mesh = result.mesh;
  const std::int32_t first = source.face_offsets[face];
  for (const std::size_t place : part) {
    const auto corner = first + static_cast<std::int32_t>(place);
    mesh.face_vertices.push_back(source.face_vertices[corner]);
    if (!source.face_uvs.empty()) mesh.face_uvs.push_back(source.face_uvs[corner]);
  }
  mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
  if (!source.face_groups.empty()) mesh.face_groups.push_back(source.face_groups[face]);
  result.source_faces.push_back(face);
}

// Whether any corner turns inward at all: most faces need no closer look.
bool may_be_concave(const PolygonMesh& mesh, std::int32_t face) {
  const auto vertices = mesh.face(face);
  const dvec3 area = area_vector(mesh.positions, vertices);
  const std::size_t m = vertices.size();
  for (std::size_t i = 0; m > 3 && i < m; ++i) {
    const dvec3& own = mesh.positions[vertices[i]];
    const dvec3 turn = glm::cross(mesh.positions[vertices[(i + 1) % m]] - own,
                                  mesh.positions[vertices[(i + m - 1) % m]] - own);
    if (glm::dot(turn, area) < 0) return true;
  }
  return false;
}

bool is_concave(const PolygonMesh& mesh, std::int32_t face) {
  if (!may_be_concave(mesh, face)) return false;
  const std::vector<dvec2> points = flat_points(mesh, face);
  const Part part = whole_face(points.size());
  return worst_corner(points, allowed_angles(points), part) < part.size();
}

bool is_uneven(const PolygonMesh& mesh, std::int32_t face) {
  return mesh.face(face).size() > kMostCorners &&
         corner_swirl(flat_points(mesh, face)) > kMostSwirl;
}

template <class Is>
std::vector<std::int32_t> faces_that(const PolygonMesh& mesh, const Is& is) {
  require_sound_indices(arrays_of(mesh), "mesh", ErrorCode::UnusableMesh);
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (is(f)) faces.push_back(f);
  return faces;
}

}  // namespace

std::vector<std::int32_t> concave_faces(const PolygonMesh& mesh) {
  return faces_that(mesh, [&](std::int32_t f) { return is_concave(mesh, f); });
}

ConvexMesh with_convex_faces(const PolygonMesh& mesh) {
  ConvexMesh result{mesh, {}, {}, {}};
  const std::vector<std::int32_t> bad =
      faces_that(mesh, [&](std::int32_t f) { return is_uneven(mesh, f) || is_concave(mesh, f); });
  if (bad.empty()) {
    result.source_faces.resize(static_cast<std::size_t>(mesh.face_count()));
    std::iota(result.source_faces.begin(), result.source_faces.end(), 0);
    return result;
  }
  PolygonMesh& cut = result.mesh;
  cut.face_offsets = {0};
  for (auto* const corners : {&cut.face_vertices, &cut.face_uvs, &cut.face_groups})
    corners->clear();
  cut.hole_faces.clear();
  const std::set<std::int32_t> holes(mesh.hole_faces.begin(), mesh.hole_faces.end());
  Cutter cutter(mesh, bad);
  auto next = bad.begin();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Part> parts;
    if (next != bad.end() && *next == f) {
      ++next;
      bool clean = true;
      parts = cutter.cut(f, clean);
      if (parts.size() > 1) result.cut_faces.push_back(f);
      if (!clean) result.concave_faces.push_back(f);
    } else {
      parts.push_back(whole_face(static_cast<std::size_t>(mesh.face_size(f))));
    }
    for (const Part& part : parts) {
      if (holes.contains(f)) cut.hole_faces.push_back(cut.face_count());
      add_part(mesh, f, part, result);
    }
  }
  return result;
}

}  // namespace planish
