#pragma once

#include <cstddef>
#include <cstdint>

#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

/// What has to come between a round of recorded work and the next. A round is what one recording
/// does between two of its barriers.
struct Wait {
  Scope from{}, to{};

  /// False where a recording has no such round any more.
  explicit operator bool() const noexcept { return from.stages != 0; }
  Wait& operator|=(const Wait& other) noexcept {
    from.stages |= other.from.stages, from.accesses |= other.from.accesses;
    to.stages |= other.to.stages, to.accesses |= other.to.accesses;
    return *this;
  }
};
inline constexpr Wait kKernelWait{kKernelScope, kKernelScope};

/// Recordings that do not depend on each other, in lock-step: round by round, each of `count`
/// records what it has of it by `record_round(i, round)`, which returns its Wait, and one barrier
/// stands for all. Rounds are counted from 0; a recording without a round has none after it.
template <class RecordRound>
void record_rounds(const Context& context, VkCommandBuffer commands, std::size_t count,
                   const RecordRound& record_round) noexcept {
  for (std::uint32_t round = 0;; ++round) {
    Wait wait;
    for (std::size_t i = 0; i < count; ++i) wait |= record_round(i, round);
    if (!wait) return;
    record_barrier(context, commands, wait.from, wait.to);
  }
}

}  // namespace planish::vulkan
