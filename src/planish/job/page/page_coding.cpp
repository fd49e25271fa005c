#include "planish/job/page/page_coding.h"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"

namespace planish {
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

// A piece of a raw deflate stream, ending at a whole byte; `before`: what the stream holds so far.
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> before,
                                   std::span<const std::uint8_t> bytes, bool is_last) {
  // Level 9 takes four times as long for one byte in a hundred.
  constexpr int kLevel = 6, kRawDeflate = -15, kMemory = 9;
  constexpr std::size_t kWindow = std::size_t{1} << 15;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kRawDeflate, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const auto window = before.last(std::min(kWindow, before.size()));
  deflateSetDictionary(&stream, window.data(), static_cast<uInt>(window.size()));
  // zlib's bound is that of a last piece: a flush adds five bytes at most.
  std::vector<std::uint8_t> packed(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 16);
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  const int state = deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  PLANISH_ASSERT(state == (is_last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0);
  packed.resize(packed.size() - stream.avail_out);
  packed.shrink_to_fit();  // all pieces are held at once
  deflateEnd(&stream);
  return packed;
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
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  const std::size_t count = std::max<std::size_t>((bytes_.size() + kPiece - 1) / kPiece, 1);
  std::vector<std::vector<std::uint8_t>> pieces(count);
  parallel_each(count, 1, [&](std::size_t i) {
    const std::size_t first = i * kPiece, length = std::min(kPiece, bytes_.size() - first);
    pieces[i] =
        deflated(std::span(bytes_).first(first), {bytes_.data() + first, length}, i + 1 == count);
  });
  std::vector<std::uint8_t> packed;
  for (const auto& piece : pieces) packed.insert(packed.end(), piece.begin(), piece.end());
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

}  // namespace planish
