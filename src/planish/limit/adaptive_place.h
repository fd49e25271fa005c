#pragma once

#include <cstdint>

namespace planish {

/// A place on a corner's patch as CornerParameter has it, u and v in whole parts of kCellSide.
struct AdaptivePlace {
  std::int32_t corner = 0;
  std::uint16_t u = 0, v = 0;
};

}  // namespace planish
