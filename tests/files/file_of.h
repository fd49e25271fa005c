#pragma once

#include <string_view>

#include "mesh/test_meshes.h"
#include "planish/files/formats.h"

namespace planish::test {

/// A file in memory; `bytes` must live longer.
[[nodiscard]] inline FileBytes file_of(std::string_view bytes, std::string_view name,
                                       bool is_strict = false) {
  return {.bytes = bytes_of(bytes), .name = name, .path = {}, .is_strict = is_strict};
}

}  // namespace planish::test
