#pragma once

#include <cstdlib>

namespace planish::test {

/// How many times a test asks: `usual` in ctest, or what PLANISH_LONG_RUN says.
inline int run_length(int usual) {
  const char* const given = std::getenv("PLANISH_LONG_RUN");
  return given != nullptr ? std::atoi(given) : usual;
}

}  // namespace planish::test
