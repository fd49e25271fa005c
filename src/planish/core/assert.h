#pragma once

namespace planish {

/// Throws std::logic_error naming the condition and its place.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace planish

/// Guards against our own bugs, in every build type; wrong input throws planish::Error instead.
#define PLANISH_ASSERT(condition)         \
  (static_cast<bool>(condition) ? void(0) \
                                : ::planish::assertion_failed(#condition, __FILE__, __LINE__))
