#pragma once

#include <string>

#include "help/command_page.h"

namespace planish::command {

/// One screen: usage, the flags that come first, examples. No line is longer than `columns`
/// (at least 40), file names in examples excepted.
[[nodiscard]] std::string short_help(const HelpPage& page, int columns);

/// All flags by topic, examples and notes.
[[nodiscard]] std::string long_help(const HelpPage& page, int columns);

/// "planish: what it is", its commands and one example: the answer to `planish` alone.
[[nodiscard]] std::string overview(const HelpPage& page, int columns);

/// Text cut into lines of at most `columns` at blanks, those after the first begun with `indent`.
[[nodiscard]] std::string wrapped(const std::string& text, int columns, int indent);

}  // namespace planish::command
