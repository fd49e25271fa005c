#pragma once

#include "planish/core/error.h"
#include "planish/job/report.h"

namespace planish::command {

/// What the process tells its caller; part of the command's interface.
enum class ExitCode : int {
  Done = 0,
  InternalError = 1,
  Usage = 2,                       ///< arguments or scene file wrong
  UnreadableInput = 3,             ///< missing or malformed
  UnusableMesh = 4,                ///< read, but no surface can be made of it
  NotConverged = kFallsShortCode,  ///< files are written, and flagged
  NoDevice = 6,                    ///< no device, device lost, or out of memory
  UnwritableOutput = 7,
  JobsFailed = 8,     ///< some jobs of a run
  Interrupted = 130,  ///< SIGINT
  Terminated = 143,   ///< SIGTERM
};

/// Of a job that was done.
[[nodiscard]] inline ExitCode exit_code_of(const JobReport& report) {
  return report.falls_short ? ExitCode::NotConverged : ExitCode::Done;
}

/// The exit code of a library error. Cancelled: after the signal that was received.
[[nodiscard]] ExitCode exit_code_of(ErrorCode code);

}  // namespace planish::command
