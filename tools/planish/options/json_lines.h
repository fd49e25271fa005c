#pragma once

#include <map>
#include <string>
#include <string_view>

namespace planish::command {

/// The line, from 1, on which each key and each entry of a list stands in valid JSON text, by its
/// path: "jobs[0].outputs[1].path".
[[nodiscard]] std::map<std::string, int> lines_of_json(std::string_view text);

}  // namespace planish::command
