#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "devices.h"
#include "terminal/console.h"
#include "terminal/devices_text.h"

namespace planish::command {

void add_devices_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "devices", "compute devices, their limits, and which ones auto and vulkan take");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON, with all limits to the byte")->group("Flags");
  invocation.texts["devices"] = {
      .examples = {"planish devices", "planish devices --json"}, .first_flags = {}, .notes = ""};
  command->callback([json, &invocation] {
    invocation.action = [json] {
      const DeviceList list = list_devices(DeviceScope::All);
      if (*json) {
        write_stdout(devices_json(list));
      } else {
        write_text(devices_table(list));
      }
      return ExitCode::Done;
    };
  });
}

}  // namespace planish::command
