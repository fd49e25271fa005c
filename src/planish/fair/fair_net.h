#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/features/find_features.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// How the surface comes to pass through the given vertices.
enum class InterpolationMethod {
  Progressive,  ///< the paper's: control points of the mesh are moved until it does
  Fair,         ///< control points of level 1 are built to do so, without folds on uneven meshes
};

/// How far a surface may leave the given vertices, of the diagonal.
struct LeaveWithin {
  double within = 0;
  std::optional<double> noise;  ///< where it was measured

  /// What the given points may be moved by: the solve may leave its points by the tolerance.
  [[nodiscard]] double bound(double tolerance) const { return within - tolerance; }
};
inline constexpr double kMostWithin = 0.1;  ///< is above what may be asked for
/// Of measured noise, what is allowed: normals are best at 1 to 1.5.
inline constexpr double kNoiseBound = 1.25;

/// What the construction of a fair net needs where a mesh is spread over several processes. Each
/// builds the net of its part: the faces around the vertices that it owns and around those faces'
/// vertices. What it finds for others is replaced by what their owners found; all call the same
/// functions in the same order. Without a halo the mesh is in one piece.
class FairHalo {
 public:
  virtual ~FairHalo() = default;

  /// Values of vertices that others own become theirs. One per vertex of the part.
  virtual void exchange_vertices(std::span<double> values) = 0;
  virtual void exchange_vertices(std::span<glm::dvec3> values) = 0;
  virtual void exchange_vertices(std::span<std::uint8_t> values) = 0;
  /// The same of the control points around such vertices; one per corner.
  virtual void exchange_corners(std::span<float> values) = 0;
  /// And of those on curves; the state of level 1. Curve points at the part's rim, where the mesh
  /// goes on, are nobody's.
  virtual void exchange_state(std::span<glm::dvec3> values) = 0;

  /// Sums over the elements that each process owns: the same bits however the mesh is spread.
  [[nodiscard]] virtual double sum_of_vertices(std::span<const double> values) = 0;
  [[nodiscard]] virtual double sum_of_faces(std::span<const double> values) = 0;
  [[nodiscard]] virtual std::int64_t sum(std::int64_t value) = 0;
  [[nodiscard]] virtual double largest(double value) = 0;

  /// One flag per vertex and per face; a face belongs to one process, its edges to that of the face
  /// that they were found in.
  [[nodiscard]] virtual std::span<const std::uint8_t> owned_vertices() const = 0;
  [[nodiscard]] virtual std::span<const std::uint8_t> owned_faces() const = 0;
};

/// Without a halo all is this process's own.
[[nodiscard]] inline bool owns_vertex(const FairHalo* halo, std::int32_t vertex) {
  return halo == nullptr || halo->owned_vertices()[vertex] != 0;
}
[[nodiscard]] inline bool owns_face(const FairHalo* halo, std::int32_t face) {
  return halo == nullptr || halo->owned_faces()[face] != 0;
}
[[nodiscard]] inline std::int64_t sum_of_parts(FairHalo* halo, std::int64_t value) {
  return halo == nullptr ? value : halo->sum(value);
}
[[nodiscard]] inline bool is_in_any_part(FairHalo* halo, bool is_here) {
  return sum_of_parts(halo, is_here ? 1 : 0) > 0;
}

inline constexpr std::int32_t kMostPolishSteps = 1000;

/// What a net's construction decided by thresholds, per vertex of the mesh; all else is continuous
/// in the given points. Kept through the frames of an animation, they let nothing pop.
struct FairDecisions {
  std::vector<std::uint8_t> reversed;  ///< 1: the polygon came out turned over and was replaced
  /// How often the repair halved the vertex's polygon, before and after the polish.
  std::vector<std::uint8_t> halvings, late_halvings;
  /// How many rounds of the cure changed it after that (see fold_cure.h).
  std::vector<std::uint8_t> cures;
  /// How the polygons lean that the cure made (see fair_topology.h). Empty: chosen anew.
  std::vector<glm::vec2> leans;
  /// The ellipses of smooth and dart vertices where that polygon still folds (see fold_cure.h),
  /// zero elsewhere. Empty: none.
  std::vector<glm::vec4> ellipses;
  /// Planes that are kept, ascending: all control points there lie in them.
  std::vector<KeptPlane> planes;
};

