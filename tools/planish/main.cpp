#include "commands.h"
#include "terminal/interrupt.h"

int main(int argc, char** argv) {
  planish::command::install_signal_handlers();
  return static_cast<int>(planish::command::run_command_line({argv, argv + argc}));
}
