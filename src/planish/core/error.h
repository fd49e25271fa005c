#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stdexcept>
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

/// A piece of a file as it may stand in a message: in back quotes, clipped, control bytes as `?`.
[[nodiscard]] std::string quote(std::string_view text);

/// A finite decimal number that fills `token`, whatever the locale. False: `value` is unchanged.
[[nodiscard]] bool parse_number(std::string_view token, double& value);
/// An integer that fills `token`.
[[nodiscard]] bool parse_integer(std::string_view token, std::int64_t& value);

/// A word that programs write for what is no number: `nan`, `-nan(ind)`, `1.#QNAN`.
[[nodiscard]] bool is_nan_word(std::string_view word);
/// Such a word, or one for an infinite number: `inf`, `-Infinity`, `1.#INF`.
[[nodiscard]] bool is_non_finite_word(std::string_view word);
/// What is to be said of a word that parse_number() does not take.
[[nodiscard]] std::string no_finite_number(std::string_view word);

/// The shortest text that is read back as the same number.
[[nodiscard]] std::string shortest(double value);

/// For people: three significant digits, as short as they go; large numbers as whole ones up to a
/// million: 4.12e-07, 0.00123, 12346.
[[nodiscard]] std::string short_number(double number);

/// For people, the sign included: 0.125 -> "12.5 %". None has an exponent: below 0.001 % and just
/// below all stand as such: "under 0.001 %", "over 99.9 %".
[[nodiscard]] std::string percent(double share);

/// `number` with so many decimals.
[[nodiscard]] std::string fixed(double number, int decimals);

/// 2202009 -> "2.1 MiB"; below 1 KiB in bytes.
[[nodiscard]] std::string byte_size(std::uint64_t bytes);

/// What kind of thing went wrong. The command maps each to an exit code.
enum class ErrorCode {
  InvalidArgument,   ///< an option or argument is out of range or contradicts another
  UnreadableInput,   ///< a file is missing, malformed or shorter than it says
  UnusableMesh,      ///< the mesh was read but no surface can be made of it
  NoDevice,          ///< no device fits the request, or a program that does is missing
  DeviceLost,        ///< the device stopped answering
  OutOfMemory,       ///< host or device memory does not suffice; thrown before it is taken
  UnwritableOutput,  ///< a file could not be written; the old one is untouched
  Cancelled,         ///< Callbacks::cancelled returned true
};

/// Wrong input, a missing device or an unwritable file. The message says what, where, the value
/// and the remedy: `bunny.obj:812: face names vertex 4031 of 4030`. formatted() writes such.
class Error : public std::runtime_error {
 public:
  static constexpr std::int64_t kNoElement = -1;

  Error(ErrorCode code, const std::string& message, std::int64_t element = kNoElement);

  [[nodiscard]] ErrorCode code() const noexcept { return code_; }
  /// Index of the face, vertex or byte that the message speaks of; kNoElement if none.
  [[nodiscard]] std::int64_t element() const noexcept { return element_; }

 private:
  ErrorCode code_;
  std::int64_t element_;
};

/// What a caught exception says.
struct Failure {
  std::optional<ErrorCode> code;  ///< none: a fault of our own
  const char* message = "";       ///< the exception's, or one that lives as long as the program
  std::int64_t element = Error::kNoElement;
};

/// Of the exception that is being handled: an Error's own, OutOfMemory and `out_of_memory` where
/// memory runs out (std::bad_alloc) or an array has more than can be counted (std::length_error).
/// To be called in a catch block; the message lives as long as that is not left.
[[nodiscard]] Failure current_failure(const char* out_of_memory) noexcept;

}  // namespace planish
