#include "planish/core/formatted.h"

#include <array>
#include <charconv>

namespace planish {

void Formattable::append_to(std::string& text) const {
  if (!is_number_) {
    text += text_;
    return;
  }
  if (is_negative_) text += '-';
  std::array<char, 20> digits;
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), magnitude_).ptr);
}

std::string formatted_list(std::string_view format, std::initializer_list<Formattable> values) {
  std::string text;
  std::size_t from = 0;
  for (const Formattable& value : values) {
    const std::size_t place = format.find("{}", from);
    text += format.substr(from, place - from);
    value.append_to(text);
    from = place + 2;
  }
  return text += format.substr(from);
}

}  // namespace planish
