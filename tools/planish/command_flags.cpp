#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.h"
#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/job_text.h"

namespace planish::command {
namespace {

// "500K", "8M", "4G" or plain bytes. Throws Error{InvalidArgument} naming `where` for what is no
// size of up to `most`, with an example.
std::uint64_t parse_size(std::string_view value, std::string_view where, std::uint64_t most,
                         std::string_view example) {
  std::uint64_t number = 0;
  const auto [next, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const std::string_view unit(next, static_cast<std::size_t>(value.data() + value.size() - next));
  int shift = -1;
  if (unit.empty()) shift = 0;
  if (unit == "K" || unit == "k") shift = 10;
  if (unit == "M" || unit == "m") shift = 20;
  if (unit == "G" || unit == "g") shift = 30;
  if (error != std::errc() || shift < 0 || number > most >> shift) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: \"{}\" is no size of up to {}G, such as {}", where,
                          plain_utf8(value), most >> 30, example));
  }
  return number << shift;
}

namespace fs = std::filesystem;

std::string stem_of(const std::string& input) {
  return input == "-" ? "stdin" : utf8(path_of(input).stem());
}

std::vector<std::string> files_in(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> paths;
  fs::directory_iterator entry(path_of(folder), error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    const auto format = format_of(entry->path());
    if (format && serves(*format, FormatUse::Read) && entry->is_regular_file(ignored))
      paths.push_back(utf8(entry->path()));
  }
  if (error)
    throw Error(ErrorCode::UnreadableInput, visible(folder) + ": cannot read: " + error.message());
  if (paths.empty())
    throw Error(ErrorCode::UnreadableInput,
                formatted("{}: this folder holds no file that is read ({})", visible(folder),
                          extensions_of(FormatUse::Read)));
  std::ranges::sort(paths);
  return paths;
}

}  // namespace

InputList expand_inputs(const std::vector<std::string>& arguments) {
  InputList list;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (argument != "-" && fs::is_directory(path_of(argument), error)) {
      list.has_folder = true;
      const auto files = files_in(argument);
      list.paths.insert(list.paths.end(), files.begin(), files.end());
    } else {
      list.paths.push_back(argument);
    }
  }
  return list;
}

void require_distinct_stems(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> by_stem;
  for (const std::string& path : paths) {
    const auto [known, is_new] = by_stem.emplace(stem_of(path), path);
    if (is_new) continue;
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("{} and {} would be written under one name, {}; fit one of them by itself",
                  visible(known->second), visible(path), visible(known->first)));
  }
}

bool names_folder(const std::string& path) {
  if (path.empty() || path == "-") return false;
  std::error_code error;
  return !path_of(path).has_filename() || fs::is_directory(path_of(path), error);
}

std::string path_in_folder(const std::string& folder, const std::string& input, FileFormat format) {
  return utf8(path_of(folder) / path_of(formatted("{}.{}", stem_of(input), name_of(format))));
}

std::string output_beside(const std::string& input) {
  const std::string name = stem_of(input);
  return visible(name) +
         (path_of(input).lexically_normal() == path_of(name + ".glb") ? "_surface.glb" : ".glb");
}

std::string job_name_of(const std::string& input) { return visible(stem_of(input)); }

namespace {

constexpr std::array<std::pair<std::string_view, LogLevel>, 4> kLevels{
    {{"error", LogLevel::Error},
     {"warning", LogLevel::Warning},
     {"info", LogLevel::Info},
     {"debug", LogLevel::Debug}}};
constexpr std::array<std::pair<std::string_view, ColorMode>, 3> kColors{
    {{"auto", ColorMode::Auto}, {"always", ColorMode::Always}, {"never", ColorMode::Never}}};
constexpr std::array<std::pair<std::string_view, ProgressMode>, 5> kProgress{
    {{"auto", ProgressMode::Auto},
     {"bar", ProgressMode::Bar},
     {"plain", ProgressMode::Plain},
     {"json", ProgressMode::JsonLines},
     {"none", ProgressMode::None}}};

template <class Words>
auto value_of(const Words& words, std::string_view name, std::string_view flag) {
  std::vector<std::string_view> texts;
  std::string allowed;
  for (const auto& [known, value] : words) {
    if (known == name) return value;
    texts.push_back(known);
    allowed += (allowed.empty() ? "" : ", ") + std::string(known);
  }
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: \"{}\" is not one of {}{}", flag, visible(name), allowed,
                        did_you_mean(name, texts)));
}

// The value of the flag as it stands among arguments that nothing has parsed yet.
std::string_view early_value(const std::vector<std::string>& arguments, const std::string& flag) {
  std::string_view value;
  for (std::size_t i = 1; i < arguments.size() && arguments[i] != "--"; ++i) {
    if (arguments[i] == flag && i + 1 < arguments.size()) value = arguments[i + 1];
    if (arguments[i].starts_with(flag + "="))
      value = std::string_view(arguments[i]).substr(flag.size() + 1);
  }
  return value;
}

}  // namespace

