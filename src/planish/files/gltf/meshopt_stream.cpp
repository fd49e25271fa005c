// Based on: Khronos, "EXT_meshopt_compression", 2021.
#include "planish/files/gltf/meshopt_stream.h"

#include <meshoptimizer.h>

#include <cstdint>

#include "planish/core/memory_size.h"
#include "planish/core/number_text.h"

namespace planish {
namespace {

struct Stream {
  std::int64_t count = 0, stride = 0;
};

// A group of 16 equal bytes takes two bits; a triangle or an index of a sequence at least a byte.
constexpr std::int64_t kMostPerByte = 64;

void require_size(const JsonPlace& extension, const Stream& wanted, std::int64_t most,
                  std::span<const std::byte> stream) {
  if (wanted.count > most)
    extension["count"].fail("{} elements cannot come from {} bytes", wanted.count, stream.size());
}

const unsigned char* unsigned_of(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

void unfilter(const JsonPlace& extension, const Stream& wanted, RawVector<std::byte>& values) {
  const auto filter = extension.find("filter");
  if (!filter || filter->text() == "NONE") return;
  const std::string& name = filter->text();
  const auto count = static_cast<std::size_t>(wanted.count);
  const auto stride = static_cast<std::size_t>(wanted.stride);
  if (name == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(values.data(), count, stride);
  } else if (name == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(values.data(), count, stride);
  } else if (name == "EXPONENTIAL") {
    meshopt_decodeFilterExp(values.data(), count, stride);
  } else {
    filter->fail("{} is no filter of {} bytes", quote(name), stride);
  }
}

RawVector<std::byte> decode_attributes(const JsonPlace& extension, const Stream& wanted,
                                       std::span<const std::byte> stream) {
  constexpr std::int64_t kMostStride = 256;
  if (wanted.stride % 4 != 0 || wanted.stride > kMostStride)
    extension["byteStride"].fail("{} is no multiple of 4 up to 256", wanted.stride);
  const auto size = static_cast<std::int64_t>(stream.size());
  require_size(extension, wanted, size * kMostPerByte / wanted.stride, stream);
  RawVector<std::byte> values(
      memory_size(static_cast<std::uint64_t>(wanted.count * wanted.stride), extension.named()));
  if (meshopt_decodeVertexBuffer(values.data(), static_cast<std::size_t>(wanted.count),
                                 static_cast<std::size_t>(wanted.stride), unsigned_of(stream),
                                 stream.size()) != 0)
    extension.fail("the stream is no meshopt stream of attributes");
  unfilter(extension, wanted, values);
  return values;
}

RawVector<std::byte> decode_indices(const JsonPlace& extension, const Stream& wanted,
                                    std::span<const std::byte> stream, bool is_triangles) {
  if (wanted.stride != 2 && wanted.stride != 4)
    extension["byteStride"].fail("{} is neither 2 nor 4", wanted.stride);
  if (is_triangles && wanted.count % 3 != 0)
    extension["count"].fail("{} corners make no whole triangles", wanted.count);
  const auto size = static_cast<std::int64_t>(stream.size());
  require_size(extension, wanted, is_triangles ? 3 * size : size, stream);
  RawVector<std::byte> values(
      memory_size(static_cast<std::uint64_t>(wanted.count * wanted.stride), extension.named()));
  const auto count = static_cast<std::size_t>(wanted.count);
  const auto index_size = static_cast<std::size_t>(wanted.stride);
  const int failed = is_triangles ? meshopt_decodeIndexBuffer(values.data(), count, index_size,
                                                              unsigned_of(stream), stream.size())
                                  : meshopt_decodeIndexSequence(values.data(), count, index_size,
                                                                unsigned_of(stream), stream.size());
  if (failed != 0) extension.fail("the stream is no meshopt stream of indices");
  return values;
}

}  // namespace

RawVector<std::byte> decode_meshopt(const JsonPlace& extension, std::span<const std::byte> stream) {
  const Stream wanted{extension["count"].integer(1), extension["byteStride"].integer(1)};
  const std::string_view mode = extension["mode"].text();
  if (mode == "ATTRIBUTES") return decode_attributes(extension, wanted, stream);
  if (mode != "TRIANGLES" && mode != "INDICES")
    extension["mode"].fail(quote(mode) + " is not ATTRIBUTES, TRIANGLES or INDICES");
  return decode_indices(extension, wanted, stream, mode == "TRIANGLES");
}

}  // namespace planish
