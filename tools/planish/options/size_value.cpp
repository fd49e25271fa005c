#include "options/size_value.h"

#include <charconv>
#include <string>

#include "planish/core/error.h"
#include "planish/job/text.h"

namespace planish::command {

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

}  // namespace planish::command
