#include <CLI/CLI.hpp>
#include <array>
#include <memory>

#include "commands.h"
#include "help/completion.h"
#include "help/manual.h"
#include "options/scene_schema.h"
#include "planish/core/error.h"
#include "planish/core/nearest.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

ExitCode print_completion(const std::string& name) {
  constexpr std::array<std::string_view, 3> kShells{"bash", "zsh", "fish"};
  const auto shell = shell_of(name);
  if (!shell)
    throw Error(ErrorCode::InvalidArgument,
                formatted("planish completion: \"{}\" is not one of bash, zsh, fish{}",
                          visible(name), did_you_mean(name, kShells)));
  write_stdout(completion_script(*shell, all_help()));
  return ExitCode::Done;
}

ExitCode print_manual(const std::string& name) {
  const HelpPage help = all_help();
  if (name.empty()) {
    write_stdout(manual_page(help, help));
    return ExitCode::Done;
  }
  for (const HelpPage& page : help.commands) {
    if (page.name != name) continue;
    write_stdout(manual_page(page, help));
    return ExitCode::Done;
  }
  throw Error(ErrorCode::InvalidArgument, "planish has no command \"" + visible(name) + "\"");
}

ExitCode print_schema() {
  write_stdout(scene_schema_text());
  return ExitCode::Done;
}

}  // namespace

void add_help_commands(CLI::App& app, Invocation& invocation) {
  CLI::App* completion =
      app.add_subcommand("completion", "a script that completes planish's flags in a shell");
  auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "the shell")->type_name("bash|zsh|fish")->required();
  invocation.texts["completion"] = {
      .examples = {"planish completion bash > ~/.local/share/bash-completion/completions/planish",
                   "planish completion zsh > ~/.zfunc/_planish",
                   "planish completion fish > ~/.config/fish/completions/planish.fish"},
      .first_flags = {},
      .notes = ""};
  completion->callback(
      [shell, &invocation] { invocation.action = [shell] { return print_completion(*shell); }; });
  // For the build, which installs what it prints; without a description it is not listed.
  CLI::App* manual = app.add_subcommand("manual", "");
  auto page = std::make_shared<std::string>();
  auto schema = std::make_shared<bool>(false);
  manual->add_option("COMMAND", *page, "")->type_name("[COMMAND]");
  manual->add_flag("--schema", *schema, "the JSON schema of scene files");
  manual->callback([page, schema, &invocation] {
    invocation.action = [page, schema] { return *schema ? print_schema() : print_manual(*page); };
  });
}

}  // namespace planish::command
