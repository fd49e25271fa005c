#pragma once

#include <string>

namespace planish::command {

/// "planish 0.1.0 (commit)", then a line for each part that a build may have or lack, with its
/// version.
[[nodiscard]] std::string version_text();

}  // namespace planish::command
