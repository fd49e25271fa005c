#pragma once

#include <string>
#include <vector>

#include "commands.h"
#include "mpi_job.h"

namespace planish::command {

/// What the command line asks for.
struct MpiRequest {
  std::string text;                ///< to be printed instead of any work: help or version
  std::vector<Job> jobs;           ///< of `fit` its one
  std::string scene;               ///< of `run`
  std::vector<std::string> names;  ///< jobs of it; all where none is named
  MpiSettings own;
  MessageFlags messages;
};

/// Reads the command line, whose flags are those of `planish fit` and `planish run` with a few
/// more. Throws Error{InvalidArgument} naming the flag for what is wrong, and for what ranks have
/// not.
[[nodiscard]] MpiRequest parse_mpi_flags(const std::vector<std::string>& arguments);

}  // namespace planish::command
