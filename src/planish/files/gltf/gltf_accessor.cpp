#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

// Based on: Khronos, "EXT_meshopt_compression", 2021.

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

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", section 3.6.2 (accessors).

struct Wanted {
  std::string_view type, name;
};

Wanted wanted_of(GltfAccessor::Use use, std::string_view type) {
  switch (use) {
    case GltfAccessor::Use::Positions:
      return {"VEC3", "positions"};
    case GltfAccessor::Use::Normals:
      return {"VEC3", "normals"};
    case GltfAccessor::Use::Indices:
      return {"SCALAR", "indices"};
    case GltfAccessor::Use::TextureCoordinates:
      return {"VEC2", "texture coordinates"};
    case GltfAccessor::Use::Numbers:
      return {"SCALAR", "numbers"};
    case GltfAccessor::Use::Vectors: {
      const bool is_vector = type == "SCALAR" || type == "VEC2" || type == "VEC3";
      return {is_vector ? type : "VEC4", "attributes"};
    }
    case GltfAccessor::Use::Matrices:
      return {"MAT4", "matrices"};
    case GltfAccessor::Use::Colors:
      break;
  }
  return {type == "VEC3" ? "VEC3" : "VEC4", "colours"};
}

// What an accessor without a buffer view has where it is not sparse (section 3.6.2.1): as many as a
// MAT4 of floats.
constexpr std::array<std::byte, 64> kZeros{};

// The bytes of a part of a sparse accessor: `bytes` of them, without gaps.
std::span<const std::byte> tight_part(const JsonPlace& root, const JsonPlace& place,
                                      std::int64_t bytes, GltfSource& source) {
  const std::int64_t view_index = place["bufferView"].integer();
  const std::span<const std::byte> view = source.view(view_index);
  const JsonPlace at = root["bufferViews"][view_index];
  if (at.find("byteStride")) at["byteStride"].fail("the parts of sparse accessors have no stride");
  // Both are at most 2^53 and 2^57, so that the sum cannot overflow.
  const std::int64_t offset = place.integer_or("byteOffset", 0);
  if (offset + bytes > static_cast<std::int64_t>(view.size()))
    place.fail("reaches to byte {} of {}, which has {}", offset + bytes, at.path(), view.size());
  return view.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes));
}

}  // namespace

GltfAccessor::GltfAccessor(const JsonPlace& root, std::int64_t index, Use use, GltfSource& source,
                           const UnpackedElements* unpacked) {
  const JsonPlace place = root["accessors"][index];
  const Wanted wanted = wanted_of(use, place["type"].text());
  if (place["type"].text() != wanted.type)
    place["type"].fail(quote(place["type"].text()) + " stands in the place of " +
                       quote(wanted.type));
  number_count_ = wanted.type == "SCALAR" ? 1
                  : wanted.type == "MAT4" ? 16
                                          : wanted.type.back() - '0';

  const std::int64_t component = place["componentType"].integer();
  const bool is_signed = component == Byte || component == Short || component == Float;
  const bool is_known = is_signed || component == UByte || component == UShort || component == UInt;
  if (!is_known || (use == Use::Indices ? is_signed : component == UInt) ||
      (use == Use::Matrices && component != Float))
    place["componentType"].fail("{} cannot be used for {}", component, wanted.name);
  component_ = static_cast<Component>(component);
  component_bytes_ = component <= UByte ? 1 : component <= UShort ? 2 : 4;
  if (const auto normalized = place.find("normalized")) normalized_ = normalized->boolean();

  count_ = place["count"].integer(1);
  const bool is_sparse = place.find("sparse").has_value();
  if (unpacked) {
    if (is_sparse) place["sparse"].fail("Draco streams cannot be sparse");
    use_elements(place, *unpacked);
  } else if (place.find("bufferView")) {
    use_view(root, place, source);
  } else if (use == Use::Indices && !is_sparse) {
    place.fail("has no `bufferView`: each index is 0, which makes no triangle");
  }
  if (is_sparse) use_sparse(root, place, index, source);
}

// Indices come in the width that they were unpacked to, whatever the accessor says.
void GltfAccessor::use_elements(const JsonPlace& place, const UnpackedElements& unpacked) {
  if (number_count_ == 1) component_ = static_cast<Component>(unpacked.component);
  component_bytes_ = unpacked.component <= UByte ? 1 : unpacked.component <= UShort ? 2 : 4;
  if (component_ != unpacked.component || number_count_ != unpacked.number_count ||
      count_ != unpacked.count)
    place.fail("its {} elements of {} numbers of type {} are packed as {} of {} of type {}", count_,
               number_count_, std::to_string(component_), unpacked.count, unpacked.number_count,
               unpacked.component);
  stride_ = component_bytes_ * number_count_;
  bytes_ = unpacked.bytes;
}

