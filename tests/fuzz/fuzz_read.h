#pragma once

#include <cstddef>
#include <span>

#include "planish/files/formats.h"

namespace planish::test {

/// Reads, checks and counts; aborts when the reader breaks its promises: an Error of another kind,
/// an index out of range, a position that is not finite, any other exception.
void fuzz_read_mesh(std::span<const std::byte> bytes, FileFormat format);

/// The same of a Draco stream, with two bytes for its points and two for its triangles in front,
/// as a GLB has it.
void fuzz_read_draco(std::span<const std::byte> bytes, FileFormat format);

/// The same for points.
void fuzz_read_points(std::span<const std::byte> bytes, FileFormat format);

}  // namespace planish::test
