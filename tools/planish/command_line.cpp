#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <new>

#include "commands.h"
#include "options/nearest.h"
#include "planish/core/error.h"
#include "planish/core/version.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  planish fit goblet.obj -o goblet.glb\n"
    "  planish fit goblet.obj -o goblet.glb --cage cage.obj --report goblet.json\n"
    "  planish verify cage.obj goblet.obj\n"
    "  planish fit --help\n";

Error usage_error(const std::string& message) { return Error(ErrorCode::InvalidArgument, message); }

// Colour and quietness are not known while arguments are still being read.
void say_error(std::string_view message) {
  Console(LogLevel::Error, ColorMode::Auto).error(message);
}

// Names the flag that is not known before anything else is found amiss: "INPUT is required"
// would hide the slip that moved the input into a flag's place.
void check_flag_names(const CLI::App& command, const std::vector<std::string>& arguments) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  for (const std::string& argument : arguments) {
    if (argument == "--") return;
    if (!argument.starts_with("--")) continue;
    const std::string name = argument.substr(0, argument.find('='));
    if (std::ranges::find(known, name) == known.end()) {
      throw usage_error(plain_utf8(name) + " is no flag of planish " + command.get_name() +
                        did_you_mean(name, known));
    }
  }
}

void check_names(const CLI::App& app, const std::vector<std::string>& arguments) {
  const auto first =
      std::find_if(arguments.begin() + 1, arguments.end(),
                   [](const std::string& argument) { return !argument.starts_with('-'); });
  if (first == arguments.end()) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) {
    names.push_back(command->get_name());
    if (command->get_name() == *first) {
      if (!command->get_allow_extras()) check_flag_names(*command, {first + 1, arguments.end()});
      return;
    }
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw usage_error("\"" + plain_utf8(*first) + "\" is no command" + did_you_mean(*first, known) +
                    " (planish --help lists them)");
}

ExitCode parse_and_run(const std::vector<std::string>& arguments) {
  CLI::App app("planish: smooth surfaces that pass exactly through the vertices of a mesh",
               "planish");
  app.set_version_flag("--version", "planish " PLANISH_VERSION);
  app.get_formatter()->column_width(36);
  app.footer(kExamples);
  app.require_subcommand(1);
  Invocation invocation{arguments, {}};
  add_fit_command(app, invocation);
  add_run_command(app, invocation);
  add_reconstruct_command(app, invocation);
  add_verify_command(app, invocation);
  add_inspect_command(app, invocation);
  add_devices_command(app, invocation);
  check_names(app, arguments);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app.get_subcommands();
    write_stdout(chosen.empty() ? app.help() : chosen.front()->help("planish"));
    return ExitCode::Done;
  } catch (const CLI::CallForVersion&) {
    write_stdout("planish " PLANISH_VERSION "\n");
    return ExitCode::Done;
  } catch (const CLI::ParseError& error) {
    const auto chosen = app.get_subcommands();
    throw usage_error(std::string(error.what()) + "\n  planish " +
                      (chosen.empty() ? "" : chosen.front()->get_name() + " ") +
                      "--help shows what is possible");
  }
  return invocation.action();
}

}  // namespace

ExitCode run_command_line(const std::vector<std::string>& arguments) {
  try {
    return parse_and_run(arguments);
  } catch (const Error& error) {
    // Who notices first, the library or the command, makes no difference to the reader.
    const bool cancelled = error.code() == ErrorCode::Cancelled;
    say_error(cancelled ? "interrupted; no partial file is left" : error.what());
    return exit_code_of(error.code());
  } catch (const std::bad_alloc&) {
    say_error("out of memory; a lower --levels or a smaller mesh needs less");
    return ExitCode::NoDevice;
  } catch (const std::exception& error) {
    say_error(std::string("internal error: ") + error.what() +
              "\n  This is a fault of planish. Please report it, with the command and the input.");
    return ExitCode::InternalError;
  }
}

}  // namespace planish::command
