#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_surface.h"
#include "planish/vulkan/evaluate/place_layout.h"

namespace planish::vulkan {

/// The place of each row of a surface; of those that several corners share, one of them.
[[nodiscard]] std::vector<SurfacePlace> row_places(const PatchSurface& surface);

/// Texture coordinates at the corners of the surface's faces.
struct CornerValues {
  std::span<const std::int32_t> indices;  ///< one a corner, not below 0
  std::span<const glm::dvec2> values;     ///< what lies behind them is 0
  [[nodiscard]] glm::dvec2 at(std::int32_t corner) const {
    const auto index = static_cast<std::size_t>(indices[corner]);
    return index < values.size() ? values[index] : glm::dvec2(0.0);
  }
};

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

/// Of each row, for what is linear between corners. Within a square of Q_1 it is the surface's own
/// derivative by the texture's u; rows
/// that faces share have the mean of theirs, each of unit length in the tangent plane of the rings
/// that evaluate it.
[[nodiscard]] std::vector<RowFrame> row_frames(const PatchSurface& surface, Weights weights,
                                               const CornerValues& corners);

}  // namespace planish::vulkan
