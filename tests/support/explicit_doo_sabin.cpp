// Based on: Doo & Sabin, Behaviour of recursive division surfaces near extraordinary points, 1978.

#include "support/explicit_doo_sabin.h"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;
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

}  // namespace planish::test
