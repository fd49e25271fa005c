#pragma once

#include <filesystem>
#include <vector>

#include "quality/cases.h"

namespace planish::quality {

/// Meshes of uneven triangles, each with the shape that it was taken from: a formula, or the dense
/// mesh before it was simplified.
[[nodiscard]] std::vector<NamedCase> irregular_cases();

/// A file's mesh, simplified within 1e-3 of its diagonal: the shape is the mesh in the file.
/// Throws as read_mesh().
[[nodiscard]] NamedCase simplified_file(const std::filesystem::path& path);

}  // namespace planish::quality
