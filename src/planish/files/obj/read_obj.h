#pragma once

#include <cstddef>

#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// Wavefront OBJ: v, vt, f (n-gons, negative indices), g, o, usemtl and the tags `t crease`,
/// `t corner` and `t hole` of OpenSubdiv's shapes. Three numbers behind a position are its colour
/// in sRGB, as other programs read and write it, a fourth is its alpha. A face's group takes its
/// name from g, or from o where g names none. Lines, points and free-form elements are counted as
/// dropped. Normals are passed over but for `split_normals_crease`, and in files without faces,
/// which have as many as vertices or none. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_obj(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
