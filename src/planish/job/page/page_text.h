#pragma once

#include <string>
#include <string_view>

#include "planish/core/json.h"

namespace planish {

// Everything that a page shows came from outside: names of files, jobs and devices, messages that
// quote them. What follows is all that stands between them and the page.

/// Text in which everything can be seen: control characters, marks that are invisible or turn the
/// direction of writing, and code points that are none stand as `u202e` behind a backslash, bytes
/// that are no UTF-8 as `xff`. Valid UTF-8. A line end is a control character like the others.
[[nodiscard]] std::string visible_text(std::string_view text);

/// visible_text() with & < > " ' ` as character references: for element content and quoted
/// attributes.
[[nodiscard]] std::string html_text(std::string_view text);

/// The same line by line, for preformatted text: line ends stay.
[[nodiscard]] std::string html_lines(std::string_view text);

/// Every string in a JSON value made visible, keys too.
[[nodiscard]] nlohmann::ordered_json visible_json(const nlohmann::ordered_json& value);

/// JSON for the inside of a script element: ASCII, with < > & as their escapes, so that nothing in
/// it can end the element.
[[nodiscard]] std::string script_json(const nlohmann::ordered_json& value);

/// A word of a command as a POSIX shell needs it written.
[[nodiscard]] std::string shell_word(std::string_view word);

/// Three significant digits: 1.99e-07, 0.353, 69,700, 1.5e+06; "not finite" for what is not.
[[nodiscard]] std::string figure(double number);
/// Of a report's number, which is null where it is not finite.
[[nodiscard]] std::string figure(const nlohmann::ordered_json& number);

}  // namespace planish
