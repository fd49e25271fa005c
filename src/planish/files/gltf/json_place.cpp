#include "planish/files/gltf/json_place.h"

#include <cmath>

#include "planish/core/error.h"
#include "planish/core/json.h"

namespace planish {
namespace {

// glTF's own structures are 8 deep; extras may be deeper, but recursive readers of the same file
// would overflow their stack long before anything useful stood there.
constexpr int kMaxDepth = 64;
constexpr std::int64_t kMaxInteger = std::int64_t{1} << 53;

}  // namespace

std::string JsonPlace::named() const {
  return std::string(file_) + (path_.empty() ? "" : ": " + path_);
}

void JsonPlace::fail(const std::string& what) const {
  throw Error(ErrorCode::UnreadableInput, named() + ": " + what);
}

std::string JsonPlace::clipped() const {
  constexpr std::size_t kLongest = 40;
  if (value_->is_structured()) return value_->is_array() ? "an array" : "an object";
  const std::string text = value_->dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return text.size() > kLongest ? text.substr(0, kLongest) + "..." : text;
}

std::optional<JsonPlace> JsonPlace::find(std::string_view key) const {
  if (!value_->is_object()) fail(clipped() + " is no object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return JsonPlace(*found, file_, (path_.empty() ? "" : path_ + ".") + std::string(key));
}

JsonPlace JsonPlace::operator[](std::string_view key) const {
  std::optional<JsonPlace> found = find(key);
  if (!found) fail("has no `" + std::string(key) + "`");
  return *std::move(found);
}

JsonPlace JsonPlace::operator[](std::int64_t index) const {
  if (index >= array_size())
    fail("entry {} is asked for, but there are only {}", index, array_size());
  return {(*value_)[index], file_, formatted("{}[{}]", path_, index)};
}

std::int64_t JsonPlace::array_size() const {
  if (!value_->is_array()) fail(clipped() + " is no array");
  return static_cast<std::int64_t>(value_->size());
}

std::int64_t JsonPlace::integer(std::int64_t least) const {
  // Some writers put 12.0 for 12.
  const double value = value_->is_number() ? value_->get<double>() : std::nan("");
  if (!(value >= static_cast<double>(least) && value <= static_cast<double>(kMaxInteger)) ||
      value != std::floor(value))
    fail("{} is no integer from {}", clipped(), least);
  return static_cast<std::int64_t>(value);
}

double JsonPlace::number() const {
  if (!value_->is_number()) fail(clipped() + " is no number");
  return value_->get<double>();
}

bool JsonPlace::boolean() const {
  if (!value_->is_boolean()) fail(clipped() + " is neither true nor false");
  return value_->get<bool>();
}

bool JsonPlace::is_text() const { return value_->is_string(); }

bool JsonPlace::is_object() const { return value_->is_object(); }

const std::string& JsonPlace::text() const {
  if (!value_->is_string()) fail(clipped() + " is no text");
  return value_->get_ref<const std::string&>();
}

std::vector<std::string> JsonPlace::keys() const {
  if (!value_->is_object()) fail(clipped() + " is no object");
  std::vector<std::string> keys;
  for (const auto& [key, value] : value_->items()) keys.push_back(key);
  return keys;
}

std::int64_t JsonPlace::integer_or(std::string_view key, std::int64_t otherwise) const {
  const auto found = find(key);
  return found ? found->integer() : otherwise;
}

nlohmann::json parse_json(std::string_view text, std::string_view file) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(file) + ": " + what);
  };
  const auto limit_depth = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMaxDepth) fail(formatted("JSON is nested deeper than {} levels", kMaxDepth));
    return true;
  };
  try {
    return nlohmann::json::parse(text, limit_depth);
  } catch (const nlohmann::json::exception& error) {
    // The library's messages begin with an identifier in brackets.
    const std::string message = error.what();
    const std::size_t begin = message.find("] ");
    fail(begin == std::string::npos ? message : message.substr(begin + 2));
  }
  return {};
}

}  // namespace planish
