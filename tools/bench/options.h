#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace planish::bench {

/// Smallest odd count that the project's own requirements accept as a median.
inline constexpr int kRepetitions = 15;

struct Options {
  std::int32_t quad_count = 1'000'000;  ///< of the torus grid, rounded to a square
  int sphere_level = 6;                 ///< of the rough icosphere; 6 has 40,962 vertices
  int repetitions = kRepetitions;
  std::vector<std::string> groups;  ///< empty: all
  std::filesystem::path json;       ///< empty: none
};

}  // namespace planish::bench
