#pragma once

#include <string>
#include <string_view>

#include "options/scene_values.h"

namespace planish::command {

/// Text as JSON, without what the parser itself lets pass: deep nesting and keys that stand twice.
/// Throws Error{InvalidArgument}: `name:line: what`.
[[nodiscard]] Json parse_json(std::string_view text, const std::string& name);

}  // namespace planish::command
