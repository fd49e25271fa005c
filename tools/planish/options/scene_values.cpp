#include "options/scene_values.h"

#include <cstdint>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/text.h"

namespace planish::command {

void require_object(const Json& json, const std::string& where) {
  if (!json.is_object()) refuse(where, std::string("an object is wanted, not ") + json.type_name());
}

const std::string& text_of(const Json& json, const std::string& where) {
  if (!json.is_string()) refuse(where, std::string("a text is wanted, not ") + json.type_name());
  return json.get_ref<const std::string&>();
}

std::int64_t integer_of(const Json& json, const std::string& where) {
  const bool too_large = json.is_number_unsigned() && json.get<std::uint64_t>() > INT32_MAX;
  if (!json.is_number_integer() || too_large) {
    refuse(where, "a whole number is wanted, not " + json.dump().substr(0, 40));
  }
  return json.get<std::int64_t>();
}

std::string key_path(const std::string& where, std::string_view key) {
  // "scene.json" is followed by ": ", everything deeper by '.'.
  const bool top = where.find(": ") == std::string::npos;
  return where + (top ? ": " : ".") + visible(key);
}

std::string entry_path(const std::string& where, std::size_t index) {
  return formatted("{}[{}]", where, index);
}

void for_entries(const Json& json, const std::string& where,
                 const std::function<void(const Json&, const std::string&)>& visit) {
  if (!json.is_array()) refuse(where, std::string("a list is wanted, not ") + json.type_name());
  for (std::size_t i = 0; i < json.size(); ++i) visit(json[i], entry_path(where, i));
}

double number_of(const Json& json, const std::string& where) {
  if (!json.is_number()) refuse(where, std::string("a number is wanted, not ") + json.type_name());
  return json.get<double>();
}

double fraction_of(const Json& json, const std::string& where) {
  const double number = number_of(json, where);
  if (!(number >= 0 && number <= 1))
    refuse(where, json.dump().substr(0, 40) + " is no fraction from 0 to 1");
  return number;
}

std::int64_t count_of(const Json& json, const std::string& where, std::int64_t least,
                      std::int64_t most) {
  const std::int64_t number = integer_of(json, where);
  if (number < least || number > most)
    refuse(where, "{} is not from {} to {}", number, least, most);
  return number;
}

}  // namespace planish::command
