#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// A closed polygon in the plane: outlines counter-clockwise, holes clockwise.
using Loop = std::vector<glm::dvec2>;

struct Profile {
  Loop outline;
  std::vector<Loop> holes;
};

/// The profile's area as triangles in the manner of CAD programs: ears cut off in order, holes
/// bridged, so that long fans and needles arise. Corners are numbered from the outline on, then
/// hole by hole.
[[nodiscard]] std::vector<std::array<std::int32_t, 3>> ears_of(const Profile& profile);
/// The same, extruded from z = 0 to `height` by walls of two triangles a side. Closed.
[[nodiscard]] PolygonMesh extruded_part(const Profile& profile, double height);

/// `count` points, counter-clockwise.
[[nodiscard]] Loop circle(const glm::dvec2& centre, double radius, std::int32_t count);
/// The other way round: a hole.
[[nodiscard]] Loop round_hole(const glm::dvec2& centre, double radius, std::int32_t count);

struct PartSize {
  std::int32_t segments;  ///< of a full circle
  double length = 1;      ///< of the part along its greatest extent, in widths
};
/// An L with a fillet inside the bend and a bore in each leg.
[[nodiscard]] PolygonMesh l_part(const PartSize& size);
/// A plate with `holes` bores of growing radius in a row.
[[nodiscard]] PolygonMesh drilled_plate(const PartSize& size, std::int32_t holes);
/// A spur gear with straight teeth and a bore.
[[nodiscard]] PolygonMesh gear(const PartSize& size, std::int32_t teeth);
/// A long cylinder: strips as needles, caps as fans around one vertex of their rim.
[[nodiscard]] PolygonMesh rod(const PartSize& size);
/// The same, hollow.
[[nodiscard]] PolygonMesh pipe(const PartSize& size);

/// Bodies as makers of props and parts build them, from tables of profiles and outlines. Every one
/// of them takes a fineness: at 1 it is what the maker made, at n it has n times as many segments
/// wherever it is round, on the same true shape, and as many as before where it is flat.

/// A place of a profile or outline, and the side from there to the next.
struct Knot {
  double x, y;
  double turn = 0;         ///< 0: straight; an arc of so many degrees, counter-clockwise; or kCurve
  std::int32_t steps = 1;  ///< of an arc or a curve, at fineness 1
};
/// Knots, as text too: "x y" each, commas between them; then "@90/2" is an arc of 90 degrees in two
/// steps, "~" a step of a curve.
struct Knots : std::vector<Knot> {
  using std::vector<Knot>::vector;
  Knots(const char* text);  // NOLINT(google-explicit-constructor): tables are full of them
};
/// Sides in a row with this turn are one smooth curve through their knots.
inline constexpr double kCurve = 1000;

enum class Sides { Quads, OneWay, ZigZag, Lot, Short };  ///< a quad's diagonal
enum class Ends { Polygon, Hub, Rim, Strip, Ears };  ///< Hub, Rim: a fan about the middle, a corner

/// How faces are cut.
struct Cut {
  Sides sides;
  Ends ends;
  /// In parts of a segment: by so much each vertex of a body of revolution lies off its meridian.
  double unevenness = 0;
};
inline constexpr Cut kQuadCut{Sides::Quads, Ends::Polygon}, kGameCut{Sides::OneWay, Ends::Hub},
    kCadCut{Sides::OneWay, Ends::Ears}, kFanCut{Sides::Short, Ends::Rim},
    kStripCut{Sides::ZigZag, Ends::Strip}, kLotCut{Sides::Lot, Ends::Rim},
    kUnevenCut{Sides::Short, Ends::Rim, 0.3};

[[nodiscard]] Knots rectangle(double x, double y);
/// With round corners of so many steps.
[[nodiscard]] Knots rounded_rectangle(double x, double y, double radius, std::int32_t steps);
/// Of flat sides.
[[nodiscard]] Knots even_polygon(std::int32_t sides, double radius);
/// A circle, and the other way round: a hole.
[[nodiscard]] Knots disc(std::int32_t segments, double radius, const glm::dvec2& centre = {0, 0});
[[nodiscard]] Knots bore(std::int32_t segments, double radius, const glm::dvec2& centre = {0, 0});

/// About the z axis; the profile (radius, z) has the body on its left. Of up to six segments it has
/// flat sides at every fineness. An end off the axis becomes a face; where `is_ring`, the profile
/// is closed instead.
[[nodiscard]] PolygonMesh lathe(std::int32_t fineness, const Knots& profile, std::int32_t segments,
                                const Cut& cut, bool is_ring = false);

/// An outline, and holes in it, carried along `side`, whose places are (inset, z): inwards from the
/// outline, and from a hole into what is around it. Its first place is the bottom, the last one the
/// top, or the floor of a pocket. With holes, ends are cut by ears.
[[nodiscard]] PolygonMesh solid(std::int32_t fineness, const Knots& outline, const Knots& side,
                                const Cut& cut, const std::vector<Knots>& holes = {});

/// The section at a height, scaled, moved and turned.
struct Station {
  double z;
  glm::dvec2 scale{1};
  glm::dvec2 shift{0};
  double degrees = 0;
};
/// Sections on smooth curves through the stations, or on straight lines. A scale of 0 is a point.
[[nodiscard]] PolygonMesh loft(std::int32_t fineness, const Knots& section,
                               const std::vector<Station>& stations, bool is_smooth,
                               const Cut& cut);

/// Of a round section along a path in the plane of x and z without corners; with a bore a pipe.
[[nodiscard]] PolygonMesh tube(std::int32_t fineness, const Knots& path, double radius,
                               std::int32_t segments, const Cut& cut, double bore_radius = 0);
/// The same along a helix about z, `turns` of so many steps.
[[nodiscard]] PolygonMesh coil(std::int32_t fineness, double turns, double pitch, double radius,
                               std::int32_t steps, double wire, std::int32_t segments,
                               const Cut& cut);

/// Turned about x, y and z, one after another, then moved.
[[nodiscard]] PolygonMesh placed(PolygonMesh mesh, const glm::dvec3& shift,
                                 const glm::dvec3& degrees = {0, 0, 0});
[[nodiscard]] PolygonMesh joined(const std::vector<PolygonMesh>& meshes);
/// So many of it, turned about z.
[[nodiscard]] PolygonMesh around_axis(const PolygonMesh& mesh, std::int32_t count);
/// A copy at each place.
[[nodiscard]] PolygonMesh copied(const PolygonMesh& mesh, const std::vector<glm::dvec3>& places);

}  // namespace planish::quality
