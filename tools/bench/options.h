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
  /// Given points of the groups `kernels` and `frame`.
  std::vector<std::int32_t> point_counts = {10'000, 100'000, 1'000'000};
  int loop_frames = 240;
  std::uint64_t copy_bytes = 256u << 20;  ///< of each buffer of the copies; as far as it fits
  std::string device;                     ///< Vulkan's, as in vulkan::pick_device; empty: the best
  bool hardware_kernels = false;          ///< kernels as hardware gets them, whatever the device
  std::uint64_t max_range = 0;            ///< as ContextOptions::max_storage_range
  std::vector<std::string> groups;        ///< empty: all
  std::filesystem::path json;             ///< empty: none
};

}  // namespace planish::bench
