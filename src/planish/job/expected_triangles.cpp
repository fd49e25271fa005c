#include "planish/job/expected_triangles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "planish/mesh/area_vector.h"
#include "planish/mesh/placement.h"

namespace planish {
namespace {

// Triangles that surfaces took for each one counted here: of meshes of quads 0.8 to 5, of meshes
// of triangles, whose surfaces ripple, 6 to 11.
constexpr double kOfQuads = 6, kOfTriangles = 12;

// In radians, by edge; 0 at boundaries and where the surface is sharp.
std::vector<double> turns_at_edges(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                   const std::vector<glm::dvec3>& normals) {
  const MeshTopology& topology = *prepared.topology;
  std::set<std::pair<std::int32_t, std::int32_t>> sharp;
  for (const CreaseEdge& crease : mesh.creases) sharp.insert(std::minmax(crease.v0, crease.v1));
  std::vector<double> turns(static_cast<std::size_t>(topology.edge_count()));
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    const auto [v0, v1] = topology.edge_vertices(e);
    if (twin < 0 || sharp.contains(std::minmax(prepared.vertices[v0], prepared.vertices[v1])))
      continue;
    const double cosine =
        glm::dot(normals[topology.face_of(corner)], normals[topology.face_of(twin)]);
    turns[e] = std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return turns;
}

}  // namespace

double expected_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared,
                          const Fineness& fineness) {
  const MeshTopology& topology = *prepared.topology;
  const double chord = fineness.chord_error * placement_of(mesh).diagonal;
  const double angle = fineness.angle * std::numbers::pi / 180;
  std::vector<glm::dvec3> normals;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const glm::dvec3 area = area_vector(mesh.positions, mesh.face(f));
    const double length = glm::length(area);
    normals.push_back(length > 0 ? area / length : glm::dvec3(0.0));
  }
  const std::vector<double> turns = turns_at_edges(mesh, prepared, normals);
  double sum = 0;
  std::vector<double> cuts;  // of the way to each edge of the face at hand
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto edges = topology.face_edges(f);
    const auto position = [&](std::size_t i) { return mesh.positions[face[i % face.size()]]; };
    glm::dvec3 middle(0.0);
    for (std::size_t i = 0; i < face.size(); ++i) middle += position(i);
    middle /= static_cast<double>(face.size());
    cuts.clear();
    for (std::size_t i = 0; i < face.size(); ++i) {
      const double turn = turns[edges[i]] / 2;
      const double way = glm::length((position(i) + position(i + 1)) / 2.0 - middle);
      // An arc that turns by `turn` rises by an eighth of it over its length.
      const double by_chord = chord > 0 ? std::sqrt(way * turn / (8 * chord)) : 0;
      cuts.push_back(std::max(by_chord, angle > 0 ? turn / angle : 0));
    }
    const double share = face.size() == 3 ? kOfTriangles : kOfQuads;
    double count = static_cast<double>(face.size() - 2);
    if (std::ranges::max(cuts) >= 0.5) {
      count = 0;
      for (std::size_t i = 0; i < cuts.size(); ++i)
        count += 2 * std::pow(std::max({1.0, cuts[i], cuts[(i + 1) % cuts.size()]}), 2);
    }
    sum += share * count;
  }
  return sum;
}

}  // namespace planish
