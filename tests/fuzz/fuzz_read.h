#pragma once

#include <cstddef>
#include <span>

#include "planish/files/mesh_file.h"
#include "planish/files/point_cloud.h"

namespace planish::test {

/// Reads, checks and counts; aborts when the reader breaks its promises: an Error of another kind,
/// an index out of range, a position that is not finite, any other exception.
void fuzz_read(std::span<const std::byte> bytes, MeshFormat format);

/// The same for points.
void fuzz_read(std::span<const std::byte> bytes, PointFormat format);

}  // namespace planish::test
