#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// Positive weights with sum weights[i] * points[i] = 0: those of the least sum of
/// exp(-y . point) over y, near 1 where the points' mean is near 0. Returns how far they are to be
/// used, 0 to 1: less than 1 where the points surround 0 only just, 0 where they do not; `weights`
/// is meaningless then. A ramp, so that a deforming mesh does not jump. `weights`: one per point.
/// Source: the maximum entropy of a distribution of given mean.
[[nodiscard]] double balance(std::span<const glm::dvec2> points, std::span<double> weights);

/// The ring of one vertex projected to its tangent plane, relative to the vertex. Corner i of the
/// ring lies in the wedge from its edge next[i] counter-clockwise to its edge previous[i].
/// Reused from vertex to vertex.
struct PlanarRing {
  /// A point of the plane as along_next * next + along_previous * previous.
  struct Wedge {
    double along_next, along_previous;
    bool valid;  ///< the wedge opens counter-clockwise, by more than a sliver
  };

  std::int32_t count = 0;
  std::vector<glm::dvec2> next, previous;
  std::vector<glm::dvec2> offsets;  ///< of the control points
  std::vector<Wedge> wedges;        ///< of `offsets`
  glm::dvec2 mean{0.0};             ///< of `offsets`
};

/// The wedge coordinates of `point` between two edges.
[[nodiscard]] PlanarRing::Wedge wedge_of(const glm::dvec2& point, const glm::dvec2& next,
                                         const glm::dvec2& previous);

/// How far a wedge is to be trusted: 0 where it is not valid, 1 from twice the sliver's angle on.
[[nodiscard]] double wedge_share(const glm::dvec2& next, const glm::dvec2& previous);

/// Fills `ring` with these corners around a vertex.
void project_ring(std::span<const glm::dvec3> given, std::span<const glm::dvec3> corner_offsets,
                  std::int32_t vertex, const FairTopology::Ring& corners, const VertexFrame& frame,
                  PlanarRing& ring);

/// How far the mean of the control points lies out of balance: the largest ratio of the mean's
/// wedge coordinates to a control point's. Below 1, moving all control points by it leaves each in
/// its wedge. Infinite where a control point is not safely inside its own wedge. Invariant under
/// affine maps of the plane.
[[nodiscard]] double imbalance(const PlanarRing& ring);

/// The polygon of control points around a vertex in its tangent plane, built from its ring alone.
/// Reused from vertex to vertex.
struct LocalPolygon {
  std::vector<glm::dvec2> points;  ///< relative to the vertex; only nearly centred
  std::vector<double> heights;     ///< above the plane; all 0 but at regular vertices

  // Scratch.
  std::vector<glm::dvec2> targets, blended;
  std::vector<double> shares;
};

/// Moves the ring's control points so that their mean comes to the vertex and each stays in the
/// wedge of its own face: by translation where the ring is even, by positive factors where it is
/// not, of its edges where those do not balance. `rho` is imbalance(ring). Continuous in the ring.
void build_local_polygon(const PlanarRing& ring, double rho, LocalPolygon& polygon);

/// What bilinear corners add to a plane: the part of the control points' heights that no plane
/// through them explains. `heights[i]` of the ring's control points above the tangent plane.
/// Call after build_local_polygon.
void add_twist(const PlanarRing& ring, std::span<const double> heights, LocalPolygon& polygon);

/// Scratch memory of the functions below, reused from vertex to vertex.
struct PolygonScratch {
  PlanarRing ring;
  LocalPolygon local;
  std::vector<double> heights;
  std::vector<glm::dvec3> translated;
};

/// What the polygon of control points around a smooth or dart vertex is built from.
struct PolygonShape {
  glm::dvec3 normal;  ///< of the vertex, unit
  double share;       ///< of the tensor-product construction, 0 to 1
  /// Whether the polygon came out turned over; not given: to be found out.
  std::optional<bool> reversed = std::nullopt;
  bool is_flat = false;  ///< in the plane of the normal, without a twist
};

