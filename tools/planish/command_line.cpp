#include <oneapi/tbb/version.h>
#include <opensubdiv/version.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "commands.h"
#include "help.h"
#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/platform/process.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/reconstruct/mesher_process.h"
#include "terminal.h"

namespace planish::command {
namespace {

std::string library_text(int number) { return std::to_string(number); }

// "planish 0.1.0 (commit)", then a line for each part that a build may have or lack, with its
// version.
std::string version_text() {
  std::string text = std::string("planish ") + PLANISH_VERSION + " (" + git_revision() + ")\n";
  constexpr int kOsd = OPENSUBDIV_VERSION_NUMBER;
  text += "  OpenSubdiv " + library_text(kOsd / 10000) + "." + library_text(kOsd / 100 % 100) +
          "." + library_text(kOsd % 100) + ", oneTBB " + library_text(TBB_VERSION_MAJOR) + "." +
          library_text(TBB_VERSION_MINOR) + "\n";
#if PLANISH_HAS_VULKAN
  text += "  Vulkan: built in (planish devices lists devices)\n";
#else
  text += "  Vulkan: not built in\n";
#endif
  text += find_mesher_program() ? "  points: planish-reconstruct (CGAL) is installed\n"
                                : "  points: planish-reconstruct (CGAL) is not installed\n";
  return text;
}

}  // namespace
}  // namespace planish::command

namespace CLI {

class ParseError;

}  // namespace CLI

namespace planish::command {
namespace {

namespace fs = std::filesystem;

Error usage_error(const std::string& message) { return Error(ErrorCode::InvalidArgument, message); }

std::string line_for(const std::string& input) {
  const fs::path path = path_of(input);
  if (path.extension() == ".json") return "planish run " + visible(input);
  return "planish fit " + visible(input) + " -o " + output_beside(input);
}

bool looks_like_a_file(const std::string& argument) {
  std::error_code ignored;
  const fs::path path = path_of(argument);
  return format_of(path) || path.extension() == ".json" || fs::is_regular_file(path, ignored) ||
         !conversion_to_readable(path).empty();
}

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
      throw usage_error(visible(name) + " is no flag of planish " + command.get_name() +
                        did_you_mean(name, known));
    }
  }
}

// No file and no value is named so. What is left out would be missed late, if at all.
void refuse_empty(const std::vector<std::string>& arguments) {
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    if (!arguments[i].empty()) continue;
    const std::string& before = arguments[i - 1];
    throw usage_error((before.starts_with('-') && i > 1 ? visible(before) + ": what follows"
                                                        : std::string("an argument")) +
                      " is empty; is a variable not set?");
  }
}

// The arguments (argv) with what hands type by themselves turned into what is meant: `help fit`
// into `fit --help`, `help` into `--help`, `version` and `-V` into `--version`.
std::vector<std::string> with_reflexes_understood(std::vector<std::string> arguments) {
  if (arguments.size() < 2) return arguments;
  const std::string& first = arguments[1];
  if (first == "version" || first == "-V") arguments[1] = "--version";
  if (first != "help") return arguments;
  const bool about_a_command = arguments.size() > 2 && !arguments[2].starts_with('-');
  if (!about_a_command) return {arguments[0], "--help"};
  return {arguments[0], arguments[2], "--help"};
}

// Names the command or flag that is not known before anything else is found amiss: "INPUT is
// required" would hide the slip that moved the input into a flag's place. A file in the place of a
// command is answered with the whole line to type, and an empty argument with whose it is. Throws
// Error{InvalidArgument}.
void check_names(const CLI::App& app, const std::vector<std::string>& arguments) {
  refuse_empty(arguments);
  const auto first =
      std::find_if(arguments.begin() + 1, arguments.end(),
                   [](const std::string& argument) { return !argument.starts_with('-'); });
  if (first == arguments.end()) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == *first) {
      check_flag_names(*command, {first + 1, arguments.end()});
      return;
    }
    if (!command->get_description().empty()) names.push_back(command->get_name());
  }
  if (looks_like_a_file(*first))
    throw usage_error(in_double_quotes(*first) +
                      " is a file and no command; did you mean: " + line_for(*first));
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw usage_error(in_double_quotes(*first) + " is no command" + did_you_mean(*first, known) +
                    " (planish -h lists them)");
}

// What CLI11 found wrong, in words of ours, with what to type.
Error parse_fault(const CLI::App& app, const HelpPage& page, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const auto extras = chosen.empty() ? app.remaining() : chosen.front()->remaining();
    message = extras.empty() ? message
              : extras.front().starts_with('-')
                  ? visible(extras.front()) + " is no flag of " + page.full_name()
                  : page.full_name() + " takes no further argument: " + visible(extras.front());
  } else if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    message =
        page.name.empty() ? "a command is missing" : page.full_name() + ": an argument is missing";
    message += "\n  Usage: " + page.usage();
    if (!page.text.examples.empty()) message += "\n  as in: " + page.text.examples.front();
  }
  return usage_error(message + "\n  " + page.full_name() + " --help shows what is possible");
}

