#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "options/memory_flags.h"
#include "options/option_flags.h"
#include "planish/job/job.h"

namespace planish::command {

/// The flags of `fit` as they were given; empty texts are flags that were not.
struct FitFlags {
  std::vector<std::string> inputs, outputs;
  std::string input_format, output_format, cage, source, report, workers, page, page_limit;
  OptionTexts options;
  bool force = false, dry_run = false, page_no_times = false;
  MemoryFlags memory;
  MessageFlags messages;
};

void add_fit_flags(CLI::App& command, FitFlags& flags);

// Each throws Error{InvalidArgument} naming the flag.
[[nodiscard]] std::optional<FileFormat> input_format_of(const FitFlags& flags);
[[nodiscard]] Settings settings_of(const FitFlags& flags);
[[nodiscard]] int workers_of(const FitFlags& flags);

/// The job of one input. With several inputs `-o` and `--cage` have to name folders; report
/// and page are of all jobs and left to the caller.
[[nodiscard]] Job job_of(const FitFlags& flags, const Settings& settings, const std::string& input,
                         bool one_of_several);

}  // namespace planish::command
