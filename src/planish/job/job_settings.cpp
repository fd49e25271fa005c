#include "planish/job/job_settings.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish {

const OptionInfo* find_setting(std::string_view name) {
  if (const FitOption* const option = find_option(option_table(), name)) return option;
  return find_option(point_option_table(), name);
}

bool is_of_inputs(const OptionInfo& option) {
  constexpr std::array<std::string_view, 4> kOfAssets{"asset", "lods", "set", "textures"};
  return option.stage == OptionStage::Points ||
         std::ranges::find(kOfAssets, option.name) != kOfAssets.end();
}

std::string flag_of_setting(std::string_view name) {
  const OptionInfo* const option = find_setting(name);
  return option == nullptr ? visible(name) : flag_of(*option);
}

void apply_settings(std::span<const NamedSetting> given, Settings& settings, SpellOption spell) {
  for (const auto& [name, text] : given)
    if (find_setting(name) == nullptr) refuse(spell(name), "there is no such option");
  const auto spell_row = [&](const OptionInfo& option) { return spell(option.name); };
  read_options<FitSettings>(option_table(), given, spell_row, settings);
  read_options(point_option_table(), given, spell_row, settings.points);
}

Settings settings_of(std::span<const NamedSetting> given, SpellOption spell) {
  Settings settings;
  apply_settings(given, settings, spell);
  check_consistent(settings, spell);
  return settings;
}

Settings settings_of(std::initializer_list<NamedSetting> given) {
  return settings_of(std::span(given.begin(), given.size()));
}

std::string_view name_of(Scheme scheme) { return word_of(kSchemeWords, scheme); }
std::string_view name_of(Weights weights) { return word_of(kWeightsWords, weights); }
std::string_view name_of(InterpolationMethod method) { return word_of(kMethodWords, method); }
std::string_view name_of(Solver solver) { return word_of(kSolverWords, solver); }
std::string_view name_of(BoundaryRule boundary) { return word_of(kBoundaryWords, boundary); }

std::string subdivision_text(Scheme scheme, Weights weights) {
  return scheme == Scheme::DooSabin ? std::string(name_of(weights)) + " weights"
                                    : std::string(name_of(scheme));
}

namespace {

constexpr std::string_view kEdgesKey = "sharp_edges", kCornersKey = "sharp_corners";
// So many a line, which stays short enough to be read.
constexpr std::size_t kMostOfLine = 16;

std::int32_t parse_vertex(std::string_view text, const std::string& where) {
  std::int64_t vertex = 0;
  if (!parse_integer(text, vertex) || vertex < 0 ||
      vertex > std::numeric_limits<std::int32_t>::max())
    refuse(where, in_double_quotes(text) + " is no vertex; 0 to 2147483647 is wanted");
  return static_cast<std::int32_t>(vertex);
}

// Words between spaces.
void for_each_word(std::string_view value, const std::function<void(std::string_view)>& take) {
  while (!value.empty()) {
    const std::size_t end = std::min(value.find(' '), value.size());
    take(value.substr(0, end));
    value.remove_prefix(std::min(end + 1, value.size()));
  }
}

// "3-17 17-20"
void parse_edges(std::string_view value, const std::string& where, FoundCreases& found) {
  for_each_word(value, [&](std::string_view word) {
    const std::size_t middle = std::min(word.find('-'), word.size());
    const std::string_view second = word.substr(std::min(middle + 1, word.size()));
    found.edges.push_back(
        {parse_vertex(word.substr(0, middle), where), parse_vertex(second, where)});
  });
}

// "3 17 20"
void parse_corners(std::string_view value, const std::string& where, FoundCreases& found) {
  for_each_word(value,
                [&](std::string_view word) { found.corners.push_back(parse_vertex(word, where)); });
}

// Several lines where there are many. Without any there is a line all the same, which says so.
template <class T>
void add_found(std::vector<std::string>& lines, std::string_view key, const std::vector<T>& found,
               const auto& text_of) {
  std::size_t i = 0;
  do {
    std::string text;
    for (const std::size_t end = std::min(i + kMostOfLine, found.size()); i < end; ++i)
      text += (text.empty() ? "" : " ") + text_of(found[i]);
    lines.push_back(formatted("planish {}={}", key, text));
  } while (i < found.size());
}

void apply(CageHeader& header, std::string_view key, std::string_view value,
           const std::string& where) {
  if (key == kEdgesKey || key == kCornersKey) {
    if (!header.found) header.found.emplace();
    (key == kEdgesKey ? parse_edges : parse_corners)(value, where, *header.found);
  }
  if (key == "source") header.source = std::string(value);
  const FitOption* option = find_option(option_table(), key);
  if (option == nullptr || !is_of_cages(*option)) return;
  read_option(*option, header.settings, value, where);
  require_known_method(header.settings, where);
}

}  // namespace

bool is_of_cages(const OptionInfo& option) {
  return option.stage == OptionStage::Shape || option.name == "tolerance";
}

void require_known_method(const FitSettings& settings, std::string_view where) {
  if (settings.interpolation == InterpolationChoice::Auto)
    refuse(where, "\"auto\" is not one of progressive, fair");
  if (settings.within.is_measured) refuse(where, "\"auto\" does not say how far");
  if (settings.creases.chooses) refuse(where, "\"choose\" does not say which creases there are");
}

std::vector<std::string> cage_header_lines(FitSettings settings, InterpolationMethod method,
                                           const std::string& source, const FoundCreases& found) {
  settings.interpolation = method == InterpolationMethod::Fair ? InterpolationChoice::Fair
                                                               : InterpolationChoice::Progressive;
  settings.creases.chooses = false;  // what was found stands in the settings
  std::vector<std::string> lines;
  const auto add = [&](std::string_view key, std::string_view value) {
    lines.push_back(formatted("planish {}={}", key, value));
  };
  add("version", PLANISH_VERSION);
  // First what every cage says, then what was asked for besides.
  for (const bool has_default : {true, false}) {
    for (const FitOption& option : option_table()) {
      if (!is_of_cages(option) || option.initial.empty() == has_default) continue;
      const std::string text = option.get(settings);
      if (!text.empty()) add(option.name, text);
    }
    if (has_default) add("source", plain_utf8(utf8(path_of(source).filename())));
  }
  if (!settings.creases.finds_features && !settings.creases.dihedral_degrees) return lines;
  add_found(lines, kEdgesKey, found.edges, [](const std::array<std::int32_t, 2>& edge) {
    return std::to_string(edge[0]) + "-" + std::to_string(edge[1]);
  });
  if (!found.corners.empty())
    add_found(lines, kCornersKey, found.corners,
              [](std::int32_t vertex) { return std::to_string(vertex); });
  return lines;
}

CageHeader parse_cage_header(std::span<const std::string> lines, const std::string& name) {
  CageHeader header;
  for (const std::string& line : lines) {
    std::string_view rest = line;
    while (rest.starts_with('#') || rest.starts_with(' ')) rest.remove_prefix(1);
    if (rest.starts_with("planish ")) rest.remove_prefix(8);
    const std::size_t equals = rest.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view key = rest.substr(0, equals);
    try {
      apply(header, key, rest.substr(equals + 1), name + ": header " + std::string(key));
    } catch (const Error& error) {
      throw Error(ErrorCode::UnreadableInput, error.what());
    }
  }
  return header;
}

}  // namespace planish
