#pragma once

namespace planish {

/// WebAssembly has but one thread where a server sends no headers of its own.
#ifdef __EMSCRIPTEN__
inline constexpr bool kHasThreads = false;
#else
inline constexpr bool kHasThreads = true;
#endif

}  // namespace planish
