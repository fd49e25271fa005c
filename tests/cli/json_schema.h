#pragma once

#include <string>
#include <vector>

#include "planish/core/json.h"

namespace planish::test {

/// What of `value` the schema does not allow: "/solve/error: has no max". Empty: it is valid. Knows
/// the part of JSON Schema 2020-12 that our schemas take, and throws std::invalid_argument for any
/// other keyword.
[[nodiscard]] std::vector<std::string> schema_problems(const nlohmann::json& value,
                                                       const nlohmann::json& schema,
                                                       const nlohmann::json& document);
[[nodiscard]] inline std::vector<std::string> schema_problems(const nlohmann::json& value,
                                                              const nlohmann::json& document) {
  return schema_problems(value, document, document);
}

}  // namespace planish::test
