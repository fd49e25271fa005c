#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "planish/files/shared/file_buffer.h"

namespace planish {

/// A name as a line of OBJ or MTL can hold it, with a blank in front: control characters, `#`
/// before a word and `\` at the end become `_`.
[[nodiscard]] std::string obj_line_name(const std::string& name);

/// Writes the materials through OutputFile, each with a colour of its own: OBJ keeps names only,
/// and a viewer shows by them what belongs together. Throws Error{UnwritableOutput}.
void write_mtl(const std::filesystem::path& path, std::span<const std::string> materials);

/// The line of an OBJ file that names them.
void write_mtllib(FileBuffer& out, const std::string& file_name);

}  // namespace planish
