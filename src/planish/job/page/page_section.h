#pragma once

#include <string>

#include "planish/core/json.h"

namespace planish {

// The parts of a page that need no script, all of them from a job's JSON report: nothing on a page
// can differ from it.

/// Report in one sentence or a few: what stands for the picture where none is seen.
[[nodiscard]] std::string summary_sentence(const nlohmann::ordered_json& report);

/// Everything about one job; `number` is its place on the page. `view_note` says what the view
/// shows of it, or why it has none; `still`: PageJob's.
[[nodiscard]] std::string job_section(const nlohmann::ordered_json& report, std::size_t number,
                                      const std::string& view_note, const std::string& still = {});

/// The same for a job that ended with an error.
[[nodiscard]] std::string failed_section(const std::string& name, const std::string& message,
                                         std::size_t number);

/// A row of the table of all jobs.
[[nodiscard]] std::string overview_row(const nlohmann::ordered_json& report, std::size_t number);
[[nodiscard]] std::string failed_row_html(const std::string& name, std::size_t number);

/// What a job is called where it is compared with others: its name and method.
[[nodiscard]] std::string job_label(const nlohmann::ordered_json& report);

}  // namespace planish
