#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/job/report.h"

namespace planish {

/// What report_json() is the text of.
[[nodiscard]] nlohmann::ordered_json to_json(const JobReport& report);

/// The "reconstruction" of a report.
[[nodiscard]] nlohmann::ordered_json to_json(const PointFacts& points);

/// Indented text of any JSON value, with a line end. Text that is no UTF-8 is made so.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& value);

/// {"3": 20, "4": 1}: the non-zero entries of a histogram.
[[nodiscard]] nlohmann::ordered_json histogram_json(const std::vector<std::int64_t>& counts);

}  // namespace planish
