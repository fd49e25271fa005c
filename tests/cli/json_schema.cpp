#include "cli/json_schema.h"

#include <algorithm>
#include <regex>
#include <set>
#include <stdexcept>

namespace planish::test {
namespace {

using nlohmann::json;

const std::set<std::string> kKnownKeywords{
    "$schema",  "$defs",   "title",   "description", "$ref",
    "type",     "const",   "enum",    "required",    "properties",
    "items",    "minimum", "maximum", "minItems",    "additionalProperties",
    "maxItems", "pattern", "anyOf"};

class Validator {
 public:
  explicit Validator(const json& document) : document_(document) {}

  void check(const json& value, const json& schema, const std::string& place) {
    for (const auto& [keyword, ignored] : schema.items()) {
      if (!kKnownKeywords.contains(keyword)) throw std::invalid_argument(keyword);
    }
    if (schema.contains("$ref")) {
      const std::string pointer = schema["$ref"].get<std::string>().substr(1);
      check(value, document_.at(json::json_pointer(pointer)), place);
    }
    check_value(value, schema, place);
    if (value.is_number()) check_number(value.get<double>(), schema, place);
    if (value.is_object()) check_object(value, schema, place);
    if (value.is_array()) check_array(value, schema, place);
    if (schema.contains("anyOf")) check_any(value, schema["anyOf"], place);
  }

  std::vector<std::string> problems;

 private:
  void fail(const std::string& place, const std::string& what) {
    problems.push_back(place + ": " + what);
  }

  static bool is_of(const json& value, const std::string& type) {
    if (type == "integer") return value.is_number_integer();
    if (type == "null") return value.is_null();
    return value.is_number() ? type == "number" : type == value.type_name();
  }

  void check_value(const json& value, const json& schema, const std::string& place) {
    if (schema.contains("type")) {
      const json& type = schema["type"];
      const json types = type.is_array() ? type : json::array({type});
      if (std::none_of(types.begin(), types.end(),
                       [&](const json& t) { return is_of(value, t.get<std::string>()); })) {
        fail(place, value.dump() + " is no " + type.dump());
      }
    }
    if (schema.contains("const") && value != schema["const"]) {
      fail(place, value.dump() + " is not " + schema["const"].dump());
    }
    if (schema.contains("enum")) {
      const json& values = schema["enum"];
      if (std::find(values.begin(), values.end(), value) == values.end()) {
        fail(place, value.dump() + " is none of " + values.dump());
      }
    }
    if (schema.contains("pattern") && value.is_string() &&
        !std::regex_search(value.get<std::string>(),
                           std::regex(schema["pattern"].get<std::string>()))) {
      fail(place, value.dump() + " does not match " + schema["pattern"].dump());
    }
  }

  void check_number(double value, const json& schema, const std::string& place) {
    if (schema.contains("minimum") && value < schema["minimum"].get<double>()) {
      fail(place, std::to_string(value) + " is too small");
    }
    if (schema.contains("maximum") && value > schema["maximum"].get<double>()) {
      fail(place, std::to_string(value) + " is too large");
    }
  }

  void check_object(const json& value, const json& schema, const std::string& place) {
    for (const json& key : schema.value("required", json::array())) {
      if (!value.contains(key.get<std::string>())) fail(place, "has no " + key.get<std::string>());
    }
    const json properties = schema.value("properties", json::object());
    for (const auto& [key, member] : value.items()) {
      const std::string below = place + "/" + key;
      if (properties.contains(key)) {
        check(member, properties[key], below);
      } else if (schema.contains("additionalProperties")) {
        const json& others = schema["additionalProperties"];
        if (others == false) {
          fail(below, "is not in the schema");
        } else {
          check(member, others, below);
        }
      }
    }
  }

  void check_array(const json& value, const json& schema, const std::string& place) {
    if (value.size() < schema.value("minItems", std::size_t{0})) fail(place, "is too short");
    if (value.size() > schema.value("maxItems", value.size())) fail(place, "is too long");
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i) {
      check(value[i], schema["items"], place + "/" + std::to_string(i));
    }
  }

  // Where none fits, what is wrong with the one that fits best.
  void check_any(const json& value, const json& schemas, const std::string& place) {
    std::vector<std::string> fewest;
    for (const json& schema : schemas) {
      Validator validator(document_);
      validator.check(value, schema, place);
      if (validator.problems.empty()) return;
      if (fewest.empty() || validator.problems.size() <= fewest.size()) {
        fewest = std::move(validator.problems);
      }
    }
    problems.insert(problems.end(), fewest.begin(), fewest.end());
  }

  const json& document_;
};

}  // namespace

std::vector<std::string> schema_problems(const json& value, const json& schema,
                                         const json& document) {
  Validator validator(document);
  validator.check(value, schema, "");
  return validator.problems;
}

}  // namespace planish::test
