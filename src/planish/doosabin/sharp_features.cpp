// Creases, corners and darts for Doo-Sabin surfaces: sharp edges cut the faces around a vertex
// into sectors that are continued each by its own rule; a derivation of our own after Nasri,
// "Polyhedral subdivision methods for free-form surfaces", 1987, for boundaries.
#include "planish/doosabin/sharp_features.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <unordered_map>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/mesh/area_vector.h"

namespace planish {

namespace {

// A T-junction or a tagged vertex on a straight boundary is rarely straight to the last bit; up
// to 30 degrees off, the half-plane rule still gives the better-shaped sector.
constexpr double kStraightAngleTolerance = std::numbers::pi / 6.0;

// Of faces; those of large ones are kept, as many of their corners may ask.
class FaceAreas {
 public:
  FaceAreas(const PolygonMesh& of_mesh, std::span<const glm::dvec3> at_positions)
      : mesh(of_mesh), positions(at_positions) {}

  [[nodiscard]] glm::dvec3 of(std::int32_t face) {
    if (mesh.face_size(face) < kKeptSize) return area_vector(positions, mesh.face(face));
    const auto [place, is_new] = kept_.try_emplace(face);
    if (is_new) place->second = area_vector(positions, mesh.face(face));
    return place->second;
  }

  const PolygonMesh& mesh;
  std::span<const glm::dvec3> positions;

 private:
  static constexpr std::int32_t kKeptSize = 32;
  std::unordered_map<std::int32_t, glm::dvec3> kept_;
};

// Interior angle of a face at its corner, in [0, 2 pi): more than pi where the face is concave.
double interior_angle(FaceAreas& areas, std::int32_t face, std::int32_t corner) {
  const auto vertices = areas.mesh.face(face);
  const auto positions = areas.positions;
  const std::size_t m = vertices.size();
  const glm::dvec3& apex = positions[vertices[corner]];
  const glm::dvec3 next = positions[vertices[(corner + 1) % m]] - apex;
  const glm::dvec3 previous = positions[vertices[(corner + m - 1) % m]] - apex;
  const glm::dvec3 turn = glm::cross(next, previous);
  const double angle = std::atan2(glm::length(turn), glm::dot(next, previous));
  return glm::dot(turn, areas.of(face)) < 0 ? 2.0 * std::numbers::pi - angle : angle;
}

CornerSector classify_angle(double angle) {
  if (std::abs(angle - std::numbers::pi) <= kStraightAngleTolerance) return CornerSector::HalfPlane;
  return angle > std::numbers::pi ? CornerSector::Reflex : CornerSector::Convex;
}

// Where an edge is tagged twice, the later tag holds, as in OpenSubdiv.
std::vector<std::uint8_t> tagged_edges(const PolygonMesh& mesh, const MeshTopology& topology) {
  if (mesh.creases.empty()) return {};
  std::vector<std::uint8_t> tagged(static_cast<std::size_t>(topology.edge_count()), 0);
  for (const CreaseEdge& crease : mesh.creases) {
    const std::int32_t edge = topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0) tagged[edge] = crease.sharpness >= kInfiniteSharpness ? 1 : 0;
  }
  return tagged;
}

void number_sharp_edges(const PolygonMesh& mesh, const MeshTopology& topology, bool use_tags,
                        SharpFeatures& features) {
  const std::vector<std::uint8_t> tagged =
      use_tags ? tagged_edges(mesh, topology) : std::vector<std::uint8_t>();
  const auto count = static_cast<std::size_t>(topology.edge_count());
  const auto is_boundary = [&](std::int32_t e) { return topology.is_boundary_edge(e); };
  const auto is_sharp = [&](std::size_t e) {
    return (!tagged.empty() && tagged[e] != 0) || is_boundary(e);
  };
  const SelectedBlocks blocks = count_selected(count, is_sharp);
  features.sharp_edge_count = blocks.total;
  if (blocks.total == 0) return;
  features.interior_sharp_edge_count = blocks.total - count_selected(count, is_boundary).total;
  features.sharp_of_edge.assign(count, -1);
  for_selected(count, blocks, is_sharp,
               [&](std::size_t e, std::int32_t number) { features.sharp_of_edge[e] = number; });
}

VertexKind kind_by_edges(const MeshTopology& topology, const SharpFeatures& features,
                         std::int32_t vertex) {
  int sharp = 0;
  const auto corners = topology.corners_at(vertex);
  for (const std::int32_t corner : corners)
    sharp += features.sharp_of_edge[topology.edge_of(corner)] >= 0 ? 1 : 0;
  if (topology.is_boundary_vertex(vertex)) ++sharp;  // the last corner's trailing edge
  return static_cast<VertexKind>(std::min(sharp, 3));
}

void classify_vertices(const PolygonMesh& mesh, const MeshTopology& topology,
                       const SharpFeatureOptions& options, SharpFeatures& features) {
  features.vertex_kinds.assign(static_cast<std::size_t>(mesh.vertex_count()), VertexKind::Smooth);
  if (features.sharp_edge_count > 0) {
    parallel_each(features.vertex_kinds.size(), [&](std::int32_t vertex) {
      features.vertex_kinds[vertex] = kind_by_edges(topology, features, vertex);
      if (options.boundary == BoundaryRule::EdgeAndCorner && topology.is_boundary_vertex(vertex) &&
          topology.corners_at(vertex).size() == 1) {
        features.vertex_kinds[vertex] = VertexKind::Corner;
      }
    });
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
void classify_sectors(const MeshTopology& topology, std::int32_t vertex, FaceAreas& areas,
                      SharpFeatures& features) {
  const auto corners = topology.corners_at(vertex);
  const std::size_t n = corners.size();
  const auto leading_sharp_edge = [&](std::size_t i) {
    return features.sharp_of_edge[topology.edge_of(corners[i])];
  };
  std::size_t first = 0;
  while (first < n && leading_sharp_edge(first) < 0) ++first;
  if (first == n) return;  // a tagged vertex without sharp edges has no sectors
  std::int32_t sector = -1;
  double angle = 0;
  const auto close_sector = [&] {
    if (sector >= 0) {
      features.corner_sectors[SharpFeatures::sector_key(vertex, sector)] = classify_angle(angle);
    }
  };
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (first + k) % n;
    if (leading_sharp_edge(i) >= 0) {
      close_sector();
      sector = leading_sharp_edge(i);
      angle = 0;
    }
    angle += interior_angle(areas, topology.face_of(corners[i]), topology.place_of(corners[i]));
  }
  close_sector();
}

}  // namespace

SharpFeatures find_sharp_features(const PolygonMesh& mesh, const MeshTopology& topology,
                                  std::span<const glm::dvec3> rest_positions,
                                  const SharpFeatureOptions& options) {
  PLANISH_ASSERT(rest_positions.size() == mesh.positions.size());
  SharpFeatures features;
  number_sharp_edges(mesh, topology, options.use_tags, features);
  classify_vertices(mesh, topology, options, features);
  FaceAreas areas(mesh, rest_positions);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (features.vertex_kinds[v] != VertexKind::Corner) continue;
    if (features.corner_of_vertex.empty()) {
      features.corner_of_vertex.assign(static_cast<std::size_t>(mesh.vertex_count()), -1);
    }
    features.corner_of_vertex[v] = features.corner_count++;
    features.corner_vertices.push_back(v);
    if (features.sharp_edge_count > 0) classify_sectors(topology, v, areas, features);
  }
  return features;
}

}  // namespace planish
