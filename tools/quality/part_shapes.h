#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
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

}  // namespace planish::quality
