#pragma once

#include <string>

#include "planish/core/json.h"

namespace planish {

// Pictures of a report's figures as SVG that needs no script and prints. `id` makes the names of
// their parts unlike those of other jobs.

/// Largest and rms error by iteration, on a logarithmic scale, with the tolerance; below it the
/// same as a table. `solve`: of a report; its history is not empty.
[[nodiscard]] std::string convergence_plot(const nlohmann::ordered_json& solve,
                                           const std::string& id);

/// The steps of a run as one bar, named below it. `timing`: timing_ms of a report.
[[nodiscard]] std::string timing_bar(const nlohmann::ordered_json& timing, const std::string& id);

}  // namespace planish
