#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "job/job.h"
#include "options/word_flags.h"

namespace planish::command {

/// The flags of `fit` as they were given; empty texts are flags that were not.
struct FitFlags {
  std::vector<std::string> inputs, outputs;
  std::string input_format, output_format, cage, source, report, levels, chord_error, angle;
  std::string tolerance, max_iterations, polish, weld, tile_vertices, workers, page, page_limit;
  SettingWords words;  ///< by name of the setting
  bool force = false, dry_run = false, skirts = false, page_no_times = false;
  MessageFlags messages;
};

void add_fit_flags(CLI::App& command, FitFlags& flags);

// Each throws Error{InvalidArgument} naming the flag.
[[nodiscard]] std::optional<FileFormat> input_format_of(const FitFlags& flags);
[[nodiscard]] Settings settings_of(const FitFlags& flags);
/// "2" or "3,1" of --levels.
[[nodiscard]] std::vector<int> parse_levels(const std::string& text);
[[nodiscard]] int workers_of(const FitFlags& flags);

/// The job of one input. With several inputs `-o` and `--cage` have to name folders; report
/// and page are of all jobs and left to the caller.
[[nodiscard]] Job job_of(const FitFlags& flags, const Settings& settings, const std::string& input,
                         bool one_of_several);

}  // namespace planish::command