struct FairOptions {
  std::int32_t polish_steps = 8;  ///< 0 to kMostPolishSteps; 0: none
  Callbacks callbacks;
  /// Where given, of a net of the same mesh: these decisions instead of new ones.
  const FairDecisions* decisions = nullptr;
  /// False: without the cure of needles and sharp turns (fold_cure.h).
  bool cures_folds = true;
  /// Where the mesh is a part of a larger one: `given` are of all vertices of the part, and counts
  /// are those of all parts; decisions of vertices that others own say nothing.
  FairHalo* halo = nullptr;
  /// Without `decisions`: FairDecisions::planes.
  std::span<const KeptPlane> planes;
};

[[nodiscard]] inline std::span<const KeptPlane> planes_of(const FairOptions& options) {
  return options.decisions ? std::span<const KeptPlane>(options.decisions->planes) : options.planes;
}

/// Throws Error{InvalidArgument} for polish_steps out of range.
void require_valid(const FairOptions& options);
/// The same for decisions that are not of a mesh with so many vertices and faces.
void require_valid(const FairDecisions& decisions, std::int32_t vertex_count,
                   std::int32_t face_count);

/// How often steps were taken that end when nothing is left to do.
struct FairRounds {
  std::int32_t nets = 1;  ///< that were made; deeply_cured_net() makes 13 at most
  /// Of the first net: that halved polygons, 6 at most, and that cured, 3 at most. Empty: it was
  /// made on a device, in rounds of a fixed number.
  std::optional<std::int32_t> repair, cure;
};

/// What the construction of a net came to.
struct FairFigures {
  std::int64_t shrunk_vertices = 0;    ///< whose polygons were drawn in to undo overlaps
  std::int64_t reversed_vertices = 0;  ///< whose polygons came out turned over and were replaced
  std::int64_t cured_vertices = 0;     ///< whose polygons were replaced by perpendicular ones
  /// Of the smooth and dart vertices the least polygon of control points: its farthest point from
  /// the vertex, in parts of the vertex' shortest edge. Where it is tiny the surface is smooth in
  /// name only. fit() finds it; none without such vertices, and over ranks.
  std::optional<double> least_polygon;
  std::int64_t flagged_edges = 0;  ///< smooth edges still turned over in the end
  std::int64_t flagged_faces = 0;  ///< faces still turned over in the end
  FairRounds rounds;
};

/// A Doo-Sabin net of level 1 whose surface passes through the given vertices: the polygon around
/// every smooth vertex has its centroid there, the two curve points beside a crease or boundary
/// vertex their middle.
struct FairNet : FairFigures {
  /// The state of level 1 as Subdivision documents it, in the coordinates of `given`.
  std::vector<glm::dvec3> state;
  FairDecisions decisions;
};

/// Builds the net: a local construction at every vertex that keeps each control point inside its
/// own face's wedge, repair of overlaps, then `polish_steps` steps of conjugate gradients on the
/// bending of the net. `subdivision` is of `mesh`, with Weights::DooSabin whatever weights the
/// later levels take; `given` are the points to pass through, one per vertex of the mesh, near unit
/// diagonal; any finite points make a net. The same bits for every thread count.
/// Throws Error{InvalidArgument} for polish_steps out of range and Error{Cancelled}.
[[nodiscard]] FairNet fair_net(const PolygonMesh& mesh, const Subdivision& subdivision,
                               std::span<const glm::dvec3> given, const FairOptions& options = {});

}  // namespace planish
