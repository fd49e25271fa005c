#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json.h"

namespace planish {

/// How a sampler of textures wraps.
inline constexpr int kClampToEdge = 33071;

/// Values of a glTF document that may be missing, or of another kind.
using JsonNumbers = std::vector<double>;

/// What lies at `key`; null where nothing does.
[[nodiscard]] inline const nlohmann::json& json_at(const nlohmann::json& in, const char* key) {
  static const nlohmann::json kNothing;
  const auto found = in.find(key);
  return in.is_object() && found != in.end() ? *found : kNothing;
}

/// The same of entry `index` of a list.
[[nodiscard]] inline const nlohmann::json& json_at(const nlohmann::json& in, const char* list,
                                                   const nlohmann::json& index) {
  static const nlohmann::json kNothing;
  const nlohmann::json& all = json_at(in, list);
  if (!index.is_number_integer() || index < 0 || !all.is_array() || index >= all.size())
    return kNothing;
  return all[index.get<std::size_t>()];
}

[[nodiscard]] inline double number_at(const nlohmann::json& value, double otherwise) {
  return value.is_number() && std::isfinite(value.get<double>()) ? value.get<double>() : otherwise;
}

/// As many as `otherwise` has.
[[nodiscard]] inline JsonNumbers values_of(const nlohmann::json& values, JsonNumbers otherwise) {
  if (!values.is_array() || values.size() < otherwise.size()) return otherwise;
  for (std::size_t i = 0; i < otherwise.size(); ++i)
    otherwise[i] = number_at(values[i], otherwise[i]);
  return otherwise;
}

/// What `work` returns, which takes values of a document without a JsonPlace. Throws
/// Error{UnreadableInput}, naming the file, where one is not of the kind that the format has there.
template <class Work>
auto guard_json(std::string_view file, const Work& work) {
  try {
    return work();
  } catch (const nlohmann::json::exception& error) {
    // The library's messages begin with an identifier in brackets.
    const std::string message = error.what();
    const std::size_t begin = message.find("] ");
    throw Error(ErrorCode::UnreadableInput,
                std::string(file) + ": a value is not of the kind that glTF has there: " +
                    (begin == std::string::npos ? message : message.substr(begin + 2)));
  }
}

}  // namespace planish
