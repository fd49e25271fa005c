#include "planish/fair/fair_topology.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/fair/fair_halo.h"

namespace planish {

namespace {

constexpr std::size_t kTopologyGrain = 4096;

void number_corners(const PolygonMesh& mesh, FairTopology& topology) {
  topology.vertex_count = mesh.vertex_count();
  topology.face_count = mesh.face_count();
  topology.face_offsets = mesh.face_offsets;
  topology.corner_vertices = mesh.face_vertices;
  topology.corner_count = static_cast<std::int32_t>(mesh.face_vertices.size());
}

// Writes the ring of one vertex, whose range of the ring arrays is known.
void write_ring(const VertexRing& ring, std::int32_t vertex, FairTopology& topology) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t n = topology.valence(vertex);
  bool regular = true;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t corner = ring.faces[i];
    const std::int32_t face = topology.corner_faces[corner];
    const std::int32_t face_first = topology.face_offsets[face];
    const std::int32_t face_end = topology.face_offsets[face + 1];
    topology.ring_corners[first + i] = corner;
    topology.ring_next[first + i] =
        topology.corner_vertices[corner + 1 == face_end ? face_first : corner + 1];
    topology.ring_previous[first + i] =
        topology.corner_vertices[corner == face_first ? face_end - 1 : corner - 1];
    topology.corner_ccw[corner] = ring.faces[i + 1 == n ? 0 : i + 1];
    topology.corner_cw[corner] = ring.faces[i == 0 ? n - 1 : i - 1];
    regular = regular && face_end - face_first == 4;
  }
  for (const VertexRing::Sector& sector : ring.sectors) {
    topology.corner_cw[ring.faces[sector.first]] = sector.curve0;
    topology.corner_ccw[ring.faces[sector.first + sector.count - 1]] = sector.curve1;
  }
  topology.is_regular[vertex] = regular;
}

void gather_rings(const Subdivision& subdivision, FairTopology& topology) {
  topology.corner_faces = subdivision.topology().corner_faces();
  topology.ring_offsets = subdivision.topology().corner_offsets();
  const auto vertex_count = static_cast<std::size_t>(topology.vertex_count);
  const auto corner_count = static_cast<std::size_t>(topology.corner_count);
  for (auto* array : {&topology.ring_corners, &topology.ring_next, &topology.ring_previous,
                      &topology.corner_ccw, &topology.corner_cw}) {
    *array = std::vector<std::int32_t>(corner_count);
  }
  topology.is_regular.resize(vertex_count);
  topology.kinds.resize(vertex_count);
  std::transform(subdivision.features().vertex_kinds.begin(),
                 subdivision.features().vertex_kinds.end(), topology.kinds.begin(),
                 [](VertexKind kind) { return static_cast<std::uint8_t>(kind); });
  parallel_for(vertex_count, kTopologyGrain, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t v = begin; v < end; ++v) {
      gather_ring(subdivision, static_cast<std::int32_t>(v), ring);
      write_ring(ring, static_cast<std::int32_t>(v), topology);
    }
  });
}

