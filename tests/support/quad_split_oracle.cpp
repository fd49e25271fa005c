#include "support/quad_split_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <stdexcept>

#include "support/explicit_doo_sabin.h"
#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;
using std::int32_t;

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
