#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "planish/core/error.h"

namespace planish {

/// Throws Error{InvalidArgument}: `where: what`, for a value that is not what is wanted there.
[[noreturn]] void refuse(std::string_view where, const std::string& what);
/// With formatted() text.
template <class... Values>
requires(sizeof...(Values) > 0)
    [[noreturn]] void refuse(std::string_view where, FormatText<sizeof...(Values)> format,
                             const Values&... values) {
  refuse(where, formatted(format, values...));
}

/// So many bytes as a size in memory: in WebAssembly it has 32 bits, and files and what they
/// promise may be larger. Throws Error{OutOfMemory}: `where: ...`.
[[nodiscard]] std::size_t memory_size(std::uint64_t bytes, std::string_view where);

/// Throws std::logic_error naming the condition and its place.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace planish

/// Guards against our own bugs, in every build type; wrong input throws planish::Error instead.
#define PLANISH_ASSERT(condition)         \
  (static_cast<bool>(condition) ? void(0) \
                                : ::planish::assertion_failed(#condition, __FILE__, __LINE__))
