#include "planish/doosabin/vertex_ring.h"

#include <algorithm>

#include "planish/core/assert.h"

namespace planish {

namespace {

using OpenSubdiv::Far::ConstIndexArray;
using OpenSubdiv::Far::ConstLocalIndexArray;
using OpenSubdiv::Far::TopologyLevel;

// Gathers from the level above, whose faces' corners are this level's faces.
struct Gatherer {
  const Subdivision& subdivision;
  int parent_level;
  const TopologyLevel& parent;
  std::int32_t first_sharp;  // of this level's state
  std::int32_t first_corner;

  // The child of a face at its corner.
  [[nodiscard]] std::int32_t child_face(int face, int corner) const {
    return subdivision.split().first_corner(parent_level, face) + corner;
  }

  // The curve control point of the half of sharp edge `sharp` (of the parent level) at `vertex`.
  [[nodiscard]] std::int32_t curve_point(int edge, std::int32_t sharp, int vertex) const {
    const int end = parent.GetEdgeVertices(edge)[0] == vertex ? 0 : 1;
    return first_sharp + 2 * sharp + end;
  }

  void around_face(int face, VertexRing& ring) const {
    ring.kind = VertexKind::Smooth;
    const int m = parent.GetFaceVertices(face).size();
    for (int i = 0; i < m; ++i) ring.faces.push_back(child_face(face, i));
  }

  void around_edge(int edge, VertexRing& ring) const;
  void around_vertex(int vertex, VertexRing& ring) const;
  void gather_sectors(int vertex, VertexRing& ring) const;
};

void Gatherer::around_edge(int edge, VertexRing& ring) const {
  const ConstIndexArray faces = parent.GetEdgeFaces(edge);
  const ConstLocalIndexArray locals = parent.GetEdgeFaceLocalIndices(edge);
  // Face k runs along the edge from its corner local to the next: seen from the edge's midpoint,
  // the child at the far corner comes first.
  for (int k = 0; k < faces.size(); ++k) {
    const int m = parent.GetFaceVertices(faces[k]).size();
    ring.faces.push_back(child_face(faces[k], (locals[k] + 1) % m));
    ring.faces.push_back(child_face(faces[k], locals[k]));
  }
  const std::int32_t sharp = subdivision.sharp_of_edge(parent_level, edge);
  ring.kind = sharp < 0 ? VertexKind::Smooth : VertexKind::Crease;
  if (sharp < 0) return;
  for (int k = 0; k < faces.size(); ++k) {
    const ConstIndexArray vertices = parent.GetFaceVertices(faces[k]);
    const int tail = vertices[locals[k]];
    const int head = vertices[(locals[k] + 1) % vertices.size()];
    ring.sectors.push_back(
        {2 * k, 2, curve_point(edge, sharp, head), curve_point(edge, sharp, tail)});
  }
}

void Gatherer::around_vertex(int vertex, VertexRing& ring) const {
  const ConstIndexArray faces = parent.GetVertexFaces(vertex);
  const ConstLocalIndexArray locals = parent.GetVertexFaceLocalIndices(vertex);
  for (int i = 0; i < faces.size(); ++i) ring.faces.push_back(child_face(faces[i], locals[i]));

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
void Gatherer::gather_sectors(int vertex, VertexRing& ring) const {
  const ConstIndexArray faces = parent.GetVertexFaces(vertex);
  const ConstLocalIndexArray locals = parent.GetVertexFaceLocalIndices(vertex);
  const int n = faces.size();
  const auto leading_edge = [&](int i) { return parent.GetFaceEdges(faces[i])[locals[i]]; };
  const auto trailing_edge = [&](int i) {
    const ConstIndexArray edges = parent.GetFaceEdges(faces[i]);
    return edges[(locals[i] + edges.size() - 1) % edges.size()];
  };
  const auto sharp_of = [&](int edge) { return subdivision.sharp_of_edge(parent_level, edge); };

  int first = 0;
  while (first < n && sharp_of(leading_edge(first)) < 0) ++first;
  if (first == n) return;  // no sharp edge: smooth, or a tagged vertex in a smooth neighbourhood
  std::rotate(ring.faces.begin(), ring.faces.begin() + first, ring.faces.end());
  if (ring.kind == VertexKind::Dart) {
    ring.dart_face = 0;
    return;
  }
  if (ring.kind == VertexKind::Smooth) ring.kind = VertexKind::Crease;  // born on a sharp edge

  for (int k = 0; k < n; ++k) {
    const int i = (first + k) % n;
    const std::int32_t sharp = sharp_of(leading_edge(i));
    if (sharp >= 0) {
      VertexRing::Sector sector{k, 0, curve_point(leading_edge(i), sharp, vertex), -1};
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
    const std::int32_t trailing_sharp = sharp_of(trailing_edge(i));
    if (trailing_sharp >= 0) {
      sector.curve1 = curve_point(trailing_edge(i), trailing_sharp, vertex);
    }
  }
  for (const VertexRing::Sector& sector : ring.sectors) PLANISH_ASSERT(sector.curve1 >= 0);
}

}  // namespace

void gather_ring(const Subdivision& subdivision, int level, std::int32_t vertex, VertexRing& ring) {
  PLANISH_ASSERT(level >= 1);
  ring.faces.clear();
  ring.sectors.clear();
  ring.corner_point = ring.dart_face = -1;
  const TopologyLevel& parent = subdivision.split().level(level - 1);
  const Subdivision::StateLayout& layout = subdivision.state_layout(level);
  const Gatherer gatherer{subdivision, level - 1, parent,
                          static_cast<std::int32_t>(layout.first_sharp),
                          static_cast<std::int32_t>(layout.first_corner)};
  const int vertex_count = parent.GetNumVertices();
  const int face_count = parent.GetNumFaces();
  if (vertex < vertex_count) {
    gatherer.around_vertex(vertex, ring);
  } else if (vertex < vertex_count + face_count) {
    gatherer.around_face(vertex - vertex_count, ring);
  } else {
    gatherer.around_edge(vertex - vertex_count - face_count, ring);
  }
}

}  // namespace planish
