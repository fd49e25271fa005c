// Based on: the description of the LZF stream format in the manual of LibLZF, M. A. Lehmann.
// A control byte c < 32: c + 1 literal bytes follow. Otherwise a copy of earlier output: its
// length is c >> 5, or 7 plus the next byte where that is 7, plus 2; its distance is
// ((c & 31) << 8 | next byte) + 1.
#include "planish/files/pcd/lzf.h"

#include <cstdint>

namespace planish {
namespace {

// Three bytes copy at most 264.
constexpr std::size_t kMaxExpansion = 88;

}  // namespace

std::vector<std::byte> expand_lzf(std::span<const std::byte> data, std::size_t size) {
  if (size / kMaxExpansion > data.size()) return {};
  std::vector<std::byte> output;
  output.reserve(size);
  std::size_t at = 0;
  const auto has = [&](std::size_t count) { return count <= data.size() - at; };
  const auto next = [&] { return std::to_integer<std::size_t>(data[at++]); };
  while (at < data.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t count = control + 1;
      if (!has(count) || count > size - output.size()) return {};
      output.insert(output.end(), data.begin() + at, data.begin() + at + count);
      at += count;
      continue;
    }
    std::size_t count = control >> 5;
    if (!has(count == 7 ? 2 : 1)) return {};
    if (count == 7) count += next();
    count += 2;
    const std::size_t distance = ((control & 31) << 8 | next()) + 1;
    if (distance > output.size() || count > size - output.size()) return {};
    // Source and target may overlap: byte by byte.
    for (std::size_t i = 0; i < count; ++i) output.push_back(output[output.size() - distance]);
  }
  if (output.size() != size) return {};
  return output;
}

}  // namespace planish
