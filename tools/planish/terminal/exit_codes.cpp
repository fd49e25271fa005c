#include "terminal/exit_codes.h"

#include <csignal>

#include "terminal/interrupt.h"

namespace planish::command {

ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return ExitCode::Usage;
    case ErrorCode::UnreadableInput:
      return ExitCode::UnreadableInput;
    case ErrorCode::UnusableMesh:
      return ExitCode::UnusableMesh;
    case ErrorCode::NoDevice:
    case ErrorCode::DeviceLost:
    case ErrorCode::OutOfMemory:
      return ExitCode::NoDevice;
    case ErrorCode::UnwritableOutput:
      return ExitCode::UnwritableOutput;
    case ErrorCode::Cancelled:
      return interrupt_signal() == SIGTERM ? ExitCode::Terminated : ExitCode::Interrupted;
  }
  return ExitCode::InternalError;
}

}  // namespace planish::command
