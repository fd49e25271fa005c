#pragma once

namespace planish {

/// The commit that the build was configured at, or "unknown".
[[nodiscard]] const char* git_revision();

/// WebAssembly has but one thread where a server sends no headers of its own.
#ifdef __EMSCRIPTEN__
inline constexpr bool kHasThreads = false;
#else
inline constexpr bool kHasThreads = true;
#endif

}  // namespace planish
