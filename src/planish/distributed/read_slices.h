#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "planish/distributed/mesh_slice.h"
#include "planish/files/formats.h"
#include "planish/files/ply/ply_header.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What a format that cannot be read in slices may have at most: rank 0 reads it whole.
inline constexpr std::int64_t kMostWholeBytes = std::int64_t{2} << 30;

/// Reads a mesh, each rank a part: binary little-endian PLY and OBJ by ranges of bytes, other
/// formats (and forms of PLY) by rank 0, which sends the slices. Throws AgreedError:
/// UnreadableInput for files that are missing, damaged or cut, InvalidArgument for formats of
/// points and for files above kMostWholeBytes that cannot be read in slices.
[[nodiscard]] MeshSlice read_slices(const Ranks& ranks, const std::string& path,
                                    std::optional<FileFormat> format = std::nullopt);

/// The slices of a mesh that rank 0 has; that of other ranks is not looked at.
[[nodiscard]] MeshSlice scatter_mesh(const Ranks& ranks, const PolygonMesh& mesh);

/// A PLY whose vertices are of a fixed size, and whose last element are the faces with one list.
[[nodiscard]] bool has_sliceable_body(const PlyHeader& header);
[[nodiscard]] MeshSlice read_ply_slices(const Ranks& ranks, const std::string& path,
                                        const PlyHeader& header);
[[nodiscard]] MeshSlice read_obj_slices(const Ranks& ranks, const std::string& path);

}  // namespace planish
