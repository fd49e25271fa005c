#pragma once

#include <string_view>

#include "planish/pipeline/settings.h"

namespace planish {

/// "use", "ignore", "normals", "auto" or "auto:22.5". Throws Error{InvalidArgument}: `where`, the
/// text and what is wanted.
[[nodiscard]] CreaseChoice parse_creases(std::string_view text, std::string_view where);

/// The texts that it takes, as a regular expression.
inline constexpr std::string_view kCreasesPattern =
    "^(choose|use|ignore|normals|auto(:0*(180(\\.0+)?|(1[0-7][0-9]|[1-9]?[0-9])(\\.[0-9]+)?)(e-[0-"
    "9]+)?)?)"
    "$";

}  // namespace planish
