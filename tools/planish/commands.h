#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "help.h"
#include "planish/core/option.h"
#include "planish/files/formats.h"
#include "planish/job/job.h"
#include "planish/pipeline/option_table.h"
#include "terminal.h"

namespace CLI {

class App;

}  // namespace CLI

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
void add_try_command(CLI::App& app, Invocation& invocation);
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
void add_page_flags(CLI::App& command, const PageFlags& flags, const char* help);

// What --color and --progress say before arguments are parsed: errors in them obey it, too.
[[nodiscard]] MessageStyle early_style(const std::vector<std::string>& arguments);

/// The pages of planish and all its commands.
[[nodiscard]] HelpPage all_help();

/// Parses, runs, and turns every error into a message on stderr and an exit code.
[[nodiscard]] ExitCode run_command_line(const std::vector<std::string>& arguments);

/// The inputs of a command line, folders replaced by the files in them (not in folders below) whose
/// extension is read, in the order of their names; the order of the arguments stays.
struct InputList {
  std::vector<std::string> paths;
  bool has_folder = false;  ///< one of the arguments was a folder
};

/// Throws Error{UnreadableInput} for a folder without such a file.
[[nodiscard]] InputList expand_inputs(const std::vector<std::string>& arguments);

/// Throws Error{InvalidArgument} where two inputs have one stem, so that their outputs would have
/// one name.
void require_distinct_stems(const std::vector<std::string>& paths);

/// Whether a path names a folder to write into: "-" does not, one that ends in a separator does, or
/// one that is a folder.
[[nodiscard]] bool names_folder(const std::string& path);

/// FOLDER/STEM.EXTENSION of an input; of stdin, FOLDER/stdin.EXTENSION.
[[nodiscard]] std::string path_in_folder(const std::string& folder, const std::string& input,
                                         FileFormat format);

/// A surface's name to propose in a message: NAME.glb, unless that is the input.
[[nodiscard]] std::string output_beside(const std::string& input);

/// What a job of that input is called: its stem, made visible.
[[nodiscard]] std::string job_name_of(const std::string& input);

/// What flags of options were given as, by name of the option.
using OptionTexts = std::map<std::string_view, std::string>;

/// Tags have none: they name vertices.
[[nodiscard]] bool has_flag(const FitOption& option);

/// Adds the flag of an option, whose help ends with the default. `texts` has to outlive the
/// command.
void add_option_flag(CLI::App& command, OptionTexts& texts, const OptionInfo& option,
                     const char* group);

/// Sets what was given, in the order of the table. Throws as read_option().
template <class Target>
void apply_flags(const OptionTexts& texts, const std::vector<Option<Target>>& table,
                 Target& target) {
  read_options(table, texts, flag_of, target);
}

/// "8M", "500K", "2G" or bytes. Throws Error{InvalidArgument} naming `where`.
[[nodiscard]] std::uint64_t parse_page_limit(std::string_view value, std::string_view where);

/// The options as flags give them; an empty limit is the default.
[[nodiscard]] PageOptions page_options(const std::string& limit, bool no_times);

/// The flags of the memory that a command's arrays and the programs it starts may take.
struct MemoryFlags {
  std::string budget, folder;

  void add_to(CLI::App& command);
  /// Where a budget is given, holds large arrays within it from now on; files lie beside `output`
  /// where no folder is named. Throws Error{InvalidArgument, UnwritableOutput}.
  void apply(const std::string& output) const;
};

/// The flags of `fit` as they were given; empty texts are flags that were not.
struct FitFlags {
  std::vector<std::string> inputs, outputs;
  std::string input_format, output_format, cage, source, report, workers, page, page_limit;
  OptionTexts options;
  bool force = false, dry_run = false, page_no_times = false;
  MemoryFlags memory;
  MessageFlags messages;
};

void add_fit_flags(CLI::App& command, FitFlags& flags);

// Each throws Error{InvalidArgument} naming the flag.
[[nodiscard]] std::optional<FileFormat> input_format_of(const FitFlags& flags);
[[nodiscard]] Settings settings_of(const FitFlags& flags);
[[nodiscard]] int workers_of(const FitFlags& flags);

/// The job of one input. With several inputs `-o` and `--cage` have to name folders; report
/// and page are of all jobs and left to the caller.
[[nodiscard]] Job job_of(const FitFlags& flags, const Settings& settings, const std::string& input,
                         bool one_of_several);

}  // namespace planish::command
