#include "planish/core/memory_size.h"

#include <string>
#include <vector>

#include "planish/core/error.h"

namespace planish {

std::size_t memory_size(std::uint64_t bytes, std::string_view where) {
  constexpr std::size_t kMore = std::size_t{1} << 20;  // what readers put around them
  if (bytes > std::vector<std::byte>().max_size() - kMore)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{}: {} bytes are more than this program can hold; a 64-bit one can",
                          where, bytes));
  return static_cast<std::size_t>(bytes);
}

}  // namespace planish