void gather_sharp_places(const Subdivision& subdivision, FairTopology& topology) {
  topology.corner_points = subdivision.features().corner_vertices;
  topology.sector_offsets.push_back(0);
  if (!subdivision.has_sharp_edges()) return;

  const MeshTopology& base = subdivision.topology();
  topology.curve_points.resize(2 *
                               static_cast<std::size_t>(subdivision.features().sharp_edge_count));
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const auto [v0, v1] =
        base.edge_vertices(subdivision.edge_of_sharp(static_cast<std::int32_t>(s / 2)));
    topology.curve_points[s] = {s % 2 == 0 ? v0 : v1, s % 2 == 0 ? v1 : v0, -1, -1};
  }

  VertexRing ring;
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
    const VertexKind kind = topology.kind(v);
    if (kind != VertexKind::Crease && kind != VertexKind::Dart) continue;
    gather_ring(subdivision, v, ring);
    if (kind == VertexKind::Dart) {
      for (const std::int32_t corner : base.corners_at(v)) {
        const std::int32_t edge = base.edge_of(corner);
        const std::int32_t sharp = subdivision.sharp_of_edge(edge);
        if (sharp < 0) continue;
        const int end = base.edge_vertices(edge).first == v ? 0 : 1;
        topology.curve_points[2 * sharp + end].corner_after = ring.faces[ring.dart_face];
        topology.curve_points[2 * sharp + end].corner_before =
            topology.corner_cw[ring.faces[ring.dart_face]];
      }
      continue;
    }
    if (topology.crease_of_vertex.empty()) {
      topology.crease_of_vertex.assign(static_cast<std::size_t>(topology.vertex_count), -1);
    }
    topology.crease_of_vertex[v] = static_cast<std::int32_t>(topology.crease_vertices.size());
    topology.crease_vertices.push_back(v);
    for (const VertexRing::Sector& sector : ring.sectors) {
      topology.sectors.push_back(
          {v, topology.ring_offsets[v] + sector.first, sector.count, sector.curve0, sector.curve1});
    }
    topology.sector_offsets.push_back(static_cast<std::int32_t>(topology.sectors.size()));
  }
}

void mark_near_curves(FairTopology& topology, FairHalo* halo) {
  std::vector<std::uint8_t>& near = topology.is_near_curve;
  near.resize(static_cast<std::size_t>(topology.vertex_count));
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) near[v] = !topology.has_polygon(v);
  if (!halo && std::find(near.begin(), near.end(), 1) == near.end()) return;
  constexpr int kEdges = 2;
  for (int edge = 0; edge < kEdges; ++edge) {
    if (halo) halo->exchange_vertices(near);
    const std::vector<std::uint8_t> last = near;
    for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
      const FairTopology::Ring ring = topology.ring(v);
      for (std::int32_t i = 0; i < ring.size(); ++i)
        near[v] |= last[ring.next[i]] | last[ring.previous[i]];
    }
  }
  if (halo) halo->exchange_vertices(near);
}

void gather_edges(const Subdivision& subdivision, FairTopology& topology) {
  const MeshTopology& base = subdivision.topology();
  const auto count = static_cast<std::size_t>(base.edge_count());
  const auto is_smooth = [&](std::int32_t e) { return subdivision.sharp_of_edge(e) < 0; };
  const SelectedBlocks blocks = count_selected(count, is_smooth);
  topology.edge_corners.resize(static_cast<std::size_t>(blocks.total));
  for_selected(count, blocks, is_smooth, [&](std::size_t e, std::int32_t number) {
    topology.edge_corners[number] = base.corner_of(static_cast<std::int32_t>(e));
  });
}

void fill_unit_circle(FairTopology& topology) {
  std::vector<bool> arises;
  const auto mark = [&](std::int32_t n) {
    if (static_cast<std::size_t>(n) >= arises.size())
      arises.resize(static_cast<std::size_t>(n) + 1);
    arises[n] = true;
  };
  for (std::int32_t f = 0; f < topology.face_count; ++f) mark(topology.face_size(f));
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) mark(topology.valence(v));

  FairTopology::UnitCircle& circle = topology.unit_circle;
  circle.offsets.assign(arises.size(), -1);
  for (std::size_t n = 0; n < arises.size(); ++n) {
    if (!arises[n]) continue;
    circle.offsets[n] = static_cast<std::int32_t>(circle.points.size());
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      circle.points.emplace_back(std::cos(angle), std::sin(angle));
    }
  }
}

}  // namespace

FairTopology make_fair_topology(const PolygonMesh& mesh, const Subdivision& subdivision,
                                FairHalo* halo) {
  FairTopology topology;
  topology.state_size = subdivision.state_size();
  number_corners(mesh, topology);
  gather_rings(subdivision, topology);
  gather_sharp_places(subdivision, topology);
  mark_near_curves(topology, halo);
  gather_edges(subdivision, topology);
  fill_unit_circle(topology);
  for (std::int32_t f = 0; f < topology.face_count; ++f)
    if (topology.face_size(f) >= topology.large_size) topology.large_faces.push_back(f);
  return topology;
}

}  // namespace planish
