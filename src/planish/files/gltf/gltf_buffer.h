#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {

/// Most vertices that 16-bit indices are used for. One less than their largest value, which some
/// graphics interfaces take for a primitive restart.
inline constexpr std::uint64_t kMaxShortIndexVertices = 65534;

/// Bytes up to a multiple of four, on which every array of a buffer starts.
[[nodiscard]] inline std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// "TEXCOORD_1" of set 1.
[[nodiscard]] inline std::string uv_name(int set) { return "TEXCOORD_" + std::to_string(set); }
/// 1 of "TEXCOORD_1"; -1: it is no such name.
[[nodiscard]] int uv_set(std::string_view attribute);

/// Fields and attributes of the options, as they are written.
[[nodiscard]] std::vector<GltfAttribute> row_attributes(const GltfOptions& options);

/// Where the arrays of a surface lie in its uncompressed buffer. First, each for all primitives in
/// turn: POSITION (float32 x 3), NORMAL (float32 x 3), TEXCOORD_0, TEXCOORD_1 ... (float32 x 2) of
/// those that have any, COLOR_0 (float32 x 4) where there are any, row_attributes(), of which
/// integers that are fewer than a multiple of 4 bytes have zeros behind them; then the triangle
/// indices of each primitive, in 16 bits where those do.
[[nodiscard]] GltfPayload plain_payload(const SurfaceInfo& info, const GltfVertices& vertices,
                                        const GltfOptions& options);
/// The bounds that the format wants: `positions`, of each primitive, and those of morph targets.
void set_bounds(GltfPayload& payload, std::span<const FloatBox> positions,
                const GltfVertices& vertices, const GltfOptions& options);

/// Sends the buffer of plain_payload() to the sinks in pieces of about a MB, in order, the survey
/// being done.
/// Throws Error{Cancelled} and whatever a sink throws.
void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks);

}  // namespace planish
