#pragma once

#include <span>
#include <string>

#include "planish/files/shared/file_buffer.h"
#include "planish/files/write_polygons.h"

namespace planish {

class OutputFile;

/// A name as a line of OBJ or MTL can hold it, with a blank in front: control characters, `#`
/// before a word and `\` at the end become `_`.
[[nodiscard]] std::string obj_line_name(const std::string& name);

/// Writes the materials as the library has them; the others each with a colour of its own, by which
/// a viewer shows what belongs together. The file is the caller's to commit. Throws
/// Error{UnwritableOutput}.
void write_mtl(OutputFile& file, std::span<const std::string> materials,
               const GivenMaterials& given = {});

/// The line of an OBJ file that names them.
void write_mtllib(FileBuffer& out, const std::string& file_name);

}  // namespace planish
