#pragma once

#include <cstdint>
#include <string_view>

namespace planish::command {

/// "500K", "8M", "4G" or plain bytes. Throws Error{InvalidArgument} naming `where` for what is no
/// size of up to `most`, with an example.
[[nodiscard]] std::uint64_t parse_size(std::string_view value, std::string_view where,
                                       std::uint64_t most, std::string_view example);

}  // namespace planish::command