const CommandText kText{
    .examples = {"planish fit goblet.obj -o goblet.glb",
                 "planish fit goblet.obj -o goblet.glb --cage cage.obj --report goblet.json",
                 "planish verify cage.obj goblet.obj", "planish inspect scan.ply"},
    .first_flags = {},
    .notes =
        "planish COMMAND --help has all flags of a command, planish COMMAND -h those that come "
        "first, and \"man planish-fit\" and its like are their manuals."};

void add_commands(CLI::App& app, Invocation& invocation) {
  app.allow_windows_style_options(false);  // for /x.obj is a file
  app.require_subcommand(0, 1);            // so that a job or file may be called as a command is
  // In this order: -h belongs to the flag of --help at first.
  app.set_help_flag("--help", "all help, by topic")->group("Help");
  app.set_help_all_flag("-h", "help on one screen")->group("Help");
  invocation.texts[""] = kText;
  add_fit_command(app, invocation);
  add_try_command(app, invocation);
  add_run_command(app, invocation);
  add_reconstruct_command(app, invocation);
  add_verify_command(app, invocation);
  add_query_command(app, invocation);
  add_inspect_command(app, invocation);
  add_devices_command(app, invocation);
  add_help_commands(app, invocation);
  app.add_flag("-V,--version", invocation.wants_version, "version, commit and parts")
      ->group("Help");
}

// The page of the command that the arguments chose, or planish's own.
HelpPage chosen_page(const CLI::App& app, const Invocation& invocation) {
  HelpPage all = help_page(app, invocation.texts);
  const auto chosen = app.get_subcommands();
  if (chosen.empty()) return all;
  for (HelpPage& page : all.commands)
    if (page.name == chosen.front()->get_name()) return page;
  return all;
}

ExitCode parse_and_run(const std::vector<std::string>& given) {
  const std::vector<std::string> arguments = with_reflexes_understood(given);
  CLI::App app("planish: smooth surfaces that pass exactly through the vertices of a mesh",
               "planish");
  Invocation invocation{.arguments = given, .action = {}};
  add_commands(app, invocation);
  if (arguments.size() <= 1) {
    Console(LogLevel::Info, ColorMode::Never)
        .info(overview(help_page(app, invocation.texts), stdout_columns()));
    return ExitCode::Usage;
  }
  if (arguments[1] == "--version") {
    write_text(version_text());
    return ExitCode::Done;
  }
  check_names(app, arguments);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::CallForAllHelp&) {
    write_text(short_help(chosen_page(app, invocation), stdout_columns()));
    return ExitCode::Done;
  } catch (const CLI::CallForHelp&) {
    write_text(long_help(chosen_page(app, invocation), stdout_columns()));
    return ExitCode::Done;
  } catch (const CLI::ParseError& error) {
    throw parse_fault(app, chosen_page(app, invocation), error);
  }
  if (!invocation.action)
    throw parse_fault(app, chosen_page(app, invocation), CLI::RequiredError("COMMAND"));
  return invocation.action();
}

}  // namespace

HelpPage all_help() {
  CLI::App app("planish: smooth surfaces that pass exactly through the vertices of a mesh",
               "planish");
  Invocation invocation{.arguments = {}, .action = {}};
  add_commands(app, invocation);
  return help_page(app, invocation.texts);
}

ExitCode run_command_line(const std::vector<std::string>& arguments) {
  const MessageStyle style = early_style(arguments);
  const auto say_error = [&](std::string_view message) {
    Console(LogLevel::Error, style.color, style.form).error(message);
  };
  const StopScope scope(interrupt_flag());
  try {
    const ExitCode exit_code = parse_and_run(arguments);
    claim_end();
    return exit_code;
  } catch (const BrokenPipe&) {
    platform::end_by_broken_pipe();
  } catch (const FaultList& faults) {
    for (const std::string& message : faults.messages()) say_error(message);
    return exit_code_of(faults.code());
  } catch (const std::exception&) {
    const Failure failure = job_failure();
    // Who notices first, the library or the command, makes no difference to the reader.
    const bool cancelled = failure.code == ErrorCode::Cancelled;
    if (cancelled) claim_end();
    if (failure.code)
      say_error(cancelled ? "interrupted; no partial file is left" : failure.message);
    else
      say_error(
          formatted("internal error: {}\n  This is a fault of planish. Please report it, with "
                    "the command and the input.",
                    failure.message));
    return failure.code ? exit_code_of(*failure.code) : ExitCode::InternalError;
  }
}

}  // namespace planish::command
