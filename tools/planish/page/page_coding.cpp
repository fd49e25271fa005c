#include "page/page_coding.h"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "planish/core/assert.h"

namespace planish::command {
namespace {

std::uint64_t zigzag(std::int64_t difference) {
  return static_cast<std::uint64_t>(difference) << 1 ^ static_cast<std::uint64_t>(difference >> 63);
}

// The difference of two numbers that wraps at 2^(8 width), in the half of its range around 0.
std::int64_t wrapped(std::int64_t difference, int width) {
  const std::int64_t range = std::int64_t{1} << (8 * width);
  difference &= range - 1;
  return difference < range / 2 ? difference : difference - range;
}

}  // namespace

void PageCoder::begin(const std::string& name, std::size_t count, int width, int components) {
  sections_.push_back({{"name", name},
                       {"count", count},
                       {"width", width},
                       {"components", components},
                       {"offset", bytes_.size()}});
  bytes_.resize(bytes_.size() + count * static_cast<std::size_t>(width * components));
}

void PageCoder::put(std::size_t plane, std::size_t count, std::size_t i, int width,
                    std::int64_t difference) {
  const std::uint64_t code = zigzag(wrapped(difference, width));
  for (int b = 0; b < width; ++b)
    bytes_[plane + static_cast<std::size_t>(b) * count + i] =
        static_cast<std::uint8_t>(code >> (8 * b));
}

void PageCoder::add_list(const std::string& name, std::span<const std::int32_t> values) {
  constexpr int kWidth = 4;
  const std::size_t plane = bytes_.size();
  begin(name, values.size(), kWidth, 1);
  std::int64_t last = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    put(plane, values.size(), i, kWidth, values[i] - last);
    last = values[i];
  }
}

void PageCoder::add_values(const std::string& name, std::span<const std::uint16_t> values,
                           int width, int components, const PageOrder& order) {
  const std::size_t count = values.size() / static_cast<std::size_t>(components);
  std::size_t plane = bytes_.size();
  begin(name, count, width, components);
  for (int c = 0; c < components; ++c) {
    const auto value = [&](std::size_t i) {
      return static_cast<std::int64_t>(
          values[i * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)]);
    };
    std::int64_t last = 0;
    const std::size_t first = std::min(count, order.counts.empty() ? count : order.counts[0]);
    for (std::size_t i = 0; i < first; ++i) {
      put(plane, count, i, width, value(i) - last);
      last = value(i);
    }
    for (std::size_t l = 0; l < order.splits.size(); ++l) {
      const PageSplit& split = order.splits[l];
      for (std::size_t i = order.counts[l]; i < std::min(count, order.counts[l + 1]); ++i) {
        const std::size_t k = i - order.counts[l];
        const std::int32_t begin = split.parent_offsets[k], end = split.parent_offsets[k + 1];
        std::int64_t sum = 0;
        for (std::int32_t p = begin; p < end; ++p)
          sum += value(static_cast<std::size_t>(split.parents[p]));
        const std::int64_t n = end - begin;
        put(plane, count, i, width, value(i) - (2 * sum + n) / (2 * n));
      }
    }
    plane += count * static_cast<std::size_t>(width);
  }
}

std::string PageCoder::base64() const {
  z_stream stream{};
  constexpr int kRawDeflate = -15, kMemory = 9;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kRawDeflate, kMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  // Input and output are given in pieces, because zlib counts in 32 bits.
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  std::vector<std::uint8_t> packed, piece(kPiece);
  std::size_t at = 0;
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    const std::size_t length = std::min(kPiece, bytes_.size() - at);
    stream.next_in = const_cast<Bytef*>(bytes_.data() + at);
    stream.avail_in = static_cast<uInt>(length);
    at += length;
    const int flush = at == bytes_.size() ? Z_FINISH : Z_NO_FLUSH;
    do {
      stream.next_out = piece.data();
      stream.avail_out = static_cast<uInt>(piece.size());
      state = deflate(&stream, flush);
      PLANISH_ASSERT(state != Z_STREAM_ERROR);
      packed.insert(packed.end(), piece.data(), stream.next_out);
    } while (stream.avail_out == 0);
  }
  deflateEnd(&stream);
  return base64_text(packed);
}

std::string base64_text(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = std::uint32_t{bytes[i]} << 16;
    if (left > 1) word |= std::uint32_t{bytes[i + 1]} << 8;
    if (left > 2) word |= bytes[i + 2];
    text += kDigits[word >> 18];
    text += kDigits[word >> 12 & 63];
    text += left > 1 ? kDigits[word >> 6 & 63] : '=';
    text += left > 2 ? kDigits[word & 63] : '=';
  }
  return text;
}

}  // namespace planish::command
