#pragma once

#include <array>
#include <cstdint>

#include "planish/brep/step_numbers.h"
#include "planish/brep/step_text.h"
#include "planish/brep/write_step.h"

namespace planish {

/// What entities in the middle of a STEP file refer to.
struct StepContext {
  std::int64_t application = 0, space = 0, plane = 0, placement = 0;
  std::array<std::int64_t, 4> vectors{};
};

/// The header, units and what else stands before any shape.
StepContext put_head(StepText& text, const StepOptions& options);

/// Solids and open shells of one product, each kind in a representation of its own, and colours.
void put_tail(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepContext& context, const StepOptions& options);

}  // namespace planish
