#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace planish {

/// What is counted of the work that is done, so that tests can hold it against the size of what was
/// given: a step whose time grows as the square of a ring shows here whatever the machine does.
enum class Work : std::size_t {
  Products,  ///< a weight of a patch by a point
  Points,    ///< control points and faces around that looks for folds and cures ask
  Pairs,     ///< a corner or edge of a face held against, or weighted with, another one of it
};
inline constexpr std::size_t kWorkKinds = 3;

/// Of this process, by kind.
inline std::array<std::atomic<std::int64_t>, kWorkKinds> work_counts{};

/// Of batches, rings and faces at once: it costs an atomic addition. From any thread.
inline void count_work(Work kind, std::int64_t count) {
  work_counts[static_cast<std::size_t>(kind)].fetch_add(count, std::memory_order_relaxed);
}

}  // namespace planish
