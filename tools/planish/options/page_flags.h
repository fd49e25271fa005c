#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "planish/job/job.h"

namespace planish::command {

/// "8M", "500K", "2G" or bytes. Throws Error{InvalidArgument} naming `where`.
[[nodiscard]] std::uint64_t parse_page_limit(std::string_view value, std::string_view where);

/// The options as flags give them; an empty limit is the default.
[[nodiscard]] PageOptions page_options(const std::string& limit, bool no_times);

}  // namespace planish::command
