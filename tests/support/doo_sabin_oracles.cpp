#include "support/doo_sabin_oracles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <utility>

#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;

namespace {

// The quadratic B-spline of integer knots shifted to be centred on 0.
double basis(double t) {
  t = std::abs(t);
  if (t <= 0.5) return 0.75 - t * t;
  return t < 1.5 ? (1.5 - t) * (1.5 - t) / 2 : 0;
}
double basis_slope(double t) {
  if (std::abs(t) <= 0.5) return -2 * t;
  return std::abs(t) < 1.5 ? std::copysign(1.5 - std::abs(t), -t) : 0;
}

}  // namespace

BSplineOracle::BSplineOracle(const PolygonMesh& grid_mesh, int columns, int rows)
    : columns_(columns), rows_(rows) {
  const auto vertex = [&](int i, int j) { return grid_mesh.positions[j * (columns + 1) + i]; };
  const auto extended_row = [&](int i, int j) {
    if (i < 0) return 2.0 * vertex(0, j) - vertex(1, j);
    if (i > columns) return 2.0 * vertex(columns, j) - vertex(columns - 1, j);
    return vertex(i, j);
  };
  for (int j = -1; j <= rows + 1; ++j) {
    for (int i = -1; i <= columns + 1; ++i) {
      net_.push_back(j < 0      ? 2.0 * extended_row(i, 0) - extended_row(i, 1)
                     : j > rows ? 2.0 * extended_row(i, rows) - extended_row(i, rows - 1)
                                : extended_row(i, j));
    }
  }
}

dvec3 BSplineOracle::control(int i, int j) const { return net_[(j + 1) * (columns_ + 3) + i + 1]; }

template <class BasisU, class BasisV>
dvec3 BSplineOracle::sum(const BasisU& basis_u, const BasisV& basis_v) const {
  dvec3 result(0.0);
  for (int j = -1; j <= rows_ + 1; ++j) {
    for (int i = -1; i <= columns_ + 1; ++i) result += basis_u(i) * basis_v(j) * control(i, j);
  }
  return result;
}

dvec3 BSplineOracle::point(double u, double v) const {
  return sum([&](int i) { return basis(u - i); }, [&](int j) { return basis(v - j); });
}

dvec3 BSplineOracle::normal(double u, double v) const {
  const dvec3 du =
      sum([&](int i) { return basis_slope(u - i); }, [&](int j) { return basis(v - j); });
  const dvec3 dv =
      sum([&](int i) { return basis(u - i); }, [&](int j) { return basis_slope(v - j); });
  return glm::normalize(glm::cross(du, dv));
}

// Based on: Doo & Sabin, Behaviour of recursive division surfaces near extraordinary points, 1978.
using std::int32_t;

using Corner = ExplicitMesh::Corner;

std::vector<dvec3> shrunk_polygon(Weights weights, const std::vector<dvec3>& polygon) {
  const std::size_t m = polygon.size();
  dvec3 centroid(0.0);
  for (const dvec3& p : polygon) centroid += p / double(m);
  std::vector<dvec3> result(m, dvec3(0.0));
  for (std::size_t i = 0; i < m; ++i) {
    if (weights == Weights::Averaged) {
      const dvec3 after = (polygon[i] + polygon[(i + 1) % m]) / 2.0;
      const dvec3 before = (polygon[i] + polygon[(i + m - 1) % m]) / 2.0;
      result[i] = (polygon[i] + centroid + before + after) / 4.0;
      continue;
    }
    for (std::size_t j = 0; j < m; ++j) {
      const double angle = 2 * std::numbers::pi * (double(j) - double(i)) / double(m);
      const double weight =
          i == j ? (double(m) + 5) / (4.0 * m) : (3 + 2 * std::cos(angle)) / (4.0 * m);
      result[i] += weight * polygon[j];
    }
  }
  return result;
}

ExplicitMesh explicit_mesh(const PolygonMesh& mesh) {
  ExplicitMesh result;
  result.points = mesh.positions;
  result.faces = faces_of(mesh);
  std::map<std::pair<int32_t, int32_t>, Corner> half_edges;
  for (std::size_t f = 0; f < result.faces.size(); ++f) {
    const auto& face = result.faces[f];
    for (std::size_t i = 0; i < face.size(); ++i) {
      half_edges[{face[i], face[(i + 1) % face.size()]}] = {int32_t(f), int32_t(i)};
    }
  }
  for (const auto& face : result.faces) {
    result.twins.emplace_back();
    for (std::size_t i = 0; i < face.size(); ++i) {
      result.twins.back().push_back(half_edges.at({face[(i + 1) % face.size()], face[i]}));
    }
  }
  return result;
}

