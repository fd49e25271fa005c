#include "planish/core/refuse.h"

#include "planish/core/error.h"

namespace planish {

void refuse(std::string_view where, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument, std::string(where) + ": " + what);
}

}  // namespace planish
