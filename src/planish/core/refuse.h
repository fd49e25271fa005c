#pragma once

#include <string>
#include <string_view>

#include "planish/core/formatted.h"

namespace planish {

/// Throws Error{InvalidArgument}: `where: what`, for a value that is not what is wanted there.
[[noreturn]] void refuse(std::string_view where, const std::string& what);
/// With formatted() text.
template <class... Values>
requires(sizeof...(Values) > 0)
    [[noreturn]] void refuse(std::string_view where, FormatText<sizeof...(Values)> format,
                             const Values&... values) {
  refuse(where, formatted(format, values...));
}

}  // namespace planish
