#include "planish/doosabin/vertex_ring.h"

#include <algorithm>

#include "planish/core/assert.h"

namespace planish {

namespace {

// The curve control point of the half of sharp edge `sharp` at `vertex`.
std::int32_t curve_point(const Subdivision& subdivision, std::int32_t edge, std::int32_t sharp,
                         std::int32_t vertex) {
  const bool is_first_end = subdivision.topology().edge_vertices(edge).first == vertex;
  return subdivision.first_sharp() + 2 * sharp + (is_first_end ? 0 : 1);
}

void gather_around_face(const MeshTopology& topology, std::int32_t face, VertexRing& ring) {
  for (std::int32_t i = 0; i < topology.face_size(face); ++i)
    ring.faces.push_back(topology.first_corner(face) + i);
}

void gather_around_edge(const Subdivision& subdivision, std::int32_t edge, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  const std::int32_t sharp = subdivision.sharp_of_edge(edge);
  if (sharp >= 0) ring.kind = VertexKind::Crease;
  const std::int32_t own = topology.corner_of(edge);
  const int side_count = topology.is_boundary_edge(edge) ? 1 : 2;
  for (int side = 0; side < side_count; ++side) {
    // A face runs along the edge from its corner to the next: seen from the edge's midpoint, the
    // corner at the far end comes first.
    const std::int32_t tail = side == 0 ? own : topology.twin(own), head = topology.next(tail);
    ring.faces.push_back(head);
    ring.faces.push_back(tail);
    if (sharp < 0) continue;
    ring.sectors.push_back({2 * side, 2,
                            curve_point(subdivision, edge, sharp, topology.vertex_of(head)),
                            curve_point(subdivision, edge, sharp, topology.vertex_of(tail))});
  }
}

// Sectors of a vertex whose faces are gathered; turns the ring so that a sector begins at its
// first face.
void gather_sectors(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  const auto sharp_of = [&](std::int32_t edge) { return subdivision.sharp_of_edge(edge); };
  const auto first = std::ranges::find_if(
      ring.faces, [&](std::int32_t corner) { return sharp_of(topology.edge_of(corner)) >= 0; });
  if (first == ring.faces.end()) return;  // a tagged vertex in a smooth neighbourhood
  std::ranges::rotate(ring.faces, first);
  if (ring.kind == VertexKind::Dart) {
    ring.dart_face = 0;
    return;
  }
  for (std::size_t k = 0; k < ring.faces.size(); ++k) {
    const std::int32_t leading = topology.edge_of(ring.faces[k]);
    const std::int32_t trailing = topology.edge_of(topology.prev(ring.faces[k]));
    const std::int32_t sharp = sharp_of(leading), trailing_sharp = sharp_of(trailing);
    if (sharp >= 0) {
      ring.sectors.push_back(
          {static_cast<std::int32_t>(k), 0, curve_point(subdivision, leading, sharp, vertex), -1});
      if (ring.kind == VertexKind::Corner) {
        ring.sectors.back().corner =
            subdivision.features().corner_sectors.at(SharpFeatures::sector_key(vertex, sharp));
      }
    }
    VertexRing::Sector& sector = ring.sectors.back();
    ++sector.count;
    if (trailing_sharp >= 0)
      sector.curve1 = curve_point(subdivision, trailing, trailing_sharp, vertex);
  }
  for (const VertexRing::Sector& sector : ring.sectors) PLANISH_ASSERT(sector.curve1 >= 0);
}

void gather_around_vertex(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const auto corners = subdivision.topology().corners_at(vertex);
  ring.faces.assign(corners.begin(), corners.end());
  const SharpFeatures& features = subdivision.features();
  ring.kind = features.vertex_kinds[vertex];
  if (ring.kind == VertexKind::Smooth) return;
  if (ring.kind == VertexKind::Corner)
    ring.corner_point = subdivision.first_corner() + features.corner_of_vertex[vertex];
  if (subdivision.has_sharp_edges()) gather_sectors(subdivision, vertex, ring);
}

}  // namespace

void gather_ring(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  ring.kind = VertexKind::Smooth;
  ring.faces.clear();
  ring.sectors.clear();
  ring.corner_point = ring.dart_face = -1;
  const std::int32_t first_face = topology.vertex_count();
  const std::int32_t first_edge = first_face + topology.face_count();
  if (vertex < first_face) {
    gather_around_vertex(subdivision, vertex, ring);
  } else if (vertex < first_edge) {
    gather_around_face(topology, vertex - first_face, ring);
  } else {
    gather_around_edge(subdivision, vertex - first_edge, ring);
  }
}

}  // namespace planish
