#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>

namespace planish {

/// A text or a whole number that formatted() may hold. Characters, truth values and numbers with a
/// fraction are none: whoever has one says how it is to be read.
class Formattable {
 public:
  template <class Value>
  requires std::convertible_to<const Value&, std::string_view> Formattable(const Value& text)
      : text_(text) {}
  template <std::integral Value>
  requires(!std::same_as<Value, char> && !std::same_as<Value, bool>) Formattable(Value number)
      : magnitude_(number < 0 ? 0 - static_cast<std::uint64_t>(number)
                              : static_cast<std::uint64_t>(number)),
        is_number_(true),
        is_negative_(number < 0) {}

  void append_to(std::string& text) const;

 private:
  std::string_view text_;
  std::uint64_t magnitude_ = 0;
  bool is_number_ = false, is_negative_ = false;
};

/// A literal with a {} for each of so many values; anything else does not compile.
template <std::size_t kValues>
struct FormatText {
  consteval FormatText(const char* format) : text(format) {
    std::size_t places = 0;
    for (std::size_t at = 0; (at = text.find("{}", at)) != text.npos; at += 2) ++places;
    if (places != kValues) throw "as many {} as values are wanted";
  }
  std::string_view text;
};

[[nodiscard]] std::string formatted_list(std::string_view format,
                                         std::initializer_list<Formattable> values);

/// formatted("face {} of {}", 3, name): the text with each {} replaced by the next value.
template <class... Values>
[[nodiscard]] std::string formatted(FormatText<sizeof...(Values)> format, const Values&... values) {
  return formatted_list(format.text, {Formattable(values)...});
}

}  // namespace planish
