#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// Of the progress of writing: where the survey ends, and where all is packed if it is.
inline constexpr double kGltfSurveyed = 0.35, kGltfPacked = 0.97;

/// Smallest and largest float32 coordinates as stored, of each primitive, and the normals that are
/// those of facets.
struct GltfSurvey {
  std::vector<FloatBox> bounds;
  DegenerateRows degenerate;
};
/// Throws Error{InvalidArgument} for a position that float32 cannot hold and a normal that is not
/// of unit length, by its number in `surface_rows` where the surface is a part of another.
[[nodiscard]] GltfSurvey gltf_survey(const SurfaceBlocks& surface, const GltfVertices& vertices,
                                     const GltfOptions& options,
                                     std::span<const std::int32_t> surface_rows = {});
/// The bounds alone. Warns "degenerate-normals".
[[nodiscard]] std::vector<FloatBox> gltf_bounds(const SurfaceBlocks& surface,
                                                const GltfVertices& vertices,
                                                const GltfOptions& options);

}  // namespace planish