void MessageFlags::add_to(CLI::App& command, bool with_progress) {
  const auto group = "Messages (on stderr)";
  command.add_flag("-q,--quiet", quiet, "errors only")->group(group);
  command
      .add_flag("-v,--verbose", verbose,
                "more: how it was computed, times, bounds, the error of every iteration, memory")
      ->group(group);
  command.add_option("--log-level", log_level, "least severity to show [info]")
      ->type_name("error|warning|info|debug")
      ->group(group);
  command.add_option("--color", color, "auto: on a terminal, unless NO_COLOR is set [auto]")
      ->type_name("auto|always|never")
      ->group(group);
  if (!with_progress) return;
  command
      .add_option("--progress", progress,
                  "auto: a bar on a terminal, else plain lines; json: every line on stderr is a "
                  "JSON object [auto]")
      ->type_name("auto|bar|plain|json|none")
      ->group(group);
}

LogLevel MessageFlags::level() const {
  if (quiet && verbose) {
    throw Error(ErrorCode::InvalidArgument, "--quiet and --verbose contradict each other");
  }
  if (quiet) return LogLevel::Error;
  if (verbose) return LogLevel::Debug;
  return value_of(kLevels, log_level, "--log-level");
}

ColorMode MessageFlags::color_mode() const { return value_of(kColors, color, "--color"); }

ProgressMode MessageFlags::progress_mode() const {
  return value_of(kProgress, progress, "--progress");
}

MessageForm MessageFlags::form() const {
  return progress_mode() == ProgressMode::JsonLines ? MessageForm::JsonLines : MessageForm::Text;
}

MessageStyle early_style(const std::vector<std::string>& arguments) {
  MessageStyle style;
  const std::string_view color = early_value(arguments, "--color");
  for (const auto& [name, mode] : kColors)
    if (name == color) style.color = mode;
  if (early_value(arguments, "--progress") == "json") style.form = MessageForm::JsonLines;
  return style;
}

void add_option_flag(CLI::App& command, OptionTexts& texts, const OptionInfo& option,
                     const char* group) {
  const std::string_view name = option.name;
  if (option.kind == OptionKind::Switch) {
    command
        .add_flag_callback(
            flag_of(option), [&texts, name] { texts[name] = "true"; }, help_of(option))
        ->group(group);
    return;
  }
  if (!option.joiner.empty()) {
    command
        .add_option_function<std::vector<std::string>>(
            flag_of(option),
            [&texts, name, joiner = option.joiner](const std::vector<std::string>& all) {
              std::string& text = texts[name];
              for (const std::string& one : all)
                text += (text.empty() ? "" : std::string(joiner)) + one;
            },
            help_of(option))
        ->expected(1)
        ->take_all()
        ->type_name(choices_of(option))
        ->group(group);
    return;
  }
  command
      .add_option_function<std::string>(
          flag_of(option), [&texts, name](const std::string& text) { texts[name] = text; },
          help_of(option))
      ->type_name(choices_of(option))
      ->group(group);
}

void add_page_flags(CLI::App& command, const PageFlags& flags, const char* help) {
  command.add_option("--page", flags.path, help)->type_name("FILE")->group("Page");
  command
      .add_option("--page-limit", flags.limit,
                  "largest page; a coarser level is shown where the surface needs more [8M]")
      ->type_name("SIZE")
      ->group("Page");
  command
      .add_flag("--page-no-times", flags.no_times,
                "leave times and memory out: the same run gives the same bytes")
      ->group("Page");
}

std::uint64_t parse_page_limit(std::string_view value, std::string_view where) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32;  // browsers hold a page as text
  return parse_size(value, where, kMost, "8M or 500K");
}

PageOptions page_options(const std::string& limit, bool no_times) {
  PageOptions options;
  options.times = !no_times;
  if (!limit.empty()) options.limit_bytes = parse_page_limit(limit, "--page-limit");
  return options;
}

namespace {

// What jobs take beside their large arrays, and the mesher of 100,000 points.
constexpr std::uint64_t kLeast = std::uint64_t{256} << 20, kMost = std::uint64_t{1} << 50;

// Of folders that will be made for the output, the one that is there.
std::filesystem::path folder_beside(const std::string& output) {
  std::filesystem::path folder =
      output == "-" ? std::filesystem::path() : path_of(output).parent_path();
  std::error_code ignored;
  while (!folder.empty() && !std::filesystem::exists(folder, ignored))
    folder = folder.parent_path();
  return folder.empty() ? std::filesystem::path(".") : folder;
}

}  // namespace

void MemoryFlags::add_to(CLI::App& command) {
  // A thread keeps the budget.
  if (!kHasThreads) return;
  const auto group = "Memory";
  command
      .add_option("--memory", budget,
                  "most memory to use, the mesher's included; the rest goes to a temporary file "
                  "[no bound]")
      ->type_name("SIZE")
      ->group(group);
  command.add_option("--temporary", folder, "folder of that file [beside the output]")
      ->type_name("FOLDER")
      ->group(group);
}

void MemoryFlags::apply(const std::string& output) const {
  if (budget.empty()) {
    if (!folder.empty())
      refuse("--temporary", "is the folder of --memory SIZE, which is not given");
    return;
  }
  const std::uint64_t bytes = parse_size(budget, "--memory", kMost, "6G or 800M");
  if (bytes < kLeast)
    refuse("--memory", "{} are too little; the least that works is {}M", byte_size(bytes),
           kLeast >> 20);
  hold_arrays_within(bytes, folder.empty() ? folder_beside(output) : path_of(folder));
}

}  // namespace planish::command
