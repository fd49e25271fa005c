#include "commands.h"
#include "planish/core/error.h"

namespace planish::command {

void add_reconstruct_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand("reconstruct", "points to a polygon mesh; not built yet");
  // Whatever flags it will have, the answer is the same.
  command->allow_extras();
  command->callback([&invocation] {
    invocation.action = []() -> ExitCode {
      throw Error(ErrorCode::InvalidArgument,
                  "planish reconstruct is not built yet; planish fit takes a polygon mesh");
    };
  });
}

}  // namespace planish::command
