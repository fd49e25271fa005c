#pragma once

#include <cstdint>
#include <string>

namespace planish::vulkan {

inline constexpr const char* kSmallerMesh = "use --device cpu or a smaller mesh";
inline constexpr const char* kFewerInstances = "use a smaller mesh or fewer instances";

/// Bytes that one binding may span, and the name of the device's limit that says so.
struct BindingLimit {
  std::uint64_t bytes = 0;
  const char* name = "maxStorageBufferRange";

  [[nodiscard]] bool allows(std::uint64_t wanted) const { return wanted <= bytes; }
  /// Throws Error{OutOfMemory} where it does not, with what takes so many bytes, limit and remedy.
  void require(std::uint64_t wanted, const std::string& what,
               const std::string& remedy = kSmallerMesh) const;
};

}  // namespace planish::vulkan
