#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_surface.h"
#include "planish/vulkan/evaluate/place_layout.h"

namespace planish::vulkan {

/// The place of each row of a surface; of those that several corners share, one of them.
[[nodiscard]] std::vector<SurfacePlace> row_places(const PatchSurface& surface);

/// Of each row, in single precision; v turned over, as images count their rows. The surface's rows
/// are cut at the seams.
[[nodiscard]] std::vector<glm::vec2> row_uvs(const PatchSurface& surface,
                                             const ChartField<glm::dvec2>& field);

/// Where u grows at a row: along tangents[0] times a patch's du and tangents[1] times its dv, as
/// evaluated by the patch that makes the row's normal; in the lowest bit of tangents[1] whether v
/// grows to the right of that. Zeros where the texture has no extent.
struct RowFrame {
  std::uint32_t tangents[2] = {0, 0};  ///< bits of floats
};

/// Of each row. Within a square of Q_1 it is the surface's own derivative by the field's u; rows
/// that faces share have the mean of theirs, each of unit length in the tangent plane of the rings
/// that evaluate it.
[[nodiscard]] std::vector<RowFrame> row_frames(const PatchSurface& surface, Weights weights,
                                               const ChartField<glm::dvec2>& field);

}  // namespace planish::vulkan
