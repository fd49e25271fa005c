// Creases, corners and darts for Doo-Sabin surfaces: sharp edges cut the faces around a vertex
// into sectors that are continued each by its own rule; a derivation of our own after Nasri,
// "Polyhedral subdivision methods for free-form surfaces", 1987, for boundaries.
#include "planish/doosabin/sharp_features.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/assert.h"
#include "planish/mesh/area_vector.h"

namespace planish {

namespace {

using OpenSubdiv::Far::ConstIndexArray;
using OpenSubdiv::Far::ConstLocalIndexArray;
using OpenSubdiv::Far::TopologyLevel;

// A T-junction or a tagged vertex on a straight boundary is rarely straight to the last bit; up
// to 30 degrees off, the half-plane rule still gives the better-shaped sector.
constexpr double kStraightAngleTolerance = std::numbers::pi / 6.0;

// Interior angle of a face at its corner, in [0, 2 pi): more than pi where the face is concave.
double interior_angle(const PolygonMesh& mesh, std::int32_t face, std::int32_t corner,
                      std::span<const glm::dvec3> positions) {
  const auto vertices = mesh.face(face);
  const std::size_t m = vertices.size();
  const glm::dvec3& apex = positions[vertices[corner]];
  const glm::dvec3 next = positions[vertices[(corner + 1) % m]] - apex;
  const glm::dvec3 previous = positions[vertices[(corner + m - 1) % m]] - apex;
  const glm::dvec3 turn = glm::cross(next, previous);
  const double angle = std::atan2(glm::length(turn), glm::dot(next, previous));
  return glm::dot(turn, area_vector(positions, vertices)) < 0 ? 2.0 * std::numbers::pi - angle
                                                              : angle;
}

CornerSector classify_angle(double angle) {
  if (std::abs(angle - std::numbers::pi) <= kStraightAngleTolerance) return CornerSector::HalfPlane;
  return angle > std::numbers::pi ? CornerSector::Reflex : CornerSector::Convex;
}

void number_sharp_edges(const TopologyLevel& base, bool use_tags, SharpFeatures& features) {
  features.sharp_of_edge.assign(static_cast<std::size_t>(base.GetNumEdges()), -1);
  for (int e = 0; e < base.GetNumEdges(); ++e) {
    const bool boundary = base.IsEdgeBoundary(e);
    const bool tagged = use_tags && base.GetEdgeSharpness(e) >= kInfiniteSharpness;
    if (!boundary && !tagged) continue;
    features.sharp_of_edge[e] = features.sharp_edge_count++;
    if (!boundary) ++features.interior_sharp_edge_count;
  }
  if (features.sharp_edge_count == 0) features.sharp_of_edge = {};
}

void classify_vertices(const PolygonMesh& mesh, const TopologyLevel& base,
                       const SharpFeatureOptions& options, SharpFeatures& features) {
  std::vector<std::uint8_t> sharp_edges(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (std::size_t e = 0; e < features.sharp_of_edge.size(); ++e) {
    if (features.sharp_of_edge[e] < 0) continue;
    for (const int v : {base.GetEdgeVertices(static_cast<int>(e))[0],
                        base.GetEdgeVertices(static_cast<int>(e))[1]}) {
      sharp_edges[v] = static_cast<std::uint8_t>(std::min(sharp_edges[v] + 1, 3));
    }
  }
  features.vertex_kinds.resize(sharp_edges.size());
  for (std::size_t v = 0; v < sharp_edges.size(); ++v) {
    features.vertex_kinds[v] = static_cast<VertexKind>(sharp_edges[v]);
    const int vertex = static_cast<int>(v);
    if (options.boundary == BoundaryRule::EdgeAndCorner && base.IsVertexBoundary(vertex) &&
        base.GetVertexFaces(vertex).size() == 1) {
      features.vertex_kinds[v] = VertexKind::Corner;
    }
  }
  if (options.use_tags) {
    for (const CornerVertex& corner : mesh.corners) {
      if (corner.sharpness >= kInfiniteSharpness) {
        features.vertex_kinds[corner.vertex] = VertexKind::Corner;
      }
    }
  }
}

// Walks the faces around a corner and sums the angles from one sharp edge to the next.
void classify_sectors(const PolygonMesh& mesh, const TopologyLevel& base, std::int32_t vertex,
                      std::span<const glm::dvec3> rest_positions, SharpFeatures& features) {
  const ConstIndexArray faces = base.GetVertexFaces(vertex);
  const ConstLocalIndexArray corners = base.GetVertexFaceLocalIndices(vertex);
  const int n = faces.size();
  const auto leading_sharp_edge = [&](int i) {
    return features.sharp_of_edge[base.GetFaceEdges(faces[i])[corners[i]]];
  };
  int first = 0;
  while (first < n && leading_sharp_edge(first) < 0) ++first;
  if (first == n) return;  // a tagged vertex without sharp edges has no sectors
  std::int32_t sector = -1;
  double angle = 0;
  const auto close_sector = [&] {
    if (sector >= 0) {
      features.corner_sectors[SharpFeatures::sector_key(vertex, sector)] = classify_angle(angle);
    }
  };
  for (int k = 0; k < n; ++k) {
    const int i = (first + k) % n;
    if (leading_sharp_edge(i) >= 0) {
      close_sector();
      sector = leading_sharp_edge(i);
      angle = 0;
    }
    angle += interior_angle(mesh, faces[i], corners[i], rest_positions);
  }
  close_sector();
}

}  // namespace

SharpFeatures find_sharp_features(const PolygonMesh& mesh, const QuadSplit& split,
                                  std::span<const glm::dvec3> rest_positions,
                                  const SharpFeatureOptions& options) {
  PLANISH_ASSERT(rest_positions.size() == mesh.positions.size());
  const TopologyLevel& base = split.level(0);
  SharpFeatures features;
  number_sharp_edges(base, options.use_tags, features);
  classify_vertices(mesh, base, options, features);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (features.vertex_kinds[v] != VertexKind::Corner) continue;
    if (features.corner_of_vertex.empty()) {
      features.corner_of_vertex.assign(static_cast<std::size_t>(mesh.vertex_count()), -1);
    }
    features.corner_of_vertex[v] = features.corner_count++;
    features.corner_vertices.push_back(v);
    if (features.sharp_edge_count > 0) classify_sectors(mesh, base, v, rest_positions, features);
  }
  return features;
}

}  // namespace planish
