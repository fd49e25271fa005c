#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "options/settings.h"
#include "planish/distributed/fit_distributed.h"
#include "planish/files/formats.h"

namespace planish::command {

/// What `planish-mpi fit` was asked for.
struct MpiJob {
  std::string input;
  std::optional<FileFormat> input_format;
  Settings settings;
  DistributedOptions options;
  std::string tiles, cage, report;
  bool force = false;
  double watchdog_seconds = 600;
  std::string text;  ///< to be printed instead of any work: help or version
};

/// Reads the command line. Throws Error{InvalidArgument} naming the flag for what is wrong, and for
/// what `planish fit` has and this program has not.
[[nodiscard]] MpiJob parse_mpi_flags(const std::vector<std::string>& arguments);

/// Throws Error{UnwritableOutput} where an output exists already, or has no folder.
void require_writable(const MpiJob& job);

}  // namespace planish::command