namespace {

// Corners around the vertex at `start`, counter-clockwise: the next face lies left of the edge by
// which the present face comes in.
std::vector<Corner> corners_around(const ExplicitMesh& mesh, Corner start) {
  std::vector<Corner> ring;
  Corner at = start;
  do {
    ring.push_back(at);
    const auto& twins = mesh.twins[at.face];
    at = twins[(at.corner + twins.size() - 1) % twins.size()];
  } while (at.face != start.face || at.corner != start.corner);
  return ring;
}

// A new mesh whose first faces are the old ones, shrunk.
ExplicitMesh shrunk_faces(const ExplicitMesh& mesh, Weights weights) {
  ExplicitMesh next;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    std::vector<dvec3> polygon;
    for (int32_t v : mesh.faces[f]) polygon.push_back(mesh.points[v]);
    std::vector<int32_t> face;
    for (const dvec3& point : shrunk_polygon(weights, polygon)) {
      next.origins.push_back({int32_t(f), int32_t(face.size())});
      face.push_back(int32_t(next.points.size()));
      next.points.push_back(point);
    }
    next.faces.push_back(face);
    next.twins.emplace_back(face.size());
  }
  return next;
}

}  // namespace

ExplicitMesh explicit_step(const ExplicitMesh& mesh, Weights weights) {
  ExplicitMesh next = shrunk_faces(mesh, weights);
  const auto point_at = [&](Corner c) { return next.faces[c.face][c.corner]; };
  const auto after = [&](Corner c) {
    return Corner{c.face, int32_t((c.corner + 1) % mesh.faces[c.face].size())};
  };
  const auto join = [&](Corner a, Corner b) {
    next.twins[a.face][a.corner] = b;
    next.twins[b.face][b.corner] = a;
  };
  // Edge quads. Their sides 1 and 3 face the vertex polygons, whose side from the point of a
  // corner c is joined to the quad of the edge that enters c.
  std::map<std::pair<int32_t, int32_t>, Corner> side_entering;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < mesh.faces[f].size(); ++i) {
      const Corner left{int32_t(f), int32_t(i)}, right = mesh.twins[f][i];
      if (std::pair(left.face, left.corner) > std::pair(right.face, right.corner)) continue;
      const auto quad = int32_t(next.faces.size());
      next.faces.push_back(
          {point_at(after(left)), point_at(left), point_at(after(right)), point_at(right)});
      next.twins.emplace_back(4);
      join({quad, 0}, left);
      join({quad, 2}, right);
      side_entering[{after(right).face, after(right).corner}] = {quad, 1};
      side_entering[{after(left).face, after(left).corner}] = {quad, 3};
    }
  }
  const bool from_base = mesh.polygon_of_base_vertex.empty();
  next.polygon_of_base_vertex = mesh.polygon_of_base_vertex;
  if (from_base) next.polygon_of_base_vertex.assign(mesh.points.size(), -1);
  std::vector<bool> done(mesh.points.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < mesh.faces[f].size(); ++i) {
      const int32_t vertex = mesh.faces[f][i];
      if (done[vertex]) continue;
      done[vertex] = true;
      const auto polygon = int32_t(next.faces.size());
      if (from_base) next.polygon_of_base_vertex[vertex] = polygon;
      std::vector<int32_t> face;
      const std::vector<Corner> ring = corners_around(mesh, {int32_t(f), int32_t(i)});
      next.twins.emplace_back(ring.size());
      for (const Corner corner : ring) {
        join({polygon, int32_t(face.size())}, side_entering.at({corner.face, corner.corner}));
        face.push_back(point_at(corner));
      }
      next.faces.push_back(face);
    }
  }
  return next;
}

ExplicitMesh explicit_levels(const PolygonMesh& mesh, Weights weights, int levels) {
  ExplicitMesh result = explicit_mesh(mesh);
  for (int level = 0; level < levels; ++level) result = explicit_step(result, weights);
  return result;
}

