#pragma once

#include <string>

#include "planish/job/report.h"

namespace planish {

/// What `-v` adds to the summary: threads, the bound of the spectrum, the error after every
/// iteration, peak memory, what fold repair chose.
[[nodiscard]] std::string details(const JobReport& report);

/// What can be done with what was written, for a person at a terminal.
[[nodiscard]] std::string next_step(const JobReport& report);

}  // namespace planish
