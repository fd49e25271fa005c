#include "planish/core/error.h"

namespace planish {

Error::Error(ErrorCode code, const std::string& message, std::int64_t element)
    : std::runtime_error(message), code_(code), element_(element) {}

}  // namespace planish
