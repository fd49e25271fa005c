#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace planish {

/// A polygon that names a vertex twice, as those do whose holes are joined to their outline by a
/// bridge that runs forth and back, cut into triangles: ears in the plane of its vector area. Each
/// triangle is of three places in `polygon`, of different vertices, and turns as the polygon does.
/// Empty where no such triangles are found, as of polygons that cross themselves.
[[nodiscard]] std::vector<std::array<std::int32_t, 3>> split_keyhole(
    std::span<const glm::dvec3> positions, std::span<const std::int32_t> polygon);

}  // namespace planish
