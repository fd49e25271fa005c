#include "planish/mesh/detect_creases.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/edge_groups.h"

namespace planish {

namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

struct Edge {
  std::int32_t v0, v1;
  bool given;  // tagged as sharp by the mesh, or a boundary: stays
};

void require_angle(double degrees, const char* name) {
  if (degrees >= 0 && degrees <= 180) return;
  throw Error(ErrorCode::InvalidArgument, std::string(name) + " angle " + std::to_string(degrees) +
                                              " is outside 0 to 180 degrees");
}

// Faces without area have no direction to compare.
double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  if (glm::length(a) == 0 || glm::length(b) == 0) return 0;
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

using VertexPair = std::pair<std::int32_t, std::int32_t>;

std::set<VertexPair> tagged_edges(const PolygonMesh& mesh) {
  std::set<VertexPair> tagged;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness >= kInfiniteSharpness) tagged.insert(std::minmax(crease.v0, crease.v1));
  }
  return tagged;
}

std::vector<Edge> sharp_edges(const PolygonMesh& mesh, double dihedral) {
  std::vector<glm::dvec3> normals(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    normals[f] = area_vector(mesh.positions, mesh.face(f));
  }
  const std::vector<std::uint8_t> all(normals.size(), 1);
  const std::set<VertexPair> tagged = tagged_edges(mesh);
  std::vector<Edge> edges;
  group_edges(mesh, all).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    const std::int32_t higher = sides.front().higher;
    const bool given = sides.size() < 2 || tagged.contains({lower, higher});
    if (given || angle_between(normals[sides[0].face], normals[sides[1].face]) > dihedral) {
      edges.push_back({lower, higher, given});
    }
  });
  return edges;
}

}  // namespace

PolygonMesh with_detected_creases(const PolygonMesh& mesh, const CreaseDetectionOptions& options) {
  require_angle(options.dihedral_degrees, "crease");
  require_angle(options.corner_degrees, "corner");
  std::vector<Edge> edges = sharp_edges(mesh, options.dihedral_degrees * kRadians);

  std::vector<std::int32_t> degree(mesh.positions.size(), 0);
  const auto count = [&](const Edge& edge, int by) {
    degree[edge.v0] += by;
    degree[edge.v1] += by;
  };
  for (const Edge& edge : edges) count(edge, 1);
  // A single edge between smooth surroundings is noise, not a feature.
  std::erase_if(edges, [&](const Edge& edge) {
    const bool lonely = !edge.given && degree[edge.v0] == 1 && degree[edge.v1] == 1;
    if (lonely) count(edge, -1);
    return lonely;
  });

  // Where an edge is found sharp, a lower sharpness of its own would speak against it.
  PolygonMesh result = mesh;
  std::set<VertexPair> found;
  for (const Edge& edge : edges) found.insert({edge.v0, edge.v1});
  std::erase_if(result.creases, [&](const CreaseEdge& crease) {
    return crease.sharpness < kInfiniteSharpness &&
           found.contains(std::minmax(crease.v0, crease.v1));
  });
  std::vector<std::vector<std::int32_t>> neighbours(mesh.positions.size());
  for (const Edge& edge : edges) {
    if (!edge.given) result.creases.push_back({edge.v0, edge.v1, kInfiniteSharpness});
    neighbours[edge.v0].push_back(edge.v1);
    neighbours[edge.v1].push_back(edge.v0);
  }
  std::set<std::int32_t> tagged_corners;
  for (const CornerVertex& corner : mesh.corners) tagged_corners.insert(corner.vertex);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (neighbours[v].size() != 2) continue;
    const glm::dvec3 in = mesh.positions[v] - mesh.positions[neighbours[v][0]];
    const glm::dvec3 out = mesh.positions[neighbours[v][1]] - mesh.positions[v];
    if (!tagged_corners.contains(v) && angle_between(in, out) > options.corner_degrees * kRadians) {
      result.corners.push_back({v, kInfiniteSharpness});
    }
  }
  return result;
}

}  // namespace planish
