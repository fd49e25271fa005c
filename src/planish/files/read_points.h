#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// Reads points from memory; `name` stands in messages. Positions are finite and at most
/// kMaxCoordinate in what is returned; colours and normals come along from glTF, OBJ, PLY, PCD, XYZ
/// and PTS, colours and intensity from LAS and PTX, further numbers of points from PLY, PCD, XYZ
/// and PTS. Of formats that hold meshes too, these are the vertices, of glTF those of its
/// primitives of points where it has no triangles. Throws Error{UnreadableInput}: `name:line: what,
/// value` or `name: point 12 of 345: ...`; Error{InvalidArgument} for a format without points.
[[nodiscard]] PointCloud read_points(std::span<const std::byte> bytes, std::string_view name,
                                     FileFormat format);

/// The same, with what a glTF names beside it where `file` has a path. Progress is the share of
/// bytes that are read, as the step "read"; warnings stand in the result.
[[nodiscard]] PointCloud read_points(const FileBytes& file, FileFormat format,
                                     const Callbacks& callbacks = {});

/// The vertices of a file, with its colours and attributes, and its normals where it has no faces.
/// Throws Error{UnreadableInput} as cloud_of().
[[nodiscard]] PointCloud points_of(const MeshFile& file, std::string_view name);

/// Reads a file by its extension. Throws as above.
[[nodiscard]] PointCloud read_points(const std::filesystem::path& path,
                                     const Callbacks& callbacks = {});

}  // namespace planish
