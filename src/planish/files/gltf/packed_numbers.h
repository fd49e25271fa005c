#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/core/raw_vector.h"

namespace planish {

/// The exponent of the coarsest grid 2^e on which every number moves by less than `error` / sqrt(3)
/// and has 24 bits: vectors of three then move by less than `error`. Empty where float32 has no
/// more room than such a grid, or `error` is 0.
[[nodiscard]] std::optional<int> grid_exponent(std::span<const float> numbers, double error);

/// Numbers as the meshopt filter "EXPONENTIAL" decodes them, mantissa * 2^exponent, all with one
/// exponent: of 12-byte vectors only the low bytes then change from one to the next.
[[nodiscard]] RawVector<std::uint32_t> on_grid(std::span<const float> numbers, int exponent);

/// Unit vectors as the filter "OCTAHEDRAL" decodes them to int16 x 4: `width` 3, the fourth 0, or
/// 4, which is kept. 14 bits turn them by at most 0.02 degrees.
[[nodiscard]] RawVector<std::int16_t> octahedral(std::span<const float> vectors, std::size_t width);

/// The same as int16 x 4 normalised.
[[nodiscard]] RawVector<std::int16_t> short_vectors(std::span<const float> vectors,
                                                    std::size_t width);

/// Numbers from 0 to 1 as uint16, 65535 for 1.
[[nodiscard]] RawVector<std::uint16_t> unit_shorts(std::span<const float> numbers);

/// Bytes of the meshopt vertex codec, version 0. `size` bytes a vertex, a multiple of 4 up to 256.
[[nodiscard]] RawVector<std::byte> encode_vertices(std::span<const std::byte> vertices,
                                                   std::size_t size);
/// Bytes of the meshopt index codec, version 1.
[[nodiscard]] RawVector<std::byte> encode_triangles(std::span<const std::uint32_t> indices,
                                                    std::size_t vertex_count);

/// What a reader gets from on_grid() and encode_vertices().
[[nodiscard]] RawVector<glm::vec3> decode_grid(std::span<const std::byte> encoded,
                                               std::size_t count);
/// The same without the filter.
[[nodiscard]] RawVector<glm::vec3> decode_vectors(std::span<const std::byte> encoded,
                                                  std::size_t count);

/// Triangles and vertices in an order in which neighbours follow each other.
struct StripOrder {
  RawVector<std::uint32_t> indices;       ///< of the triangles, naming vertices in the new order
  RawVector<std::uint32_t> new_vertices;  ///< by old vertex; every vertex has one
};

/// Triangles in strips, blocks of them on all threads, then vertices as triangles first use them;
/// those that none uses come last. The result does not depend on the threads.
/// Source: meshoptimizer's vertex cache optimiser for strips.
[[nodiscard]] StripOrder strip_order(std::span<const std::uint32_t> indices,
                                     std::size_t vertex_count);

}  // namespace planish
