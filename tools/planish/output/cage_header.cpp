#include "output/cage_header.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

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

void apply(CageHeader& header, std::string_view key, std::string_view value,
           const std::string& where) {
  if (key == "interpolation") header.interpolation = parse_method(value, where);
  if (key == "weights") header.weights = parse_weights(value, where);
  if (key == "boundary") header.boundary = parse_boundary(value, where);
  if (key == "creases") header.creases = parse_creases(value, where);
  if (key == "repair") header.repair = parse_repair(value, where);
  if (key == "tolerance") header.tolerance = parse_tolerance(value, where);
  if (key == "source") header.source = std::string(value);
  if (key == "scheme") header.scheme = parse_scheme(value, where);
}

}  // namespace

std::vector<std::string> cage_header_lines(const Settings& settings, InterpolationMethod method,
                                           const std::string& source) {
  const auto line = [](std::string_view key, std::string_view value) {
    return "planish " + std::string(key) + "=" + std::string(value);
  };
  const std::string file_name = std::filesystem::path(source).filename().string();
  return {line("version", PLANISH_VERSION),
          line("scheme", name_of(settings.scheme)),
          line("interpolation", name_of(method)),
          line("weights", name_of(settings.weights)),
          line("boundary", name_of(settings.boundary)),
          line("creases", name_of(settings.creases)),
          line("repair", name_of(settings.repair)),
          line("tolerance", shortest(settings.tolerance)),
          line("source", plain_utf8(file_name))};
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
