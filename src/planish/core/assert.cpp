#include "planish/core/assert.h"

#include <stdexcept>
#include <string>

namespace planish {

void assertion_failed(const char* condition, const char* file, int line) {
  throw std::logic_error(std::string(file) + ":" + std::to_string(line) +
                         ": assertion failed: " + condition);
}

}  // namespace planish
