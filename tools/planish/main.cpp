#include <cstdio>
#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "commands.h"
#include "terminal.h"

namespace {

// Every step of a job takes and frees arrays of megabytes. glibc gives those back to the system at
// once, which then zeroes fresh pages for the next step: a third of a fit's time.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_TOP_PAD, 64 << 20);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  using namespace planish::command;
  keep_freed_memory();
  const std::vector<std::string> arguments(argv, argv + argc);
  install_signal_handlers(early_style(arguments));
  const ExitCode exit_code = run_command_line(arguments);
  // Everything is written and closed. Without the destructors of what the process still holds,
  // since drivers' own can take longer than the work.
  std::fflush(nullptr);
  std::_Exit(static_cast<int>(exit_code));
}
