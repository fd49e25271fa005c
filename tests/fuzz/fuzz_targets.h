#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "planish/files/formats.h"

namespace planish::test {

/// What is fuzzed under one name, and replayed.
struct FuzzTarget {
  std::string name;
  FileFormat format;
  std::function<void(std::span<const std::byte>, FileFormat)> read;
  std::vector<std::string> folders;  ///< of corpus/
};

/// All of them: README.md has the table.
std::vector<FuzzTarget> fuzz_targets();

}  // namespace planish::test