dvec3 face_centroid(const ExplicitMesh& mesh, int32_t face) {
  dvec3 sum(0.0);
  for (int32_t v : mesh.faces[face]) sum += mesh.points[v];
  return sum / double(mesh.faces[face].size());
}

std::vector<dvec3> explicit_limit_points(const ExplicitMesh& mesh) {
  std::vector<dvec3> result;
  for (int32_t face : mesh.polygon_of_base_vertex) result.push_back(face_centroid(mesh, face));
  return result;
}

namespace {

constexpr double kPi = std::numbers::pi;

QuadSplitOracle::Edge undirected(int32_t a, int32_t b) { return std::minmax(a, b); }

int32_t other_end(QuadSplitOracle::Edge edge, int32_t end) {
  return edge.first == end ? edge.second : edge.first;
}

int32_t after(const std::array<int32_t, 4>& face, int32_t v) {
  return face[(std::find(face.begin(), face.end(), v) - face.begin() + 1) % 4];
}
int32_t before(const std::array<int32_t, 4>& face, int32_t v) {
  return face[(std::find(face.begin(), face.end(), v) - face.begin() + 3) % 4];
}

// Interior angle of a polygon's corner, 0 to 2 pi as seen against its Newell normal.
double interior_angle(const std::vector<dvec3>& polygon, std::size_t corner) {
  const std::size_t m = polygon.size();
  dvec3 newell(0.0);
  for (std::size_t i = 0; i < m; ++i) {
    newell += glm::cross(polygon[i] - polygon[0], polygon[(i + 1) % m] - polygon[0]);
  }
  const dvec3 out = polygon[(corner + 1) % m] - polygon[corner];
  const dvec3 in = polygon[(corner + m - 1) % m] - polygon[corner];
  const dvec3 turn = glm::cross(out, in);
  const double sine = std::copysign(glm::length(turn), glm::dot(turn, newell));
  const double angle = std::atan2(sine, glm::dot(out, in));
  return angle < 0 ? angle + 2 * kPi : angle;
}

// Sharp edges of the base mesh: those with one face, and those tagged infinitely sharp.
std::set<QuadSplitOracle::Edge> base_sharp_edges(const PolygonMesh& cage) {
  std::map<QuadSplitOracle::Edge, int> face_count;
  for (const auto& face : faces_of(cage)) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      ++face_count[undirected(face[i], face[(i + 1) % face.size()])];
    }
  }
  std::set<QuadSplitOracle::Edge> sharp;
  for (const auto& [edge, count] : face_count) {
    if (count == 1) sharp.insert(edge);
  }
  for (const CreaseEdge& crease : cage.creases) {
    if (crease.sharpness >= kInfiniteSharpness) sharp.insert(undirected(crease.v0, crease.v1));
  }
  return sharp;
}

}  // namespace

QuadSplitOracle::QuadSplitOracle(const PolygonMesh& cage, Weights weights, BoundaryRule boundary,
                                 std::span<const dvec3> rest)
    : weights_(weights), vertex_count_(cage.vertex_count()) {
  const FaceList polygons = faces_of(cage);
  split(polygons);
  for (const auto& face : polygons) {
    std::vector<dvec3> polygon;
    for (int32_t v : face) polygon.push_back(cage.positions[v]);
    for (const dvec3& x : shrunk_polygon(weights, polygon)) face_points_.push_back(x);
  }
  for (const Edge& base : base_sharp_edges(cage)) {
    for (int32_t end : {base.first, base.second}) {
      const int32_t middle = edge_vertices_.at(base);
      const Edge half = undirected(end, middle);
      const dvec3 p = cage.positions[end], n = cage.positions[other_end(base, end)];
      curve_points_[half] = (3.0 * p + n) / 4.0;
      sharp_at_[end].push_back(half);
      sharp_at_[middle].push_back(half);
    }
  }
  find_corners(cage, boundary, rest);
  for (auto& [edge, point] : curve_points_) {
    if (kind(edge.first) != VertexKind::Dart) continue;  // base vertices have the smaller index
    point = (face_points_[face_left_of_.at({edge.first, edge.second})] +
             face_points_[face_left_of_.at({edge.second, edge.first})]) /
            2.0;
  }
  std::set<int32_t> used(cage.face_vertices.begin(), cage.face_vertices.end());
  for (int32_t v = 0; v < cage.vertex_count(); ++v) {
    if (!used.count(v)) corners_[v] = cage.positions[v];
  }
}

