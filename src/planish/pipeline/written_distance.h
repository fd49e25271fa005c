#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "planish/files/formats.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/surface_blocks.h"

// How far the vertices of a file are from the points that its surface passes through, in units of
// the model: what is left of the fit's error, and what rounding for the file adds.
namespace planish {

/// Gives rows of a surface as somebody has them.
using RowPositions = std::function<void(RowRange, std::span<glm::dvec3>)>;

/// The largest distance of the rows of given vertices from these, on all threads; infinite where
/// one is not a number. Nobody holds all rows.
[[nodiscard]] double largest_distance(const SurfaceInfo& info, std::span<const glm::dvec3> given,
                                      const RowPositions& positions);

/// The same as write_surface() has the rows in a file of that format.
[[nodiscard]] double written_distance(const SurfaceBlocks& surface,
                                      std::span<const glm::dvec3> given, FileFormat format);

/// The same as write_gltf() has them, but for compression.
[[nodiscard]] double written_distance(const SurfaceBlocks& surface,
                                      std::span<const glm::dvec3> given,
                                      const GltfOptions& options);

/// The largest distance of points of the same place in two lists; infinite as above.
[[nodiscard]] double largest_distance(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

/// Rounds positions as a format does that keeps single precision.
void round_for(FileFormat format, std::span<glm::dvec3> positions);

}  // namespace planish
