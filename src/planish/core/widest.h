#pragma once

// For loops over numbers side by side that become vectors. Their source is compiled as
// planish_widest() of tools/cmake/PlanishOptions.cmake says: nothing is fused, so that all widths
// give the same bits.

/// Before a function: compiled for several widths, of which the widest that the processor has is
/// chosen when the program is loaded. The thread sanitizer crashes in functions that choose, since
/// they run before it does.
#ifdef __has_feature  // Clang has no macro for it
#if __has_feature(thread_sanitizer) && !defined(__SANITIZE_THREAD__)
#define __SANITIZE_THREAD__
#endif
#endif
#if defined(__x86_64__) && defined(__ELF__) && !defined(__SANITIZE_THREAD__)
#define PLANISH_WIDEST __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define PLANISH_WIDEST
#endif

/// Before what such a function calls: loops become vectors only where everything is in line.
#define PLANISH_IN_LINE inline __attribute__((always_inline))
