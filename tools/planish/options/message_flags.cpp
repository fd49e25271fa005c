#include <CLI/CLI.hpp>
#include <array>
#include <utility>
#include <vector>

#include "commands.h"
#include "planish/core/error.h"
#include "planish/core/nearest.h"
#include "planish/core/visible_text.h"

namespace planish::command {
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
  command.add_option("--log-level", log_level, "least weight that is shown [info]")
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

}  // namespace planish::command
