#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/json_fwd.h"

namespace planish {

/// A value of a JSON document that knows its place, for messages like
/// `a.gltf: accessors[3].count: -1 is no integer from 1`. Every member throws
/// Error{UnreadableInput} when the value is not what is asked for. The document must live longer.
class JsonPlace {
 public:
  JsonPlace(const nlohmann::json& value, std::string_view file, std::string path)
      : value_(&value), file_(file), path_(std::move(path)) {}

  [[nodiscard]] JsonPlace operator[](std::string_view key) const;
  [[nodiscard]] JsonPlace operator[](std::int64_t index) const;
  /// Empty when the object has no such key.
  [[nodiscard]] std::optional<JsonPlace> find(std::string_view key) const;

  [[nodiscard]] std::int64_t array_size() const;
  /// At least `least`, at most 2^53, which JSON numbers carry exactly.
  [[nodiscard]] std::int64_t integer(std::int64_t least = 0) const;
  [[nodiscard]] double number() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] const std::string& text() const;
  [[nodiscard]] bool is_text() const;
  [[nodiscard]] bool is_object() const;

  /// The keys of an object, in order.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] const nlohmann::json& value() const { return *value_; }

  /// Members with a value to use where they are missing.
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t otherwise) const;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// As messages begin: `FILE: PATH`.
  [[nodiscard]] std::string named() const;
  [[noreturn]] void fail(const std::string& what) const;
  /// With formatted() text.
  template <class... Values>
  requires(sizeof...(Values) > 0)
      [[noreturn]] void fail(FormatText<sizeof...(Values)> format, const Values&... values) const {
    fail(formatted(format, values...));
  }

 private:
  [[nodiscard]] std::string clipped() const;

  const nlohmann::json* value_;
  std::string_view file_;
  std::string path_;
};

/// Parses JSON text that is nested no deeper than 64 levels.
/// Throws Error{UnreadableInput} with line and column.
[[nodiscard]] nlohmann::json parse_json(std::string_view text, std::string_view file);

}  // namespace planish