void QuadSplitOracle::split(const std::vector<std::vector<int32_t>>& polygons) {
  const int32_t face_vertex = vertex_count_;
  vertex_count_ += int32_t(polygons.size());
  edge_vertices_.clear();
  faces_.clear();
  face_left_of_.clear();
  for (const auto& face : polygons) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Edge edge = undirected(face[i], face[(i + 1) % face.size()]);
      if (edge_vertices_.try_emplace(edge, vertex_count_).second) ++vertex_count_;
    }
  }
  for (std::size_t f = 0; f < polygons.size(); ++f) {
    const auto& face = polygons[f];
    const std::size_t m = face.size();
    for (std::size_t i = 0; i < m; ++i) {
      const std::array<int32_t, 4> child{
          face[i], edge_vertices_.at(undirected(face[i], face[(i + 1) % m])),
          face_vertex + int32_t(f), edge_vertices_.at(undirected(face[(i + m - 1) % m], face[i]))};
      for (int k = 0; k < 4; ++k) {
        face_left_of_[{child[k], child[(k + 1) % 4]}] = int32_t(faces_.size());
      }
      faces_.push_back(child);
    }
  }
}

void QuadSplitOracle::find_corners(const PolygonMesh& cage, BoundaryRule boundary,
                                   std::span<const dvec3> rest) {
  const std::span<const dvec3> pose = rest.empty() ? cage.positions : rest;
  std::set<int32_t> tagged;
  for (const CornerVertex& corner : cage.corners) {
    if (corner.sharpness >= kInfiniteSharpness) tagged.insert(corner.vertex);
  }
  std::vector<double> angle_of_face;  // of the base corner that a level-1 face is the child of
  std::map<int32_t, int> face_count;
  for (const auto& face : faces_of(cage)) {
    std::vector<dvec3> polygon;
    for (int32_t v : face) polygon.push_back(pose[v]);
    for (std::size_t i = 0; i < face.size(); ++i) {
      angle_of_face.push_back(interior_angle(polygon, i));
      ++face_count[face[i]];
    }
  }
  for (const auto& [v, count] : face_count) {
    const bool single = boundary == BoundaryRule::EdgeAndCorner && count == 1;
    if (sharp_at_[v].size() >= 3 || tagged.count(v) || single) corners_[v] = cage.positions[v];
  }
  find_sectors();
  for (const auto& [v, position] : corners_) {
    for (const Sector& sector : sectors_.at(v)) {
      double angle = 0;
      for (int32_t q : sector.faces) angle += angle_of_face[q];
      corner_sectors_[v].push_back(std::abs(angle - kPi) <= kPi / 6 ? CornerSector::HalfPlane
                                   : angle > kPi                    ? CornerSector::Reflex
                                                                    : CornerSector::Convex);
    }
  }
}

VertexKind QuadSplitOracle::kind(int32_t vertex) const {
  if (corners_.count(vertex)) return VertexKind::Corner;
  const auto sharp = sharp_at_.find(vertex);
  const std::size_t s = sharp == sharp_at_.end() ? 0 : sharp->second.size();
  return s == 0 ? VertexKind::Smooth : s == 1 ? VertexKind::Dart : VertexKind::Crease;
}

// Faces around `vertex` counter-clockwise from `start`, up to the next sharp edge or, at smooth
// and dart vertices, all around.
std::vector<int32_t> QuadSplitOracle::faces_from(int32_t vertex, int32_t start) const {
  const VertexKind vertex_kind = kind(vertex);
  const bool ring = vertex_kind == VertexKind::Smooth || vertex_kind == VertexKind::Dart;
  std::vector<int32_t> result{start};
  for (;;) {
    const int32_t neighbour = before(faces_[result.back()], vertex);
    if (!ring && curve_points_.count(undirected(vertex, neighbour))) return result;
    const int32_t next = face_left_of_.at({vertex, neighbour});
    if (next == start) return result;
    result.push_back(next);
  }
}

