#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

class FairHalo;

/// What the fair construction needs to know of a mesh, in flat arrays that a device can take as
/// they are. A *corner* is a corner of a face of the mesh; its number, its place in
/// PolygonMesh::face_vertices, is also that of its control point in the state of level 1.
struct FairTopology {
  /// Faces between two sharp edges at a crease, boundary or corner vertex.
  struct Sector {
    std::int32_t vertex;
    std::int32_t first, count;    ///< range of the ring arrays, counter-clockwise
    std::int32_t curve0, curve1;  ///< state indices of the curve points before and after
  };
  /// Faces around a vertex that follow one another counter-clockwise: their corners at the vertex,
  /// and the vertices beside it in each of them.
  struct Ring {
    std::span<const std::int32_t> corners, next, previous;
    [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(corners.size()); }
  };
  /// The curve control point of a sharp edge's half.
  struct CurvePoint {
    std::int32_t vertex, other;                ///< the end that it belongs to, and the far end
    std::int32_t corner_after, corner_before;  ///< at darts: the corners beside it; else -1
  };
  /// The polygon of level 1 around an edge that is not sharp: its corners counter-clockwise, the
  /// first two in face 0, the last two in face 1. Corners 1 and 2 belong to one end of the edge,
  /// corners 0 and 3 to the other.
  struct Edge {
    std::array<std::int32_t, 4> corners;
    std::array<std::int32_t, 2> faces;
  };
  /// The points of regular polygons, one size after another.
  struct UnitCircle {
    std::vector<std::int32_t> offsets;  ///< by size n; -1 where the mesh has no such polygon
    std::vector<glm::dvec2> points;     ///< cos and sin of 2 pi i / n, i = 0..n-1
    [[nodiscard]] std::span<const glm::dvec2> of(std::int32_t size) const {
      return std::span(points).subspan(static_cast<std::size_t>(offsets[size]),
                                       static_cast<std::size_t>(size));
    }
  };

  std::int32_t vertex_count = 0, face_count = 0, corner_count = 0, state_size = 0;
  std::span<const std::int32_t> face_offsets;     ///< of the mesh
  std::span<const std::int32_t> corner_vertices;  ///< of the mesh
  std::span<const std::int32_t> corner_faces;     ///< of the MeshTopology

  std::span<const std::int32_t> ring_offsets;  ///< of the MeshTopology: ranges of the three below
  /// The corners around each vertex, counter-clockwise; where sharp edges cut the ring into
  /// sectors, one sector after another.
  std::vector<std::int32_t> ring_corners;
  std::vector<std::int32_t> ring_next,
      ring_previous;                     ///< the vertices beside, in the corner's face
  std::vector<std::uint8_t> kinds;       ///< VertexKind
  std::vector<std::uint8_t> is_regular;  ///< all faces around the vertex are quads
  /// Within two edges of a crease, boundary or corner vertex, or such a vertex.
  std::vector<std::uint8_t> is_near_curve;

  std::vector<std::int32_t> crease_of_vertex;  ///< its number among them, or -1; empty: none
  std::vector<std::int32_t> crease_vertices;
  std::vector<std::int32_t> sector_offsets;  ///< per crease vertex, one more at the end
  std::vector<Sector> sectors;               ///< of crease vertices
  std::vector<CurvePoint> curve_points;      ///< in the order of the state
  std::vector<std::int32_t> corner_points;   ///< corner vertices, in the order of the state
  /// State indices of the control points beside a corner's own around its vertex: after it and
  /// before it, counter-clockwise.
  std::vector<std::int32_t> corner_ccw, corner_cw;
  std::vector<std::int32_t> edge_corners;  ///< of edges that are not sharp, Edge::corners[1]

  UnitCircle unit_circle;  ///< of all face sizes and valences
  /// What is asked of a face or ring at each of its corners is found once where these are as many.
  std::int32_t large_size = 32;
  std::vector<std::int32_t> large_faces;  ///< ascending

  /// The number of a face among those, or -1.
  [[nodiscard]] std::int32_t large_face(std::int32_t face) const {
    if (face_size(face) < large_size) return -1;
    return static_cast<std::int32_t>(std::ranges::lower_bound(large_faces, face) -
                                     large_faces.begin());
  }
  [[nodiscard]] std::int32_t face_size(std::int32_t face) const {
    return face_offsets[face + 1] - face_offsets[face];
  }
  [[nodiscard]] std::int32_t valence(std::int32_t vertex) const {
    return ring_offsets[vertex + 1] - ring_offsets[vertex];
  }
  /// Of all faces around a vertex; of those of a sector.
  [[nodiscard]] Ring ring(std::int32_t vertex) const {
    return ring_of(ring_offsets[vertex], valence(vertex));
  }
  [[nodiscard]] Ring ring(const Sector& sector) const {
    return ring_of(sector.first, sector.count);
  }
  /// The vertices of a face.
  [[nodiscard]] std::span<const std::int32_t> face(std::int32_t index) const {
    return corner_vertices.subspan(static_cast<std::size_t>(face_offsets[index]),
                                   static_cast<std::size_t>(face_size(index)));
  }
  /// By number among `edge_corners`.
  [[nodiscard]] Edge edge(std::size_t number) const {
    const std::int32_t own = edge_corners[number], other = corner_cw[own];
    const std::int32_t f = corner_faces[own], g = corner_faces[other];
    return {{own + 1 == face_offsets[f + 1] ? face_offsets[f] : own + 1, own, other,
             (other == face_offsets[g] ? face_offsets[g + 1] : other) - 1},
            {f, g}};
  }
  [[nodiscard]] std::int32_t first_curve_point() const { return corner_count; }
  [[nodiscard]] VertexKind kind(std::int32_t vertex) const {
    return static_cast<VertexKind>(kinds[vertex]);
  }
  /// Whether the polygon around the vertex has its centroid there.
  [[nodiscard]] bool has_polygon(std::int32_t vertex) const {
    return kind(vertex) == VertexKind::Smooth || kind(vertex) == VertexKind::Dart;
  }
  /// The vertices beside a crease or boundary vertex along the sharp curve: at the beginning and
  /// at the end of its first sector.
  [[nodiscard]] std::array<std::int32_t, 2> crease_neighbours(std::int32_t vertex) const {
    const Sector& sector = sectors[sector_offsets[crease_of_vertex[vertex]]];
    return {ring_next[sector.first], ring_previous[sector.first + sector.count - 1]};
  }

 private:
  [[nodiscard]] Ring ring_of(std::int32_t first, std::int32_t count) const {
    const auto part = [&](const std::vector<std::int32_t>& all) {
      return std::span(all).subspan(static_cast<std::size_t>(first),
                                    static_cast<std::size_t>(count));
    };
    return {part(ring_corners), part(ring_next), part(ring_previous)};
  }
};

/// `mesh` and `subdivision` must outlive it. `halo`: where `mesh` is a part.
[[nodiscard]] FairTopology make_fair_topology(const PolygonMesh& mesh,
                                              const Subdivision& subdivision,
                                              FairHalo* halo = nullptr);

}  // namespace planish
