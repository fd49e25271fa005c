#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/files/formats.h"

namespace planish::test {

/// Readers of text are asked for small parts, and of one input in so many, drawn by its bytes, for
/// one part and for the file, too. All are asked for all until a fuzzer, which has many, says this.
void ask_all_of_one_in(std::uint64_t inputs);

/// Reads, checks and counts; aborts when the reader breaks its promises: an Error of another kind,
/// a message with a character that nobody sees, an index out of range, a position that is not
/// finite, any other exception. Returns the message, or what was read: its counts, a number that
/// stands for all its bits, and the warnings.
std::string fuzz_read_mesh(std::span<const std::byte> bytes, FileFormat format);

/// The same of a Draco stream, with two bytes for its points and two for its triangles in front,
/// as a GLB has it.
std::string fuzz_read_draco(std::span<const std::byte> bytes, FileFormat format);

/// The same of a meshopt stream, with two bytes for its elements in front, one for their bytes and
/// one for mode and filter.
std::string fuzz_read_meshopt(std::span<const std::byte> bytes, FileFormat format);

/// The same for points.
std::string fuzz_read_points(std::span<const std::byte> bytes, FileFormat format);

/// The same of an LZF stream, with two bytes for its points in front, as a PCD has it.
std::string fuzz_read_lzf(std::span<const std::byte> bytes, FileFormat format);

/// A glTF that stays an asset: each of its meshes, its materials and what is told of it.
void fuzz_read_asset(std::span<const std::byte> bytes, FileFormat format);

/// The library of an OBJ's materials, and what glTF and USD make of it.
void fuzz_read_mtl(std::span<const std::byte> bytes, FileFormat format);

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline void require(bool holds) {
  if (!holds) std::abort();
}

/// Aborts where a message has a character that nobody sees.
void require_visible(const std::vector<Warning>& warnings);

/// Aborts unless the error is one of `codes` with a message in which everything can be seen.
void require_refusal(const Error& error, std::initializer_list<ErrorCode> codes);

}  // namespace planish::test