void QuadSplitOracle::find_sectors() {
  sectors_.clear();
  for (std::size_t q = 0; q < faces_.size(); ++q) {
    for (int32_t v : faces_[q]) {
      const VertexKind vertex_kind = kind(v);
      if (vertex_kind == VertexKind::Smooth || vertex_kind == VertexKind::Dart) {
        auto& sectors = sectors_[v];
        if (sectors.empty()) sectors.push_back({faces_from(v, int32_t(q)), true});
        continue;
      }
      if (sharp_at_.count(v) == 0) {
        throw std::invalid_argument("a tagged vertex without sharp edges has no rule");
      }
      const Edge first = undirected(v, after(faces_[q], v));
      if (!curve_points_.count(first)) continue;
      Sector sector{faces_from(v, int32_t(q)), false, first};
      sector.last = undirected(v, before(faces_[sector.faces.back()], v));
      sectors_[v].push_back(sector);
    }
  }
}

std::size_t QuadSplitOracle::sector_of(int32_t vertex, int32_t q) const {
  const auto& sectors = sectors_.at(vertex);
  for (std::size_t s = 0; s < sectors.size(); ++s) {
    if (std::count(sectors[s].faces.begin(), sectors[s].faces.end(), q)) return s;
  }
  throw std::invalid_argument("the face is not at the vertex");
}

dvec3 QuadSplitOracle::limit_point(int32_t vertex) const {
  if (const auto at = corners_.find(vertex); at != corners_.end()) return at->second;
  dvec3 sum(0.0);
  if (kind(vertex) == VertexKind::Crease) {
    for (const Edge& edge : sharp_at_.at(vertex)) sum += curve_points_.at(edge) / 2.0;
    return sum;
  }
  const auto& ring = sectors_.at(vertex).front().faces;
  for (int32_t q : ring) sum += face_points_[q];
  return sum / double(ring.size());
}

// The points b_i of a sector that is not a ring.
std::vector<dvec3> QuadSplitOracle::frame(int32_t vertex, std::size_t index) const {
  const Sector& sector = sectors_.at(vertex)[index];
  const dvec3 w0 = curve_points_.at(sector.first), w1 = curve_points_.at(sector.last);
  const auto count = int(sector.faces.size());
  const auto k = double(count);
  const bool corner = corners_.count(vertex);
  const CornerSector form = corner ? corner_sectors_.at(vertex)[index] : CornerSector::HalfPlane;
  std::vector<dvec3> result;
  for (int i = 1; i <= count; ++i) {
    if (form == CornerSector::HalfPlane) {
      const double angle = kPi * (2 * i - 1) / (2 * k);
      result.push_back((w0 + w1) / 2.0 + std::sqrt(2.0) * std::cos(angle) * (w0 - w1) / 2.0);
      continue;
    }
    const double phi = form == CornerSector::Reflex ? 3 * kPi / 2 : kPi / 2, t = (i - 0.5) / k;
    const double g0 = std::sqrt(2.0) * std::sin((1 - t) * phi) / std::sin(phi);
    const double g1 = std::sqrt(2.0) * std::sin(t * phi) / std::sin(phi);
    const dvec3 v = corners_.at(vertex);
    result.push_back(v + g0 * (w0 - v) + g1 * (w1 - v));
  }
  return result;
}

// The child face points of a sector, in its order.
std::vector<dvec3> QuadSplitOracle::children(int32_t vertex, std::size_t index) const {
  const Sector& sector = sectors_.at(vertex)[index];
  std::vector<dvec3> x;
  for (int32_t q : sector.faces) x.push_back(face_points_[q]);
  if (sector.is_ring) return shrunk_polygon(weights_, x);
  const std::vector<dvec3> b = frame(vertex, index);
  const std::size_t k = x.size();
  const bool corner = corners_.count(vertex);
  const dvec3 centre = limit_point(vertex);
  std::vector<dvec3> result;
  if (corner && corner_sectors_.at(vertex)[index] != CornerSector::HalfPlane) {
    for (std::size_t i = 0; i < k; ++i) {
      result.push_back((b[i] + centre) / 2.0 + (x[i] - b[i]) / 4.0);
    }
    return result;
  }
  std::vector<dvec3> odd(2 * k);
  for (std::size_t i = 0; i < k; ++i) {
    odd[i] = x[i] - b[i];
    odd[2 * k - 1 - i] = b[i] - x[i];
  }
  // A ring of two lies outside the formulas for polygons; (3/4, 1/4) halves its odd part.
  const std::vector<dvec3> shrunk =
      k == 1 ? std::vector<dvec3>{0.75 * odd[0] + 0.25 * odd[1]} : shrunk_polygon(weights_, odd);
  for (std::size_t i = 0; i < k; ++i) result.push_back((b[i] + centre) / 2.0 + shrunk[i]);
  return result;
}