/// Builds the polygon around `vertex`, its mean exactly 0, in place of its control points in
/// `offsets`, which are those of one step of the given points or of the masked iteration's.
/// True where the built polygon came out turned over and a small translated copy of the given
/// points' stands in for it. `step`: of `given`.
bool build_vertex_polygon(const FairTopology& topology, std::span<const glm::dvec3> given,
                          const GivenStep& step, std::int32_t vertex, const PolygonShape& shape,
                          PolygonScratch& scratch, std::span<glm::dvec3> offsets);

/// A quarter of the two sharp edges at a crease or boundary vertex, where curve points would stand
/// if nothing had to be interpolated.
struct CreaseArms {
  glm::dvec3 before, after;  ///< towards crease_neighbours()
};

[[nodiscard]] CreaseArms crease_arms(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, std::int32_t vertex);

/// How much the arms differ in length: their difference by the shorter; infinite if that is 0.
[[nodiscard]] double imbalance(const CreaseArms& arms);

/// The offset of the curve point towards the vertex before; the other is its negative, so that
/// their middle is the vertex. Along the tangent of the circle through the vertex and its
/// neighbours, as long as the arms on average, limited by the shorter one; 0 at a cusp. For
/// vertices outside regular grids.
[[nodiscard]] glm::dvec3 crease_handle(const CreaseArms& arms);

/// What a handle is to be scaled by, at least 0.02, so that it stays in a corridor along the curve:
/// in each face beside the sharp edges at the vertex it moves into the face by at most half of what
/// the corner's control point does, and an eighth of what the other edge does. A handle along a
/// reflex boundary would otherwise run through thin faces.
[[nodiscard]] double corridor_factor(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, const GivenStep& step,
                                     std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                     const glm::dvec3& handle);

/// What a sector's control points are built from.
struct SectorShape {
  glm::dvec3 handle;        ///< offset of the curve point before the first sector
  double share;             ///< of the tensor-product construction, 0 to 1
  glm::dvec3 tensor_shift;  ///< given - B P at the vertex
  /// Unit normal of the plane that the sector lies in; not given: that of its corners.
  std::optional<glm::dvec3> normal = std::nullopt;
};

/// Builds the control points of a crease or boundary sector in place of those in `offsets`, which
/// are of one step of the given points or of P: flat in the plane of the handle and the sector's
/// normal where share is 0, following the curve's handles beside the sharp edges. `step`: of
/// `given`.
void build_sector(const FairTopology& topology, std::span<const glm::dvec3> given,
                  const GivenStep& step, std::span<const glm::dvec3> face_normals,
                  const FairTopology::Sector& sector, const SectorShape& shape,
                  std::span<glm::dvec3> offsets);

/// How far the limit points of the given points miss them: of hubs, whose rings are long and which
/// all their neighbours ask, made once.
class GivenErrors {
 public:
  /// `corner_offsets`: of one step of the given points. All must outlive it.
  GivenErrors(const FairTopology& topology, std::span<const glm::dvec3> given,
              std::span<const glm::dvec3> corner_offsets);

  [[nodiscard]] glm::dvec3 of(std::int32_t vertex) const;

  const FairTopology& topology;
  std::span<const glm::dvec3> given, corner_offsets;

 private:
  [[nodiscard]] bool is_hub(std::int32_t vertex) const;
  [[nodiscard]] glm::dvec3 made(std::int32_t vertex) const;

  std::unordered_map<std::int32_t, glm::dvec3> of_hubs_;
};

/// How far a vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
/// the less the farther its control points are out of balance, be it by themselves or against those
/// of its neighbours. Continuous in the given points. `normal`: the vertex's, unit; `scratch` is
/// reused from vertex to vertex.
[[nodiscard]] double tensor_share(const GivenErrors& errors, const glm::dvec3& normal,
                                  std::int32_t vertex, PlanarRing& scratch);

}  // namespace planish
