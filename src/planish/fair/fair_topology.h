#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/features/find_features.h"
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

/// Along the limit normal at the centre of a polygon of control points, not normalised: t1 x t2 of
/// its first Fourier pair. `point(i)` for i in [0, count). Zero for fewer than three points.
template <class Point>
[[nodiscard]] glm::dvec3 limit_normal(const FairTopology& topology, std::int32_t count,
                                      const Point& point) {
  if (count < 3) return glm::dvec3(0.0);
  if (count == 3) return glm::cross(point(1) - point(0), point(2) - point(0));
  if (count == 4) return glm::cross(point(0) - point(2), point(1) - point(3));
  const auto circle = topology.unit_circle.of(count);
  const glm::dvec3 origin = point(0);
  glm::dvec3 tangent1(0.0), tangent2(0.0);
  for (std::int32_t i = 1; i < count; ++i) {
    const glm::dvec3 p = point(i) - origin;
    tangent1 += circle[i].x * p;
    tangent2 += circle[i].y * p;
  }
  return glm::cross(tangent1, tangent2);
}

/// Where control points lie in a plane of the mesh: a face of it for each polygon and each sector,
/// -1 where there is none. Both empty: nowhere.
struct PlanePlaces {
  std::vector<std::int32_t> of_vertex;  ///< of crease vertices that of any of their sectors
  std::vector<std::int32_t> of_sector;  ///< as FairTopology::sectors

  [[nodiscard]] std::int32_t of(std::int32_t vertex) const {
    return of_vertex.empty() ? -1 : of_vertex[vertex];
  }
  [[nodiscard]] std::int32_t of_sector_at(std::int32_t sector) const {
    return of_sector.empty() ? -1 : of_sector[sector];
  }
};

/// Those of find_kept_planes() between what is sharp in a subdivision of the mesh.
[[nodiscard]] std::vector<KeptPlane> kept_planes(const PolygonMesh& mesh,
                                                 const Subdivision& subdivision);

/// Corners have none: there the edges are the tangents.
[[nodiscard]] PlanePlaces plane_places(const FairTopology& topology,
                                       std::span<const KeptPlane> planes);

/// Right-handed and orthonormal, `normal` outward.
struct VertexFrame {
  glm::dvec3 tangent1, tangent2, normal;

  [[nodiscard]] glm::dvec2 project(const glm::dvec3& vector) const;
};

/// Unit Newell normals; +Z where a face has no area.
[[nodiscard]] std::vector<glm::dvec3> unit_face_normals(const FairTopology& topology,
                                                        std::span<const glm::dvec3> given);

/// Unit normal at a vertex: the normals of the ring's corners, weighted by their angles. A corner
/// that turns inward or lies athwart its face takes the face's normal, of `face_normals`
/// (unit_face_normals()), and its angle about that, up to a full turn. Where they cancel, the sum
/// of the faces' normals.
[[nodiscard]] glm::dvec3 angle_weighted_normal(const FairTopology& topology,
                                               std::span<const glm::dvec3> given,
                                               std::span<const glm::dvec3> face_normals,
                                               std::int32_t vertex, const FairTopology::Ring& ring);

/// Those of all vertices, each of its whole ring or of the plane there.
[[nodiscard]] std::vector<glm::dvec3> vertex_normals(const FairTopology& topology,
                                                     std::span<const glm::dvec3> given,
                                                     std::span<const glm::dvec3> face_normals,
                                                     const PlanePlaces& planes = {});

/// `normal` of unit length.
[[nodiscard]] VertexFrame frame_of(const glm::dvec3& normal);

/// How the planes of cured polygons lean from those of their vertices' normals: chosen once and
/// kept (FairDecisions::leans), since the best choice jumps where no direction sees all faces.
/// Radians. Smooth and dart vertices: an angle towards a direction of the tangent plane, as that
/// angle's vector along ring_direction() and left of it. Crease vertices: angles about the curve,
/// of the first and the second sector. Corners: in x bit k is set where sector k was opened.
inline constexpr float kNoLean = 0x1p30F;  ///< not chosen yet
[[nodiscard]] inline bool is_chosen(const glm::vec2& lean) { return lean.x < kNoLean; }

/// Where the edges around a smooth or dart vertex point to: the first Fourier coefficient of their
/// directions in the frame's plane, unit, turning with the ring; (1, 0) where that is 0. Where they
/// surround the vertex once it is not (README.md).
[[nodiscard]] glm::dvec2 ring_direction(const FairTopology& topology,
                                        std::span<const glm::dvec3> given, std::int32_t vertex,
                                        const VertexFrame& frame);

/// That direction and the one left of it in space, in the plane of a unit normal.
struct RingAxes {
  glm::dvec3 along, left;
};
[[nodiscard]] RingAxes ring_axes(const FairTopology& topology, std::span<const glm::dvec3> given,
                                 std::int32_t vertex, const glm::dvec3& normal);

/// The lean of a smooth or dart vertex's plane from one unit normal to another.
[[nodiscard]] glm::vec2 lean_towards(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, std::int32_t vertex,
                                     const glm::dvec3& normal, const glm::dvec3& target);
/// The other way around. Continuous in the given points and the normal.
[[nodiscard]] glm::dvec3 leaning_normal(const FairTopology& topology,
                                        std::span<const glm::dvec3> given, std::int32_t vertex,
                                        const glm::dvec3& normal, const glm::vec2& lean);

/// One Doo-Sabin step of `points` (one per vertex): the control point of every corner, relative to
/// the given point of its vertex. `offsets`: one per corner.
void corner_offsets(const FairTopology& topology, std::span<const glm::dvec3> given,
                    std::span<const glm::dvec3> points, std::span<glm::dvec3> offsets);

/// The same of the given points themselves, for single corners.
class GivenStep {
 public:
  GivenStep(const FairTopology& topology, std::span<const glm::dvec3> given);
  [[nodiscard]] glm::dvec3 offset(std::int32_t corner) const;

 private:
  const FairTopology& topology_;
  std::span<const glm::dvec3> given_;
  std::vector<std::vector<glm::dvec3>> of_large_;  // by FairTopology::large_faces
};

/// How far the limit point of `points` at a vertex is from its given point; 0 at corners.
/// `offsets`: control points of `points` (corner_offsets).
[[nodiscard]] glm::dvec3 limit_error(const FairTopology& topology,
                                     std::span<const glm::dvec3> given,
                                     std::span<const glm::dvec3> points,
                                     std::span<const glm::dvec3> offsets, std::int32_t vertex);

/// Three plain steps of progressive interpolation, P += share (given - B P) from P = given: keeps
/// the accuracy of tensor products where the mesh is a regular grid. `shares`: one per vertex; 0 at
/// corners. Returns P and leaves its control points in `offsets`, which must hold those of
/// `given` on entry (corner_offsets). `halo`: where the mesh is a part.
[[nodiscard]] std::vector<glm::dvec3> masked_iteration(const FairTopology& topology,
                                                       std::span<const glm::dvec3> given,
                                                       std::span<const double> shares,
                                                       std::span<glm::dvec3> offsets,
                                                       FairHalo* halo = nullptr);

/// What a backend also is that builds fair nets on its device. For the others there is fair_net().
class FairBuilder {
 public:
  virtual ~FairBuilder() = default;

  /// As fair_net(), in the device's precision. Also throws Error{OutOfMemory}, naming the limit,
  /// and Error{DeviceLost}.
  [[nodiscard]] virtual FairNet build_fair_net(const FairTopology& topology,
                                               std::span<const glm::dvec3> given,
                                               const FairOptions& options) = 0;
};

}  // namespace planish
