#pragma once

#include <string>
#include <string_view>

namespace planish {

/// Throws Error{InvalidArgument}: `where: what`, for a value that is not what is wanted there.
[[noreturn]] void refuse(std::string_view where, const std::string& what);

}  // namespace planish
