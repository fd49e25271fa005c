#pragma once

#include <string>

#include "help/command_page.h"

namespace planish::command {

/// The manual page (roff, section 1) of planish itself or of one of its commands, of `help`, the
/// page of planish with all of them.
[[nodiscard]] std::string manual_page(const HelpPage& page, const HelpPage& help);

}  // namespace planish::command
