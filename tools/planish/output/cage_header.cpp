#include "output/cage_header.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

// "3 17 20"
std::vector<std::int32_t> parse_vertices(std::string_view value, const std::string& where) {
  std::vector<std::int32_t> vertices;
  while (!value.empty()) {
    const std::size_t end = std::min(value.find(' '), value.size());
    const std::string_view number = value.substr(0, end);
    std::int64_t vertex = 0;
    if (!parse_integer(number, vertex) || vertex < 0 ||
        vertex > std::numeric_limits<std::int32_t>::max())
      refuse(where, "\"" + visible(number) + "\" is no vertex; 0 to 2147483647 is wanted");
    vertices.push_back(static_cast<std::int32_t>(vertex));
    value.remove_prefix(std::min(end + 1, value.size()));
  }
  return vertices;
}

void apply(CageHeader& header, std::string_view key, std::string_view value,
           const std::string& where) {
  if (key == "smoothed_vertices") header.smoothed_vertices = parse_vertices(value, where);
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
                                           const std::string& source,
                                           std::span<const std::int32_t> smoothed_vertices) {
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
    if (has_default) add("source", plain_utf8(std::filesystem::path(source).filename().string()));
  }
  if (smoothed_vertices.empty()) return lines;
  std::string numbers;
  for (const std::int32_t vertex : smoothed_vertices)
    numbers += (numbers.empty() ? "" : " ") + std::to_string(vertex);
  add("smoothed_vertices", numbers);
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

}  // namespace planish::command
