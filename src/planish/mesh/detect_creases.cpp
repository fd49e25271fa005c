#include "planish/mesh/detect_creases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/area_vector.h"

namespace planish {

namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kRightAngle = std::numbers::pi / 2;

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

// Whether the angle is less than the one of that slope without any doubt by rounding: most are, and
// need no arctangent.
bool is_flatter(const glm::dvec3& a, const glm::dvec3& b, double slope) {
  constexpr double kMargin = 1 - 1e-9;
  const glm::dvec3 turn = glm::cross(a, b);
  const double along = glm::dot(a, b);
  return along > 0 && glm::dot(turn, turn) < kMargin * slope * slope * along * along;
}

using VertexPair = std::pair<std::int32_t, std::int32_t>;

std::set<VertexPair> tagged_edges(const PolygonMesh& mesh) {
  std::set<VertexPair> tagged;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness >= kInfiniteSharpness) tagged.insert(std::minmax(crease.v0, crease.v1));
  }
  return tagged;
}

std::vector<glm::dvec3> face_normals(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> normals(static_cast<std::size_t>(mesh.face_count()));
  parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f)
      normals[f] = area_vector(mesh.positions, mesh.face(static_cast<std::int32_t>(f)));
  });
  return normals;
}

// By lower vertex, then by higher.
std::vector<Edge> sharp_edges(const PolygonMesh& mesh, const MeshTopology& topology,
                              double dihedral) {
  const std::vector<glm::dvec3> normals = face_normals(mesh);
  const std::set<VertexPair> tagged = tagged_edges(mesh);
  const double slope = dihedral < kRightAngle ? std::tan(dihedral) : 0;
  const auto ends_of = [&](std::int32_t edge) {
    const auto [v0, v1] = topology.edge_vertices(edge);
    return VertexPair(std::minmax(v0, v1));
  };
  enum : std::uint8_t { Smooth, Found, Given };
  RawVector<std::uint8_t> kinds(static_cast<std::size_t>(topology.edge_count()));
  parallel_for(kinds.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const auto edge = static_cast<std::int32_t>(e);
      if (topology.is_boundary_edge(edge) || (!tagged.empty() && tagged.contains(ends_of(edge)))) {
        kinds[e] = Given;
        continue;
      }
      const std::int32_t corner = topology.corner_of(edge);
      const glm::dvec3& a = normals[topology.face_of(corner)];
      const glm::dvec3& b = normals[topology.face_of(topology.twin(corner))];
      kinds[e] = !is_flatter(a, b, slope) && angle_between(a, b) > dihedral ? Found : Smooth;
    }
  });
  const auto is_sharp = [&](std::size_t e) { return kinds[e] != Smooth; };
  const SelectedBlocks blocks = count_selected(kinds.size(), is_sharp);
  std::vector<Edge> edges(static_cast<std::size_t>(blocks.total));
  for_selected(kinds.size(), blocks, is_sharp, [&](std::size_t e, std::int32_t number) {
    const auto [lower, higher] = ends_of(static_cast<std::int32_t>(e));
    edges[number] = {lower, higher, kinds[e] == Given};
  });
  std::ranges::sort(edges, {}, [](const Edge& edge) { return VertexPair(edge.v0, edge.v1); });
  return edges;
}

}  // namespace

void detect_creases(PolygonMesh& mesh, const MeshTopology& topology,
                    const CreaseDetectionOptions& options) {
  require_angle(options.dihedral_degrees, "crease");
  require_angle(options.corner_degrees, "corner");
  std::vector<Edge> edges = sharp_edges(mesh, topology, options.dihedral_degrees * kRadians);

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
  const auto is_found = [&](const VertexPair& ends) {
    const auto place = std::ranges::lower_bound(
        edges, ends, {}, [](const Edge& edge) { return VertexPair(edge.v0, edge.v1); });
    return place != edges.end() && VertexPair(place->v0, place->v1) == ends;
  };
  std::erase_if(mesh.creases, [&](const CreaseEdge& crease) {
    return crease.sharpness < kInfiniteSharpness && is_found(std::minmax(crease.v0, crease.v1));
  });
  // The other ends of the first two sharp edges at each vertex, in the order of the edges.
  std::vector<std::array<std::int32_t, 2>> neighbours(mesh.positions.size());
  std::vector<std::int32_t> count_at(mesh.positions.size(), 0);
  const auto add_neighbour = [&](std::int32_t vertex, std::int32_t other) {
    if (count_at[vertex] < 2) neighbours[vertex][count_at[vertex]] = other;
    ++count_at[vertex];
  };
  for (const Edge& edge : edges) {
    if (!edge.given) mesh.creases.push_back({edge.v0, edge.v1, kInfiniteSharpness});
    add_neighbour(edge.v0, edge.v1);
    add_neighbour(edge.v1, edge.v0);
  }
  std::set<std::int32_t> tagged_corners;
  for (const CornerVertex& corner : mesh.corners) tagged_corners.insert(corner.vertex);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (count_at[v] != 2) continue;
    const glm::dvec3 in = mesh.positions[v] - mesh.positions[neighbours[v][0]];
    const glm::dvec3 out = mesh.positions[neighbours[v][1]] - mesh.positions[v];
    if (!tagged_corners.contains(v) && angle_between(in, out) > options.corner_degrees * kRadians) {
      mesh.corners.push_back({v, kInfiniteSharpness});
    }
  }
}

PolygonMesh with_detected_creases(const PolygonMesh& mesh, const CreaseDetectionOptions& options) {
  PolygonMesh result = mesh;
  detect_creases(result, MeshTopology(mesh), options);
  return result;
}

}  // namespace planish
