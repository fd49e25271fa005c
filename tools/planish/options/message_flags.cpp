#include <CLI/CLI.hpp>
#include <array>
#include <utility>

#include "commands.h"
#include "planish/core/error.h"

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
     {"json", ProgressMode::Json},
     {"none", ProgressMode::None}}};

template <class Words>
std::vector<std::string> names_of(const Words& words) {
  std::vector<std::string> names;
  for (const auto& [name, value] : words) names.emplace_back(name);
  return names;
}

// The flag's own check has let only known names through.
template <class Words>
auto value_of(const Words& words, std::string_view name) {
  for (const auto& [known, value] : words) {
    if (known == name) return value;
  }
  return words.front().second;
}

}  // namespace

void MessageFlags::add_to(CLI::App& command, bool with_progress) {
  const auto group = "Messages (on stderr)";
  command.add_flag("-q,--quiet", quiet, "errors only")->group(group);
  command.add_flag("-v,--verbose", verbose, "more detail")->group(group);
  command.add_option("--log-level", log_level, "least weight that is shown [info]")
      ->type_name("error|warning|info|debug")
      ->check(CLI::IsMember(names_of(kLevels)).description(""))
      ->group(group);
  command.add_option("--color", color, "auto: on a terminal, unless NO_COLOR is set [auto]")
      ->type_name("auto|always|never")
      ->check(CLI::IsMember(names_of(kColors)).description(""))
      ->group(group);
  if (!with_progress) return;
  command.add_option("--progress", progress, "auto: a bar on a terminal, else plain lines [auto]")
      ->type_name("auto|bar|plain|json|none")
      ->check(CLI::IsMember(names_of(kProgress)).description(""))
      ->group(group);
}

LogLevel MessageFlags::level() const {
  if (quiet && verbose) {
    throw Error(ErrorCode::InvalidArgument, "--quiet and --verbose contradict each other");
  }
  if (quiet) return LogLevel::Error;
  if (verbose) return LogLevel::Debug;
  return value_of(kLevels, log_level);
}

ColorMode MessageFlags::color_mode() const { return value_of(kColors, color); }

ProgressMode MessageFlags::progress_mode() const { return value_of(kProgress, progress); }

}  // namespace planish::command
