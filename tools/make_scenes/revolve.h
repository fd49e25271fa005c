#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

struct RevolveOptions {
  std::int32_t segment_count = 64;  ///< around the axis; a multiple of 4, at least 8
  std::int32_t ring_count = 119;    ///< circles along the profile between the two caps
  double cap_radius = 0.3;          ///< within it, discs of quads close the surface at the axis
};

/// Surface of revolution about the y axis, quads only, genus 0. `profile` holds (radius, height)
/// knots of a smooth curve from the axis, outward below and back to the axis above; radii rise from
/// 0 to beyond the cap at its start and fall likewise at its end. Rings lie closer where the curve
/// bends.
[[nodiscard]] PolygonMesh revolve(std::span<const glm::dvec2> profile,
                                  const RevolveOptions& options);

/// Wine goblet: foot, stem with a knop, thin-walled bowl; 8,066 vertices, genus 0, y up.
[[nodiscard]] PolygonMesh goblet();

}  // namespace planish::shapes
