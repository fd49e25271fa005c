#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>

#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// Throws Error{InvalidArgument} where faces or attributes of a surface in memory cannot be
/// written; numbers are checked by require_numbers() and gltf_bounds(). See encode_glb.
void require_writable(const SurfaceMesh& surface, const GltfOptions& options);

/// The same where there is no face, as where all of a mesh's are holes.
void require_a_face(std::int64_t face_count, const GltfOptions& options);

/// The same for numbers that are not finite, and fields that have none for each row.
void require_numbers(const SurfaceBlocks& surface, const GltfOptions& options);

/// Throws Error{InvalidArgument}, naming the surface.
[[noreturn]] void refuse_to_write(const GltfOptions& options, const std::string& what,
                                  std::int64_t element = Error::kNoElement);

/// A texture coordinate from an origin at the bottom left to glTF's at the top left.
[[nodiscard]] inline glm::vec2 stored_uv(const glm::dvec2& uv) { return {uv.x, 1.0 - uv.y}; }

}  // namespace planish
