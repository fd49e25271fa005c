#include "planish/doosabin/vertex_ring.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "planish/core/assert.h"

namespace planish {

namespace {

using OpenSubdiv::Far::ConstIndexArray;
using OpenSubdiv::Far::ConstLocalIndexArray;
using OpenSubdiv::Far::TopologyLevel;

// What a gatherer asks of the level above, whose faces' corners are this level's faces: of the
// mesh, and of OpenSubdiv's levels, where all faces are quads.
struct MeshParent {
  const MeshTopology& topology;

  [[nodiscard]] std::int32_t vertex_count() const { return topology.vertex_count(); }
  [[nodiscard]] std::int32_t face_count() const { return topology.face_count(); }
  [[nodiscard]] std::int32_t first_corner(std::int32_t face) const {
    return topology.first_corner(face);
  }
  [[nodiscard]] std::int32_t face_size(std::int32_t face) const { return topology.face_size(face); }
  [[nodiscard]] std::int32_t next(std::int32_t corner) const { return topology.next(corner); }
  [[nodiscard]] std::int32_t prev(std::int32_t corner) const { return topology.prev(corner); }
  [[nodiscard]] std::int32_t vertex_of(std::int32_t corner) const {
    return topology.vertex_of(corner);
  }
  [[nodiscard]] std::int32_t edge_of(std::int32_t corner) const { return topology.edge_of(corner); }
  [[nodiscard]] std::int32_t first_end(std::int32_t edge) const {
    return topology.edge_vertices(edge).first;
  }
  void append_corners_on(std::int32_t edge, std::vector<std::int32_t>& corners) const {
    corners.push_back(topology.corner_of(edge));
    if (!topology.is_boundary_edge(edge)) corners.push_back(topology.twin(corners.back()));
  }
  void append_corners_at(std::int32_t vertex, std::vector<std::int32_t>& corners) const {
    const auto around = topology.corners_at(vertex);
    corners.insert(corners.end(), around.begin(), around.end());
  }
};

struct QuadParent {
  const TopologyLevel& topology;

  [[nodiscard]] std::int32_t vertex_count() const { return topology.GetNumVertices(); }
  [[nodiscard]] std::int32_t face_count() const { return topology.GetNumFaces(); }
  [[nodiscard]] static std::int32_t first_corner(std::int32_t face) { return 4 * face; }
  [[nodiscard]] static std::int32_t face_size(std::int32_t) { return 4; }
  [[nodiscard]] static std::int32_t next(std::int32_t corner) {
    return (corner & ~3) | ((corner + 1) & 3);
  }
  [[nodiscard]] static std::int32_t prev(std::int32_t corner) {
    return (corner & ~3) | ((corner + 3) & 3);
  }
  [[nodiscard]] std::int32_t vertex_of(std::int32_t corner) const {
    return topology.GetFaceVertices(corner / 4)[corner % 4];
  }
  [[nodiscard]] std::int32_t edge_of(std::int32_t corner) const {
    return topology.GetFaceEdges(corner / 4)[corner % 4];
  }
  [[nodiscard]] std::int32_t first_end(std::int32_t edge) const {
    return topology.GetEdgeVertices(edge)[0];
  }
  void append_corners_on(std::int32_t edge, std::vector<std::int32_t>& corners) const {
    append(topology.GetEdgeFaces(edge), topology.GetEdgeFaceLocalIndices(edge), corners);
  }
  void append_corners_at(std::int32_t vertex, std::vector<std::int32_t>& corners) const {
    append(topology.GetVertexFaces(vertex), topology.GetVertexFaceLocalIndices(vertex), corners);
  }
  static void append(const ConstIndexArray& faces, const ConstLocalIndexArray& places,
                     std::vector<std::int32_t>& corners) {
    for (int k = 0; k < faces.size(); ++k) corners.push_back(4 * faces[k] + places[k]);
  }
};

template <class Parent>
struct Gatherer {
  const Subdivision& subdivision;
  int parent_level;
  Parent parent;
  std::int32_t first_sharp;  // of this level's state
  std::int32_t first_corner;

  void around(std::int32_t vertex, VertexRing& ring) const {
    const std::int32_t vertex_count = parent.vertex_count(), face_count = parent.face_count();
    if (vertex < vertex_count) {
      around_vertex(vertex, ring);
    } else if (vertex < vertex_count + face_count) {
      around_face(vertex - vertex_count, ring);
    } else {
      around_edge(vertex - vertex_count - face_count, ring);
    }
  }

 private:
  // The curve control point of the half of sharp edge `sharp` (of the parent level) at `vertex`.
  [[nodiscard]] std::int32_t curve_point(std::int32_t edge, std::int32_t sharp,
                                         std::int32_t vertex) const {
    return first_sharp + 2 * sharp + (parent.first_end(edge) == vertex ? 0 : 1);
  }

  void around_face(std::int32_t face, VertexRing& ring) const {
    ring.kind = VertexKind::Smooth;
    for (std::int32_t i = 0; i < parent.face_size(face); ++i)
      ring.faces.push_back(parent.first_corner(face) + i);
  }

