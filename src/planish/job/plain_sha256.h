#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace planish {

/// SHA-256 (FIPS 180-4) without a library, for where there is none. libcrypto's takes the
/// processor's instructions for it, and an eighth of the time.
class PlainSha256 {
 public:
  void add(std::span<const std::byte> bytes);
  /// The last call.
  [[nodiscard]] std::array<std::uint8_t, 32> finish();

 private:
  void add_block(const std::byte* block);
  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> rest_{};
  std::uint64_t length_ = 0;  // bytes; rest_ holds the last length_ % 64
};

}  // namespace planish
