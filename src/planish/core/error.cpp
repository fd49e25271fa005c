#include "planish/core/error.h"

#include "planish/core/visible_text.h"

namespace planish {

// Messages quote what came from outside: hosts can take them as text.
Error::Error(ErrorCode code, const std::string& message, std::int64_t element)
    : std::runtime_error(visible_lines(message)), code_(code), element_(element) {}

}  // namespace planish
