#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "planish/files/mesh_file.h"

namespace planish::command {

/// A mesh with what a report says of its file.
struct Input {
  std::string name;  ///< the path, or "stdin": what messages say
  MeshFile file;
  std::string sha256;
};

/// Reads a mesh by its extension, or by `format` where given; "-" reads stdin, which needs a
/// format. Throws Error{UnreadableInput}; Error{InvalidArgument} for an extension that is not read.
[[nodiscard]] Input read_input(const std::string& path, std::optional<FileFormat> format);

/// The format that read_input() would take, with its errors; reads nothing.
[[nodiscard]] FileFormat input_format_of(const std::string& path, std::optional<FileFormat> format);

/// "obj", "ply", "off", "stl", "gltf" or "glb". Throws Error{InvalidArgument} naming `where`.
[[nodiscard]] FileFormat parse_mesh_format(std::string_view value, std::string_view where);

}  // namespace planish::command
