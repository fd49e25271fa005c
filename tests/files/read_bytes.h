#pragma once

#include <string>
#include <string_view>

#include "files/gltf/glb_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/read_gltf.h"
#include "support/calls.h"

namespace planish::test {

/// A file in memory; `bytes` must live longer.
[[nodiscard]] inline FileBytes file_of(std::string_view bytes, std::string_view name,
                                       bool is_strict = false) {
  return {.bytes = bytes_of(bytes), .name = name, .path = {}, .is_strict = is_strict};
}

inline MeshFile read_glb(const std::string& bytes) {
  return read_mesh(bytes_of(bytes), "a.glb", FileFormat::Glb);
}

/// The message that these bytes are refused with.
inline std::string glb_error(const std::string& bytes) {
  return message_of(ErrorCode::UnreadableInput, [&] { (void)read_glb(bytes); });
}

/// The square of glb_bytes.h with one change of its JSON.
inline MeshFile read_square(const std::string& from, const std::string& to) {
  return read_glb(glb_of(replaced(square_json(), from, to), square_chunk()));
}
inline std::string square_error(const std::string& from, const std::string& to) {
  return glb_error(glb_of(replaced(square_json(), from, to), square_chunk()));
}

}  // namespace planish::test
