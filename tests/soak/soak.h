#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planish::test {

/// What is allocated after each step. Threads and drivers keep buffers as large as the largest job
/// that they met, so the least of a quarter is what tells.
class Growth {
 public:
  void note(std::uint64_t bytes) { bytes_.push_back(bytes); }
  /// Bytes by which the last quarter's least exceeds that of an earlier one, counted from 0; 0
  /// where it does not.
  [[nodiscard]] std::uint64_t bytes(std::size_t since = 1) const;
  /// "first .. last MiB" of the quarters, for people.
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] std::uint64_t least(std::size_t quarter) const;
  std::vector<std::uint64_t> bytes_;
};

/// Says what went wrong, and counts it.
void complain(const std::string& what);
[[nodiscard]] int complaints();

/// Whether an editor's or a host's soak was asked by SIGINT or SIGTERM to end with what there is.
[[nodiscard]] bool is_stopped();

/// Memory of this process, in pages of 4 KiB.
[[nodiscard]] std::uint64_t resident_bytes();

/// Fits `count` files through the C header.
void soak_service(std::uint32_t count, std::uint32_t first);
/// Makes at most `count` edits, of editors of both methods.
void soak_edit(std::uint32_t count, std::uint32_t first);
/// Opens at most `count` sessions of a Vulkan device; false where there is none.
[[nodiscard]] bool soak_host(std::uint32_t count, std::uint32_t first);

}  // namespace planish::test
