#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "help/command_page.h"

namespace planish::command {

enum class Shell { Bash, Zsh, Fish };

/// "bash", "zsh" or "fish".
[[nodiscard]] std::optional<Shell> shell_of(std::string_view name);

/// A script that completes commands, flags, the words that a flag takes, and files.
[[nodiscard]] std::string completion_script(Shell shell, const HelpPage& help);

}  // namespace planish::command
