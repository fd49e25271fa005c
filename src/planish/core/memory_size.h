#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace planish {

/// So many bytes as a size in memory: in WebAssembly it has 32 bits, and files and what they
/// promise may be larger. Throws Error{OutOfMemory}: `where: ...`.
[[nodiscard]] std::size_t memory_size(std::uint64_t bytes, std::string_view where);

}  // namespace planish
