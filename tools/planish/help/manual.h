#pragma once

#include <string>

#include "help/command_page.h"

namespace planish::command {

/// The manual page (roff, section 1) of a program or of one of its commands, of `help`, the page of
/// the program with all of them.
[[nodiscard]] std::string manual_page(const HelpPage& page, const HelpPage& help);

}  // namespace planish::command
