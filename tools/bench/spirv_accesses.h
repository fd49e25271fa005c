#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace planish::bench {

/// A place in a kernel where lanes read or write a storage buffer; an atomic operation does both.
struct Access {
  std::uint32_t bytes = 0;  ///< of a lane
  bool reads = false, writes = false;
};

/// What kernels write into set 1, binding 0, as words: where the next record goes, a word that the
/// recording puts into each record, two unused ones, and records of four words: that word, number
/// of the access, invocation in x, bytes from the start of the binding. Where a record does not fit
/// the first one is lost instead, and the word of the next record is beyond the end.
inline constexpr std::uint32_t kAccessMark = 1, kFirstAccess = 4, kAccessWords = 4;

/// A compute shader's SPIR-V as glslang makes it, with a record of each access of storage buffers.
/// `accesses` gets its accesses behind those that are there; the numbers are places in it.
[[nodiscard]] std::vector<std::uint32_t> with_access_log(std::span<const std::uint32_t> module,
                                                         std::vector<Access>& accesses);

}  // namespace planish::bench
