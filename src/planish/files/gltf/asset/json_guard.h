#pragma once

#include <string>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/json.h"

namespace planish {

/// What `work` returns, which takes values of a document without a JsonPlace. Throws
/// Error{UnreadableInput}, naming the file, where one is not of the kind that the format has there.
template <class Work>
auto guard_json(std::string_view file, const Work& work) {
  try {
    return work();
  } catch (const nlohmann::json::exception& error) {
    // The library's messages begin with an identifier in brackets.
    const std::string message = error.what();
    const std::size_t begin = message.find("] ");
    throw Error(ErrorCode::UnreadableInput,
                std::string(file) + ": a value is not of the kind that glTF has there: " +
                    (begin == std::string::npos ? message : message.substr(begin + 2)));
  }
}

}  // namespace planish
