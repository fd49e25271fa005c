#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "commands.h"
#include "planish/core/platform/machine.h"
#include "planish/core/platform/process.h"
#include "terminal.h"

int main(int argc, char** argv) {
  using namespace planish::command;
  planish::platform::keep_freed_memory();
  const std::vector<std::string> arguments = planish::platform::program_arguments(argc, argv);
  install_signal_handlers(early_style(arguments));
  const ExitCode exit_code = run_command_line(arguments);
  // Everything is written and closed. Without the destructors of what the process still holds,
  // since drivers' own can take longer than the work.
  std::fflush(nullptr);
  std::_Exit(static_cast<int>(exit_code));
}
