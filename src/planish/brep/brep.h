#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/analytic/border_curves.h"
#include "planish/brep/spline_surface.h"
#include "planish/core/callbacks.h"
#include "planish/queries/limit_surface.h"

namespace planish {

/// A surface as CAD programs hold it: faces that meet along edges, untrimmed B-splines or on
/// surfaces that have a name. All points are in model coordinates.
struct Brep {
  /// An edge in a face's loop.
  struct Use {
    std::int32_t edge = 0;
    bool is_reversed = false;
  };
  /// Through a face's first point, on whose side the face's loop is counter-clockwise.
  struct Plane {
    glm::dvec3 normal{}, along{};  ///< of unit length, at right angles
  };
  struct Face {
    /// Distinct ones, ascending; the first and the last count degree + 1 times, all others once.
    /// The parameters are quads of Q_1.
    std::vector<double> knots_u, knots_v;
    /// (i, j) at i + j point_count(degree, knots_u), i along u.
    std::vector<glm::dvec3> points;
    std::vector<Use> loop;       ///< counter-clockwise
    std::int32_t group = 0;      ///< of the mesh's faces that it is made of
    std::optional<Plane> plane;  ///< where all points lie in one, and not on a line
    // Instead of knots and points:
    std::optional<AnalyticSurface> surface;
    bool is_inward = false;  ///< looks against the surface's normals
    /// At right angles to the surface's axis: where its angle begins, at a seam or off the face.
    glm::dvec3 along{};
    std::vector<std::vector<Use>> holes;  ///< further loops, clockwise seen from outside
  };
  /// Where an edge lies in a face: its parameter t is at from + t direction.
  struct Line {
    std::int32_t face = -1;  ///< -1: none
    glm::dvec2 from{};
    int direction = 0;  ///< 0 to 3: along u, v, -u, -v
  };
  struct Edge {
    std::int32_t from = 0, to = 0;  ///< vertices
    std::vector<double> knots;      ///< as those of faces, from 0 to the number of quads
    std::vector<glm::dvec3> points;
    std::array<Line, 2> lines;  ///< the second has no face at a boundary
    /// Of Q_1, the first one along it on the first line's face: see QuadLayout. -1: of none.
    std::int32_t half_edge = -1;
    /// Instead of knots and points, between faces on analytic surfaces.
    std::optional<BorderCurve> curve;
  };
  struct Shell {
    std::vector<std::int32_t> faces;
    bool is_closed = false;
    bool is_inside_out = false;  ///< of a closed one: its normals point into what it encloses
    std::int32_t outer = -1;     ///< of one inside out: the shell in whose inside it lies; -1: none
  };
  /// Where a vertex of the mesh lies.
  struct Place {
    std::int32_t face = -1;  ///< -1: no face that is shown has it
    glm::dvec2 at{};
  };
  struct Spot {
    glm::dvec3 position{};
    std::int32_t face = -1;  ///< of the mesh; -1: nowhere
  };
  /// Of the diagonal: files say that what is nearer is one place.
  static constexpr double kSamePlace = 1e-7;

  std::size_t degree = 2;  ///< of faces along both parameters, and of edges
  std::vector<glm::dvec3> vertices;
  std::vector<Edge> edges;
  std::vector<Face> faces;
  std::vector<Shell> shells;
  std::vector<Place> places;  ///< by vertex of the surface's topology

  std::int64_t extraordinary = 0;  ///< places where the surface is no polynomial, however small
  std::int64_t moved = 0;          ///< of these, where points beside are moved
  int deepest = 0;                 ///< the most halvings towards one
  /// Degrees that normals jump by across an edge that is not sharp, at most: where they are
  /// defined, which is not nearer than kSamePlace to a vertex nor where rounding chooses them.
  double max_angle = 0;
  /// Of faces from the surface, of the diagonal: at most.
  double max_deviation = 0;
  Spot max_angle_at, max_deviation_at;
};

/// The face's surface at (u, v).
[[nodiscard]] glm::dvec3 point_of(const Brep& brep, const Brep::Face& face, const glm::dvec2& at);
[[nodiscard]] glm::dvec3 point_of(const Brep& brep, const Brep::Edge& edge, double t);

/// The end of a direction of Brep::Line.
[[nodiscard]] inline glm::dvec2 unit_direction(int direction) {
  constexpr std::array<std::array<double, 2>, 4> kUnits{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const auto& unit = kUnits[direction];
  return {unit[0], unit[1]};
}

constexpr double kMostBrepAngle = 90;
constexpr std::int32_t kMostFaceSize = 4096;

struct BrepOptions {
  double angle = 0.25;          ///< degrees that normals may jump by at edges
  double deviation = 1e-6;      ///< from the surface along its normals, of the diagonal
  std::int32_t face_size = 16;  ///< quads of Q_1 on a face's side, of which a mesh's quad has two
  bool has_corners = false;     ///< faces have a corner wherever the border of a group turns
};

/// The surface as B-spline faces without holes between them: exact but in squares of 2^-m of a quad
/// at extraordinary points, or of twice that where points beside are moved towards the tangent
/// plane. These are halved until the options' limits are kept (m at most 12: see Brep::max_angle).
/// Borders of neighbours are equal. Hidden faces are left out. The same bits for every number of
/// threads. `groups`: one for each face of the mesh, that Brep::Face::group has and at whose
/// borders faces end; empty: all have 0. Reports step "faces". Throws Error{InvalidArgument} for
/// options out of range, Error{OutOfMemory} before memory is taken, Error{Cancelled}.
[[nodiscard]] Brep make_brep(const SplineSurface& surface, const BrepOptions& options = {},
                             const Callbacks& callbacks = {},
                             std::span<const std::int32_t> groups = {});
/// The same of a Doo-Sabin surface.
[[nodiscard]] Brep make_brep(const LimitSurface& surface, const BrepOptions& options = {},
                             const Callbacks& callbacks = {},
                             std::span<const std::int32_t> groups = {});

/// Sets the shells of faces that are joined by edges, and which of them lie inside out within
/// which. `face_of`: by face of the mesh, through these points by vertex, one of the shell that it
/// belongs to; -1: it is hidden.
void find_shells(const MeshTopology& topology, std::span<const glm::dvec3> points,
                 std::span<const std::int32_t> face_of, Brep& brep);

/// What makes shells and solids valid: each edge is used once each way (once at a boundary), each
/// loop is the border of its face's parameters, once around and counter-clockwise, and edges lie on
/// both faces and end at their vertices within what files say to be one place.
struct BrepCheck {
  std::int64_t broken_loops = 0;     ///< by face
  std::int64_t unmatched_edges = 0;  ///< used otherwise than once each way
  double largest_gap = 0;            ///< of edges from faces and vertices, of the diagonal: at most
  glm::dvec3 largest_gap_at{};       ///< in model coordinates

  [[nodiscard]] bool is_valid() const {
    return broken_loops == 0 && unmatched_edges == 0 && largest_gap <= Brep::kSamePlace;
  }
};

/// Measured on the faces and edges themselves, not on what they were made of. What it does not look
/// at: whether faces cross one another, or a face itself, in space. The same bits for every number
/// of threads.
[[nodiscard]] BrepCheck check_brep(const Brep& brep, double diagonal);

}  // namespace planish
