#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>

#include "commands.h"
#include "help/help_text.h"
#include "memory/large_arrays.h"
#include "options/arguments.h"
#include "planish/core/error.h"
#include "terminal/faults.h"
#include "terminal/interrupt.h"
#include "version_text.h"

namespace planish::command {
namespace {

const CommandText kText{
    .examples = {"planish fit goblet.obj -o goblet.glb",
                 "planish fit goblet.obj -o goblet.glb --cage cage.obj --report goblet.json",
                 "planish verify cage.obj goblet.obj", "planish inspect scan.ply"},
    .first_flags = {},
    .notes =
        "planish COMMAND --help has all flags of a command, planish COMMAND -h those that come "
        "first, and \"man planish-fit\" and its like are their manuals."};

void add_commands(CLI::App& app, Invocation& invocation) {
  app.require_subcommand(0, 1);  // so that a job or file may be called as a command is
  // In this order: -h belongs to the flag of --help at first.
  app.set_help_flag("--help", "all help, by topic")->group("Help");
  app.set_help_all_flag("-h", "help on one screen")->group("Help");
  invocation.texts[""] = kText;
  add_fit_command(app, invocation);
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

// As other filters end whose reader has gone: killed by SIGPIPE, without a word.
[[noreturn]] void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  std::raise(SIGPIPE);
  std::_Exit(128 + SIGPIPE);
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
    end_by_broken_pipe();
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
