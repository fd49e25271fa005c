#include "output/cage_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

std::string shortest(double number) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
  return {buffer.data(), end.ptr};
}

double parse_tolerance(std::string_view value, const std::string& where) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = error == std::errc() && end == value.data() + value.size();
  if (!whole || !std::isfinite(number) || number <= 0) {
    throw Error(ErrorCode::InvalidArgument, where + ": \"" + visible(value) + "\" is no tolerance");
  }
  return number;
}

double parse_weld(std::string_view value, const std::string& where) {
  Settings checked;
  set_weld(checked, value, where);
  return *checked.weld;
}

// "3 17 20"
std::vector<std::int32_t> parse_vertices(std::string_view value, const std::string& where) {
  std::vector<std::int32_t> vertices;
  while (!value.empty()) {
    const std::size_t end = std::min(value.find(' '), value.size());
    const std::int64_t vertex = parse_whole(value.substr(0, end), where);
    if (vertex < 0 || vertex > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::InvalidArgument, where + ": " + std::to_string(vertex) +
                                                  " is no vertex; 0 to 2147483647 is wanted");
    vertices.push_back(static_cast<std::int32_t>(vertex));
    value.remove_prefix(std::min(end + 1, value.size()));
  }
  return vertices;
}

void apply(CageHeader& header, std::string_view key, std::string_view value,
           const std::string& where) {
  if (key == "interpolation") header.interpolation = parse_method(value, where);
  if (key == "weights") header.weights = parse_weights(value, where);
  if (key == "boundary") header.boundary = parse_boundary(value, where);
  if (key == "creases") header.creases = parse_creases(value, where);
  if (key == "repair") header.repair = parse_repair(value, where);
  if (key == "tolerance") header.tolerance = parse_tolerance(value, where);
  if (key == "weld") header.weld = parse_weld(value, where);
  if (key == "smoothed_vertices") header.smoothed_vertices = parse_vertices(value, where);
  if (key == "source") header.source = std::string(value);
  if (key == "scheme") header.scheme = parse_scheme(value, where);
}

}  // namespace

std::vector<std::string> cage_header_lines(const Settings& settings, InterpolationMethod method,
                                           const std::string& source,
                                           std::span<const std::int32_t> smoothed_vertices) {
  const auto line = [](std::string_view key, std::string_view value) {
    return "planish " + std::string(key) + "=" + std::string(value);
  };
  const std::string file_name = std::filesystem::path(source).filename().string();
  std::vector<std::string> lines{line("version", PLANISH_VERSION),
                                 line("scheme", name_of(settings.scheme)),
                                 line("interpolation", name_of(method)),
                                 line("weights", name_of(settings.weights)),
                                 line("boundary", name_of(settings.boundary)),
                                 line("creases", name_of(settings.creases)),
                                 line("repair", name_of(settings.repair)),
                                 line("tolerance", shortest(settings.tolerance)),
                                 line("source", plain_utf8(file_name))};
  if (settings.weld) lines.push_back(line("weld", shortest(*settings.weld)));
  if (smoothed_vertices.empty()) return lines;
  std::string numbers;
  for (const std::int32_t vertex : smoothed_vertices)
    numbers += (numbers.empty() ? "" : " ") + std::to_string(vertex);
  lines.push_back(line("smoothed_vertices", numbers));
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
