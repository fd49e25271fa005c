#include "planish/pipeline/part_settings.h"

#include <algorithm>
#include <array>
#include <optional>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/settings.h"

namespace planish {
namespace {

constexpr std::array<std::string_view, 3> kKinds{"mesh", "material", "node"};
constexpr char kNext = ';';
constexpr std::string_view kPartWanted =
    "mesh=NAME:OPTION=VALUE is wanted, or material= or node= for it, such as "
    "mesh=Wheel:creases=use";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = std::min(text.find_first_not_of(' '), text.size());
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

// "creases" of "creases" and "max-iterations" of "max_iterations": as flags are spelled.
std::string spelled_as_flag(std::string_view name) {
  std::string flag(name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

std::vector<std::string_view> options_of_parts() {
  std::vector<std::string_view> names;
  for (const FitOption& option : option_table())
    if (is_of_parts(option)) names.push_back(option.name);
  return names;
}

const FitOption* option_of(std::string_view text) {
  for (const FitOption& option : option_table())
    if (option.name == text || spelled_as_flag(option.name) == text) return &option;
  return nullptr;
}

bool looks_like_setting(std::string_view text) {
  const std::size_t end = text.find('=');
  return end != std::string_view::npos && end > 0 &&
         text.substr(0, end).find_first_not_of("abcdefghijklmnopqrstuvwxyz_-") ==
             std::string_view::npos;
}

// Where the setting begins, behind the last colon that one may stand behind: names and values may
// have colons, too.
std::optional<std::size_t> begin_of_setting(std::string_view text) {
  for (std::size_t at = text.rfind(':'); at != std::string_view::npos && at > 0;
       at = text.rfind(':', at - 1))
    if (looks_like_setting(text.substr(at + 1))) return at + 1;
  return std::nullopt;
}

PartSetting parse_one(std::string_view text, std::string_view where) {
  const std::size_t equals = std::min(text.find('='), text.size());
  const auto kind = std::ranges::find(kKinds, text.substr(0, equals));
  const auto setting = begin_of_setting(text);
  if (kind == kKinds.end() || !setting || *setting < equals + 2)
    refuse(where, in_double_quotes(text) + ": " + std::string(kPartWanted) +
                      did_you_mean(text.substr(0, equals), kKinds));
  PartSetting one{.kind = static_cast<PartKind>(kind - kKinds.begin()),
                  .name = std::string(text.substr(equals + 1, *setting - equals - 2))};
  if (one.name.empty()) refuse(where, in_double_quotes(text) + ": the name is empty");
  const std::string_view rest = text.substr(*setting);
  const std::string_view name = rest.substr(0, rest.find('='));
  const FitOption* const option = option_of(name);
  const std::vector<std::string_view> known = options_of_parts();
  if (option == nullptr || !is_of_parts(*option)) {
    std::string all;
    for (const std::string_view other : known)
      all += (all.empty() ? "" : ", ") + std::string(other);
    refuse(where, in_double_quotes(text) + ": parts have no " + in_double_quotes(name) +
                      " of their own" + did_you_mean(name, known) + "; they may have " + all);
  }
  one.option = option->name;
  one.value = rest.substr(name.size() + 1);
  FitSettings tried;
  read_option(*option, tried, one.value, formatted("{} {}", where, text.substr(0, *setting - 1)));
  if (tried.levels.size() > 1)
    refuse(where, in_double_quotes(text) + ": a part has one level; take one");
  return one;
}

}  // namespace

std::string_view name_of(PartKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::string PartSetting::who() const {
  return formatted("{}={}", planish::name_of(kind), visible(name));
}

// Greedy from star to star, which is enough where nothing else stands for several texts.
bool PartSetting::names(std::string_view part) const {
  std::string_view pattern = name;
  std::size_t star = std::min(pattern.find('*'), pattern.size());
  if (star == pattern.size()) return part == pattern;
  if (!part.starts_with(pattern.substr(0, star))) return false;
  part.remove_prefix(star);
  while (true) {
    pattern.remove_prefix(star + 1);
    star = pattern.find('*');
    if (star == std::string_view::npos) return part.ends_with(pattern);
    const std::size_t at = part.find(pattern.substr(0, star));
    if (at == std::string_view::npos) return false;
    part.remove_prefix(at + star);
  }
}

void PartSetting::apply_to(FitSettings& settings) const {
  read_option(fit_option(option), settings, value, who());
}

bool is_of_parts(const OptionInfo& option) {
  return option.name == "levels" || option.name == "polish" || option.name == "solver" ||
         (option.stage == OptionStage::Shape && option.name != "scheme");
}

std::vector<PartSetting> parse_part_settings(std::string_view text, std::string_view where) {
  std::vector<PartSetting> all;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(kNext, begin), text.size());
    all.push_back(parse_one(trimmed(text.substr(begin, end - begin)), where));
    begin = end + 1;
  }
  return all;
}

std::string part_settings_text(const std::vector<PartSetting>& settings) {
  std::string text;
  for (const PartSetting& one : settings)
    text += formatted("{}{}={}:{}={}", text.empty() ? "" : "; ", name_of(one.kind), one.name,
                      one.option, one.value);
  return text;
}

}  // namespace planish
