#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace planish {

/// The indices of finite points in the order of a Z-curve through their bounding box: points that
/// are near in the result are near in space, so that arrays in this order stay in the cache. Those
/// at one place follow each other, ascending.
/// Source: G. M. Morton, "A Computer Oriented Geodetic Data Base", 1966.
[[nodiscard]] std::vector<std::int32_t> spatial_order(std::span<const glm::dvec3> points);

}  // namespace planish
