#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

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

/// SHA-256 of bytes that come piece by piece.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  void add(std::span<const std::byte> bytes);
  /// Either is the last call; text is in lower-case hexadecimal.
  [[nodiscard]] std::array<std::uint8_t, 32> finish_bytes();
  [[nodiscard]] std::string finish();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// The digest of a file while it is written, where one is wanted.
class WrittenDigest {
 public:
  explicit WrittenDigest(bool is_wanted) {
    if (is_wanted) digest_.emplace();
  }
  /// For who writes; the digest must stay where it is. Empty: none is wanted.
  [[nodiscard]] std::function<void(std::span<const std::byte>)> observer() {
    if (!digest_) return {};
    return [this](std::span<const std::byte> bytes) { digest_->add(bytes); };
  }
  void add(std::span<const std::byte> bytes) {
    if (digest_) digest_->add(bytes);
  }
  /// Empty where none is wanted.
  [[nodiscard]] std::string finish() { return digest_ ? digest_->finish() : std::string(); }

 private:
  std::optional<Sha256> digest_;
};

/// The same of bytes at hand.
[[nodiscard]] std::array<std::uint8_t, 32> sha256_bytes(std::span<const std::byte> bytes);

/// In lower-case hexadecimal.
[[nodiscard]] std::string sha256(std::span<const std::byte> bytes);

/// The same of a whole file, and its length. Throws Error{UnreadableInput}.
struct FileDigest {
  std::string sha256;
  std::uint64_t bytes = 0;
};
[[nodiscard]] FileDigest digest_of(const std::filesystem::path& path);

}  // namespace planish
