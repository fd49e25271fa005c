#include "planish/pipeline/crease_text.h"

#include <algorithm>
#include <array>
#include <string>

#include "planish/core/nearest.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"

namespace planish {
namespace {

// Digits, with a point or without, of 0 to 180; e-5 may follow, as it does in headers of cages.
// What kCreasesPattern takes: a regular expression cannot tell the size of other numbers.
bool parse_angle(std::string_view text, double& degrees) {
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t exponent = std::min(text.find("e-"), text.size());
  const std::string_view mantissa = text.substr(0, exponent);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const auto is_digits = [&](std::string_view part) {
    return !part.empty() && part.find_first_not_of(kDigits) == std::string_view::npos;
  };
  return is_digits(mantissa.substr(0, point)) &&
         (point == mantissa.size() || is_digits(mantissa.substr(point + 1))) &&
         (exponent == text.size() || is_digits(text.substr(exponent + 2))) &&
         parse_number(mantissa, degrees) && degrees <= 180 && parse_number(text, degrees);
}

}  // namespace

CreaseChoice parse_creases(std::string_view text, std::string_view where) {
  constexpr std::array<std::string_view, 5> kKnown{"choose", "use", "ignore", "normals", "auto"};
  const std::string shown = "\"" + visible(text) + "\"";
  const std::string no_choice = shown + " is not one of choose, use, ignore, normals, auto:DEGREES";
  double degrees = 0;
  if (text == "choose") return {.chooses = true};
  if (text == "use") return {};
  if (text == "ignore") return {.use_tags = false};
  if (text == "normals") return {.split_normals = true};
  if (text == "auto") return {.finds_features = true};
  if (parse_number(text, degrees))
    refuse(where, no_choice + "; did you mean auto:" + visible(text) + "?");
  if (!text.starts_with("auto:")) refuse(where, no_choice + did_you_mean(text, kKnown));
  const std::string_view angle = text.substr(5);
  if (!parse_angle(angle, degrees))
    refuse(where, "\"" + visible(angle) + "\" is no angle of 0 to 180 degrees such as 22.5");
  return {.dihedral_degrees = degrees};
}

}  // namespace planish
