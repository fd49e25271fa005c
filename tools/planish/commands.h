#pragma once

#include <functional>
#include <string>
#include <vector>

#include "help/command_page.h"
#include "terminal/console.h"
#include "terminal/exit_codes.h"
#include "terminal/progress.h"

namespace CLI {
class App;
}

namespace planish::command {

/// What the arguments ask for. The chosen sub-command sets `action` while arguments are parsed;
/// it runs after that. Actions throw planish::Error.
struct Invocation {
  std::vector<std::string> arguments;  ///< argv
  CommandTexts texts{};                ///< for help, by command
  bool wants_version = false;
  std::function<ExitCode()> action;
};

// Each adds one sub-command with its flags and help to `app`.
void add_fit_command(CLI::App& app, Invocation& invocation);
void add_run_command(CLI::App& app, Invocation& invocation);
void add_reconstruct_command(CLI::App& app, Invocation& invocation);
void add_verify_command(CLI::App& app, Invocation& invocation);
void add_query_command(CLI::App& app, Invocation& invocation);
void add_inspect_command(CLI::App& app, Invocation& invocation);
void add_devices_command(CLI::App& app, Invocation& invocation);
/// `completion`, and `manual`, which the build calls.
void add_help_commands(CLI::App& app, Invocation& invocation);

/// The flags about messages, shared by sub-commands.
struct MessageFlags {
  bool quiet = false, verbose = false;
  std::string log_level = "info", color = "auto", progress = "auto";

  void add_to(CLI::App& command, bool with_progress);
  [[nodiscard]] LogLevel level() const;
  [[nodiscard]] ColorMode color_mode() const;
  [[nodiscard]] ProgressMode progress_mode() const;
  [[nodiscard]] MessageForm form() const;
};

/// What `--page` and its kin set.
struct PageFlags {
  std::string& path;
  std::string& limit;
  bool& no_times;
};

/// The flags of a page, for `fit` and `run`.
void add_page_flags(CLI::App& command, const PageFlags& flags);

// What --color and --progress say before arguments are parsed: errors in them obey it, too.
[[nodiscard]] MessageStyle early_style(const std::vector<std::string>& arguments);

/// The pages of planish and all its commands.
[[nodiscard]] HelpPage all_help();

/// Parses, runs, and turns every error into a message on stderr and an exit code.
[[nodiscard]] ExitCode run_command_line(const std::vector<std::string>& arguments);

}  // namespace planish::command