  void around_edge(std::int32_t edge, VertexRing& ring) const;
  void around_vertex(std::int32_t vertex, VertexRing& ring) const;
  void gather_sectors(std::int32_t vertex, VertexRing& ring) const;
};

template <class Parent>
void Gatherer<Parent>::around_edge(std::int32_t edge, VertexRing& ring) const {
  parent.append_corners_on(edge, ring.faces);
  const std::size_t count = ring.faces.size();
  const std::array<std::int32_t, 2> tails{ring.faces.front(), ring.faces.back()};
  // A face runs along the edge from its corner to the next: seen from the edge's midpoint, the
  // child at the far corner comes first.
  ring.faces.clear();
  for (std::size_t k = 0; k < count; ++k) {
    ring.faces.push_back(parent.next(tails[k]));
    ring.faces.push_back(tails[k]);
  }
  const std::int32_t sharp = subdivision.sharp_of_edge(parent_level, edge);
  ring.kind = sharp < 0 ? VertexKind::Smooth : VertexKind::Crease;
  if (sharp < 0) return;
  for (std::size_t k = 0; k < count; ++k) {
    const std::int32_t tail = parent.vertex_of(tails[k]);
    const std::int32_t head = parent.vertex_of(parent.next(tails[k]));
    ring.sectors.push_back({static_cast<std::int32_t>(2 * k), 2, curve_point(edge, sharp, head),
                            curve_point(edge, sharp, tail)});
  }
}

template <class Parent>
void Gatherer<Parent>::around_vertex(std::int32_t vertex, VertexRing& ring) const {
  parent.append_corners_at(vertex, ring.faces);
  const SharpFeatures& features = subdivision.features();
  const bool from_mesh = vertex < static_cast<int>(features.vertex_kinds.size());
  ring.kind = from_mesh ? features.vertex_kinds[vertex] : VertexKind::Smooth;
  if (from_mesh && ring.kind == VertexKind::Smooth) return;
  if (ring.kind == VertexKind::Corner) {
    ring.corner_point = first_corner + features.corner_of_vertex[vertex];
  }
  if (subdivision.has_sharp_edges()) gather_sectors(vertex, ring);
}

// Sectors of a vertex whose faces are gathered; turns the ring so that a sector begins at its
// first face.
template <class Parent>
void Gatherer<Parent>::gather_sectors(std::int32_t vertex, VertexRing& ring) const {
  const auto sharp_of = [&](std::int32_t edge) {
    return subdivision.sharp_of_edge(parent_level, edge);
  };
  const auto first = std::ranges::find_if(
      ring.faces, [&](std::int32_t corner) { return sharp_of(parent.edge_of(corner)) >= 0; });
  if (first == ring.faces.end()) return;  // smooth, or a tagged vertex in a smooth neighbourhood
  std::ranges::rotate(ring.faces, first);
  if (ring.kind == VertexKind::Dart) {
    ring.dart_face = 0;
    return;
  }
  if (ring.kind == VertexKind::Smooth) ring.kind = VertexKind::Crease;  // born on a sharp edge

  for (std::size_t k = 0; k < ring.faces.size(); ++k) {
    const std::int32_t leading = parent.edge_of(ring.faces[k]);
    const std::int32_t trailing = parent.edge_of(parent.prev(ring.faces[k]));
    const std::int32_t sharp = sharp_of(leading);
    if (sharp >= 0) {
      VertexRing::Sector sector{static_cast<std::int32_t>(k), 0,
                                curve_point(leading, sharp, vertex), -1};
      if (ring.kind == VertexKind::Corner) {
        // Descendants of a sharp edge keep its number in the high bits.
        const std::int32_t ancestor = sharp >> parent_level;
        sector.corner =
            subdivision.features().corner_sectors.at(SharpFeatures::sector_key(vertex, ancestor));
      }
      ring.sectors.push_back(sector);
    }
    VertexRing::Sector& sector = ring.sectors.back();
    ++sector.count;
    sector.curve1 = -1;
    const std::int32_t trailing_sharp = sharp_of(trailing);
    if (trailing_sharp >= 0) sector.curve1 = curve_point(trailing, trailing_sharp, vertex);
  }
  for (const VertexRing::Sector& sector : ring.sectors) PLANISH_ASSERT(sector.curve1 >= 0);
}

}  // namespace

void gather_ring(const Subdivision& subdivision, int level, std::int32_t vertex, VertexRing& ring) {
  PLANISH_ASSERT(level >= 1);
  ring.faces.clear();
  ring.sectors.clear();
  ring.corner_point = ring.dart_face = -1;
  const Subdivision::StateLayout& layout = subdivision.state_layout(level);
  const auto first_sharp = static_cast<std::int32_t>(layout.first_sharp);
  const auto first_corner = static_cast<std::int32_t>(layout.first_corner);
  const QuadSplit& split = subdivision.split();
  if (level == 1) {
    Gatherer<MeshParent>{subdivision, 0, {split.topology()}, first_sharp, first_corner}.around(
        vertex, ring);
  } else {
    Gatherer<QuadParent>{
        subdivision, level - 1, {split.level(level - 1)}, first_sharp, first_corner}
        .around(vertex, ring);
  }
}

}  // namespace planish
