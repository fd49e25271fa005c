#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "job/inspection.h"
#include "options/option_flags.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/job/input_path.h"
#include "planish/job/report_json.h"
#include "planish/pipeline/option_table.h"
#include "terminal/faults.h"

namespace planish::command {
namespace {

struct InspectFlags {
  std::vector<std::string> files;
  std::string input_format;
  OptionTexts options;
  bool json = false;
  MessageFlags messages;
};

// What is wrong with a file does not keep the others from being looked at.
ExitCode inspect_all(const InspectFlags& flags) {
  Console console(flags.messages.level(), flags.messages.color_mode());
  std::optional<FileFormat> format;
  if (!flags.input_format.empty())
    format = parse_input_format(flags.input_format, "--input-format");
  FitSettings settings;
  apply_flags(flags.options, option_table(), settings);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  ExitCode exit_code = ExitCode::Done;
  Faults faults;
  for (const std::string& path : flags.files) {
    faults.note([&] {
      require_input(path, format);
      InputFile file = load_input(path, format);
      if (flags.json) file.take_digest();
      file.reach = settings.textures;
      const Inspection inspection = inspect(file);
      if (is_refused(inspection)) exit_code = ExitCode::UnusableMesh;
      if (flags.json) {
        all.push_back(inspection_json(inspection));
      } else {
        write_text(inspection_text(inspection));
      }
    });
  }
  if (flags.json && !all.empty())
    write_stdout(json_text(flags.files.size() == 1 ? all.front() : all));
  faults.throw_if_any();
  return exit_code;
}

}  // namespace

void add_inspect_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "inspect", "what a file of a mesh or points holds, and what is wrong in it");
  auto flags = std::make_shared<InspectFlags>();
  const char* group = "Flags";
  command->add_option("FILE", flags->files, "meshes or points; - for stdin")
      ->type_name("FILE...")
      ->required();
  command
      ->add_option("--input-format", flags->input_format,
                   "of stdin, or against the extension [what the content looks like]")
      ->type_name(names_of(FormatUse::Read, "|"))
      ->group(group);
  add_option_flag(*command, flags->options, fit_option("textures"), group);
  command->add_flag("--json", flags->json, "as JSON; of several files a list")->group(group);
  flags->messages.add_to(*command, false);
  invocation.texts["inspect"] = {
      .examples = {"planish inspect bunny.obj", "planish inspect bunny.obj scan.ply --json"},
      .first_flags = {},
      .notes =
          "Exit code 4 when a mesh has problems that planish fit cannot mend. What it mends, with "
          "warnings, is listed, and the exit code is 0; planish fit --repair none refuses that, "
          "too."};
  command->callback(
      [flags, &invocation] { invocation.action = [flags] { return inspect_all(*flags); }; });
}

}  // namespace planish::command
