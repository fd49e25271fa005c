#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

enum class MeshFormat { Obj, Ply, Off, Stl, Gltf, Glb };

/// Lower-case extension without the dot: "obj".
[[nodiscard]] std::string_view name_of(MeshFormat format);

/// By extension, any case; empty for an unknown one.
[[nodiscard]] std::optional<MeshFormat> format_of(const std::filesystem::path& path);

/// A mesh as read, with what the reader had to do.
struct MeshFile {
  PolygonMesh mesh;
  MeshFormat format = MeshFormat::Obj;
  std::int64_t welded_vertex_count = 0;    ///< vertices merged with one at the same position
  std::int64_t dropped_element_count = 0;  ///< lines, points and the like that carry no surface
  std::vector<Warning> warnings;
  std::vector<std::string> header;  ///< `# planish key=value` comment lines of a cage
};

/// Reads OBJ, PLY, OFF or STL from memory. `name` stands in messages. n-gons are kept; STL is
/// welded by exact position. Indices are in range and positions finite in what is returned; the
/// other conditions of check() are not tested here.
/// Throws Error{UnreadableInput}: `name:line: what, value`.
[[nodiscard]] MeshFile read_mesh(std::span<const std::byte> bytes, std::string_view name,
                                 MeshFormat format);

/// The whole file as bytes. Throws Error{UnreadableInput} with the system's reason.
[[nodiscard]] std::vector<std::byte> read_file(const std::filesystem::path& path);

struct MeshWriteOptions {
  std::vector<std::string> header;  ///< comment lines, without the comment sign
};

/// Writes OBJ, PLY (binary little endian, double) or OFF through OutputFile; n-gons are kept. OBJ
/// holds all that a mesh has, so that reading it gives the same mesh; PLY holds its colours too
/// (8 bits), OFF positions and faces only. Text numbers are shortest round-trip doubles.
/// Throws Error{UnwritableOutput}, Error{InvalidArgument} for other formats.
void write_mesh(const std::filesystem::path& path, MeshFormat format, const PolygonMesh& mesh,
                const MeshWriteOptions& options = {});

}  // namespace planish
