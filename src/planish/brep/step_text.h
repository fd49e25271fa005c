#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>

namespace planish {

/// As std::to_chars() with a number of digits has it. Its tables are 33 kB of packed WebAssembly,
/// where printf() writes the same: no locale there has another point.
inline char* rounded_text(char* first, char* last, double value, std::chars_format format,
                          int digits) {
#ifdef __EMSCRIPTEN__
  const char* const form = format == std::chars_format::fixed ? "%.*f" : "%.*g";
  return first + std::snprintf(first, static_cast<std::size_t>(last - first), form, digits, value);
#else
  return std::to_chars(first, last, value, format, digits).ptr;
#endif
}

/// Text of Part 21's entities: #12=NAME(...);
class StepText {
 public:
  /// `decimals` of points in space, see step_decimals().
  explicit StepText(std::int64_t first_id, int decimals = 15)
      : id_(first_id), decimals_(decimals) {}

  /// Begins an entity and returns its number.
  std::int64_t begin(std::string_view keyword) {
    text_ += '#';
    integer(id_);
    text_ += '=';
    text_ += keyword;
    return id_++;
  }
  void end() { text_ += ";\n"; }
  /// A whole entity; its text may name others by put-in numbers.
  template <class... Parts>
  std::int64_t entity(const Parts&... parts) {
    const std::int64_t id = begin("");
    (put(parts), ...);
    end();
    return id;
  }
  std::int64_t point(const glm::dvec3& p) {
    return entity("CARTESIAN_POINT('',(", Coordinate{p.x}, ",", Coordinate{p.y}, ",",
                  Coordinate{p.z}, "))");
  }
  std::int64_t point(const glm::dvec2& p) {
    return entity("CARTESIAN_POINT('',(", p.x, ",", p.y, "))");
  }

  struct Reference {
    std::int64_t id;
  };
  void put(std::string_view text) { text_ += text; }
  void put(char letter) { text_ += letter; }
  void put(Reference reference) {
    text_ += '#';
    integer(reference.id);
  }
  /// 15 digits, with the point that Part 21 asks for.
  void put(double value) {
    char buffer[40];
    const char* const stop =
        rounded_text(buffer, buffer + sizeof buffer, value, std::chars_format::general, 15);
    put_real({buffer, static_cast<std::size_t>(stop - buffer)});
  }
  struct Coordinate {
    double value;
  };
  /// So many digits behind the point, or as many as the double has where these are fewer.
  void put(Coordinate coordinate) {
    char exact[40], rounded[400];
    const char* const end = std::to_chars(exact, exact + sizeof exact, coordinate.value).ptr;
    char* stop = rounded_text(rounded, rounded + sizeof rounded, coordinate.value,
                              std::chars_format::fixed, decimals_);
    while (decimals_ > 0 && stop[-1] == '0') --stop;
    const bool is_exact = end - exact <= stop - rounded;
    const std::string_view text(is_exact ? exact : rounded,
                                static_cast<std::size_t>(is_exact ? end - exact : stop - rounded));
    put_real(text == "-0." ? "0." : text);
  }
  void integer(std::int64_t value) {
    char buffer[24];
    text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  }
  /// In brackets, `count` of them from `first` on.
  void references(std::int64_t first, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      text_ += i == 0 ? '(' : ',';
      put(Reference{first + i});
    }
    text_ += ')';
  }

  [[nodiscard]] std::int64_t next_id() const { return id_; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void put_real(std::string_view text) {
    const std::size_t exponent = text.find('e');
    const std::string_view mantissa = text.substr(0, exponent);
    text_ += mantissa;
    if (mantissa.find('.') == std::string_view::npos) text_ += '.';
    if (exponent == std::string_view::npos) return;
    text_ += 'E';
    text_ += text.substr(exponent + 1);
  }

  std::int64_t id_;
  int decimals_;
  std::string text_;
};

/// Digits behind the point that coordinates need: rounding moves none by more than 1.6e-13 of the
/// diagonal, which turns no normal by 1e-5 degrees on the smallest squares.
[[nodiscard]] int step_decimals(double diagonal);

/// A string as Part 21 has it, in its quotes: ASCII as it is, all else in four bytes a character.
[[nodiscard]] std::string step_string(std::string_view utf8);

}  // namespace planish