dvec3 QuadSplitOracle::mean_beside(Edge edge, int32_t end,
                                   const std::map<Corner, dvec3>& points) const {
  const int32_t other = other_end(edge, end);
  return (points.at({face_left_of_.at({end, other}), end}) +
          points.at({face_left_of_.at({other, end}), end})) /
         2.0;
}

dvec3 QuadSplitOracle::child_of_curve_point(Edge edge, int32_t end,
                                            const std::map<Corner, dvec3>& children) const {
  const dvec3 w = curve_points_.at(edge);
  if (const auto at = corners_.find(end); at != corners_.end()) return (w + at->second) / 2.0;
  if (kind(end) == VertexKind::Dart) return mean_beside(edge, end, children);
  const auto& both = sharp_at_.at(end);
  return (3.0 * w + curve_points_.at(both[0] == edge ? both[1] : both[0])) / 4.0;
}

void QuadSplitOracle::refine() {
  std::map<Corner, dvec3> child_points;
  for (const auto& [v, sectors] : sectors_) {
    for (std::size_t s = 0; s < sectors.size(); ++s) {
      const std::vector<dvec3> points = children(v, s);
      for (std::size_t i = 0; i < points.size(); ++i) {
        child_points[{sectors[s].faces[i], v}] = points[i];
      }
    }
  }
  std::map<std::pair<Edge, int32_t>, dvec3> curve_children;
  for (const auto& [edge, w] : curve_points_) {
    for (int32_t end : {edge.first, edge.second}) {
      curve_children[{edge, end}] = child_of_curve_point(edge, end, child_points);
    }
  }
  FaceList polygons;
  face_points_.clear();
  for (std::size_t q = 0; q < faces_.size(); ++q) {
    polygons.emplace_back(faces_[q].begin(), faces_[q].end());
    for (int32_t v : faces_[q]) face_points_.push_back(child_points.at({int32_t(q), v}));
  }
  split(polygons);
  curve_points_.clear();
  sharp_at_.clear();
  for (const auto& [key, w] : curve_children) {
    const auto& [edge, end] = key;
    const int32_t middle = edge_vertices_.at(edge);
    curve_points_[undirected(end, middle)] = w;
    sharp_at_[end].push_back(undirected(end, middle));
    sharp_at_[middle].push_back(undirected(end, middle));
  }
  // The order of a corner's sectors follows the order of faces, which a split keeps.
  find_sectors();
}

std::pair<dvec3, dvec3> QuadSplitOracle::tangents(int32_t vertex, std::size_t index) const {
  const Sector& sector = sectors_.at(vertex)[index];
  const auto k = sector.faces.size();
  dvec3 t1(0.0), t2(0.0);
  if (sector.is_ring) {
    for (std::size_t i = 0; i < k; ++i) {
      t1 += std::cos(2 * kPi * double(i) / double(k)) * face_points_[sector.faces[i]];
      t2 += std::sin(2 * kPi * double(i) / double(k)) * face_points_[sector.faces[i]];
    }
    return {t1, t2};
  }
  const dvec3 w0 = curve_points_.at(sector.first), w1 = curve_points_.at(sector.last);
  if (const auto at = corners_.find(vertex); at != corners_.end()) {
    const CornerSector form = corner_sectors_.at(vertex)[index];
    if (form == CornerSector::Convex) return {w0 - at->second, w1 - at->second};
    if (form == CornerSector::Reflex) return {w1 - at->second, w0 - at->second};
  }
  const std::vector<dvec3> b = frame(vertex, index);
  for (std::size_t i = 0; i < k; ++i) {
    const double angle = kPi * (2 * double(i) + 1) / (2 * double(k));
    t2 += std::sin(angle) * (face_points_[sector.faces[i]] - b[i]);
  }
  return {w0 - w1, t2};
}

dvec3 QuadSplitOracle::normal(int32_t vertex, std::size_t sector) const {
  const auto [t1, t2] = tangents(vertex, sector);
  return glm::normalize(glm::cross(t1, t2));
}

}  // namespace planish::test