void GltfAccessor::use_view(const JsonPlace& root, const JsonPlace& place, GltfSource& source) {
  const std::int64_t element_bytes = component_bytes_ * number_count_;
  const std::int64_t view_index = place["bufferView"].integer();
  bytes_ = source.view(view_index);
  const JsonPlace view = root["bufferViews"][view_index];
  constexpr std::int64_t kMaxStride = 252;
  stride_ = view.integer_or("byteStride", element_bytes);
  if (stride_ < element_bytes || stride_ > kMaxStride)
    view["byteStride"].fail("{} is not between {} and {}", stride_, element_bytes, kMaxStride);
  const std::int64_t offset = place.integer_or("byteOffset", 0);
  // Offset and count are at most 2^53 and the stride 252, so that nothing can overflow.
  const std::int64_t end = offset + stride_ * (count_ - 1) + element_bytes;
  if (end > static_cast<std::int64_t>(bytes_.size()))
    place.fail("{} elements reach to byte {} of {}, which has {}", count_, end, view.path(),
               bytes_.size());
  bytes_ = bytes_.subspan(static_cast<std::size_t>(offset));
}

void GltfAccessor::use_sparse(const JsonPlace& root, const JsonPlace& place, std::int64_t index,
                              GltfSource& source) {
  const JsonPlace sparse = place["sparse"], indices = sparse["indices"];
  sparse_count_ = sparse["count"].integer(1);
  if (sparse_count_ > count_)
    sparse["count"].fail("{} is more than the accessor has ({})", sparse_count_, count_);
  const std::int64_t type = indices["componentType"].integer();
  if (type != UByte && type != UShort && type != UInt)
    indices["componentType"].fail("{} cannot be used for indices", type);
  sparse_index_bytes_ = type == UByte ? 1 : type == UShort ? 2 : 4;
  sparse_indices_ = tight_part(root, indices, sparse_count_ * sparse_index_bytes_, source);
  sparse_values_ =
      tight_part(root, sparse["values"], sparse_count_ * component_bytes_ * number_count_, source);
  // Once, however often nodes place what uses it.
  if (source.is_new_sparse(index)) require_ascending(indices);
}

void GltfAccessor::require_ascending(const JsonPlace& indices) const {
  std::int64_t before = -1;
  for (std::int64_t i = 0; i < sparse_count_; ++i) {
    const std::int64_t at = sparse_index(i);
    if (at >= count_) indices.fail("entry {} names element {} of {}", i, at, count_);
    if (at <= before) indices.fail("entry {} is {} behind {}; they must ascend", i, at, before);
    before = at;
  }
}

std::uint32_t GltfAccessor::sparse_index(std::int64_t place) const {
  const auto bytes = sparse_indices_.subspan(static_cast<std::size_t>(place * sparse_index_bytes_));
  if (sparse_index_bytes_ == 1) return load<std::uint8_t>(bytes);
  if (sparse_index_bytes_ == 2) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

std::span<const std::byte> GltfAccessor::element(std::int64_t index) const {
  std::int64_t low = 0, high = sparse_count_;  // the first that is not before `index`
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    if (sparse_index(middle) < index) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  if (low < sparse_count_ && sparse_index(low) == index)
    return sparse_values_.subspan(static_cast<std::size_t>(low * component_bytes_ * number_count_));
  if (bytes_.empty()) return kZeros;
  return bytes_.subspan(static_cast<std::size_t>(index * stride_));
}

double GltfAccessor::component(std::span<const std::byte> bytes) const {
  const auto scaled = [&](double value, double largest) {
    return normalized_ ? std::max(value / largest, -1.0) : value;
  };
  switch (component_) {
    case Byte:
      return scaled(load<std::int8_t>(bytes), 127);
    case UByte:
      return scaled(load<std::uint8_t>(bytes), 255);
    case Short:
      return scaled(load<std::int16_t>(bytes), 32767);
    case UShort:
      return scaled(load<std::uint16_t>(bytes), 65535);
    case UInt:
      return load<std::uint32_t>(bytes);
    case Float:
      return load<float>(bytes);
  }
  return 0;
}

double GltfAccessor::number(std::int64_t index, std::int64_t k) const {
  return component(element(index).subspan(static_cast<std::size_t>(k * component_bytes_)));
}

glm::dvec3 GltfAccessor::position(std::int64_t index) const {
  return {number(index, 0), number(index, 1), number(index, 2)};
}

glm::dvec2 GltfAccessor::texture_coordinate(std::int64_t index) const {
  return {number(index, 0), number(index, 1)};
}

glm::vec4 GltfAccessor::color(std::int64_t index) const {
  return glm::vec4(number(index, 0), number(index, 1), number(index, 2),
                   number_count_ == 4 ? number(index, 3) : 1.0);
}

std::uint32_t GltfAccessor::index(std::int64_t index) const {
  const auto bytes = element(index);
  if (component_ == UByte) return load<std::uint8_t>(bytes);
  if (component_ == UShort) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

}  // namespace planish
