#pragma once

#include <vector>

#include "planish/pipeline/option_table.h"

namespace planish {

// The rows of option_table() about what is written.

/// Of files in general, and of glTF.
[[nodiscard]] std::vector<FitOption> file_options();
[[nodiscard]] std::vector<FitOption> tile_options();
[[nodiscard]] std::vector<FitOption> step_options();
[[nodiscard]] std::vector<FitOption> fineness_options();

}  // namespace planish
