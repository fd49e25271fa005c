#pragma once

#include <string>

#include "bench/group.h"
#include "planish/core/error.h"

namespace planish::bench {

/// The row of something that a device has no room for, which is no failure. To be called where the
/// error is caught: throws it on where it is another.
[[nodiscard]] inline Row refusal(const Error& error, const std::string& group,
                                 const std::string& size, const std::string& peer) {
  if (error.code() != ErrorCode::OutOfMemory) throw;
  Row row;
  row.group = group;
  row.size = size;
  row.peer = peer;
  row.refused = error.what();
  return row;
}

}  // namespace planish::bench
