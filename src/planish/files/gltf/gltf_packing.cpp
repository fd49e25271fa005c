// Based on: Khronos, "KHR_mesh_quantization", 2020, and "EXT_meshopt_compression", 2021.
#include "planish/files/gltf/gltf_packing.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>
#include <string_view>
#include <utility>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/packed_numbers.h"
#include "planish/files/gltf/position_grid.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

// Textures of 16384 texels: an eighth of a texel, and room for 16 tilings in float's 24 bits.
constexpr double kUvError = 1.0 / (8 * 16384);

template <class Value>
std::span<const std::byte> bytes_of(const RawVector<Value>& values) {
  return std::as_bytes(std::span(values));
}

template <class Value>
std::span<const Value> values_in(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const Value*>(bytes.data()), bytes.size() / sizeof(Value)};
}

FloatBox bounds_of(std::span<const glm::vec3> positions) {
  const auto [low, high] = point_bounds(positions);
  return {low, high};
}

bool is_uv(std::string_view name) { return name.starts_with("TEXCOORD_"); }
bool is_direction(std::string_view name) { return name == "NORMAL" || name == "TANGENT"; }
std::size_t width_of(const GltfArray& array) { return array.type == "VEC4" ? 4 : 3; }
bool is_color(std::string_view name) { return name.starts_with("COLOR_"); }

// An array in its new form.
struct PackedArray {
  GltfArray array;
  RawVector<std::byte> bytes;  // as in the file
};

void use(PackedArray& packed, std::span<const std::byte> bytes) {
  packed.bytes.resize(bytes.size());
  std::memcpy(packed.bytes.data(), bytes.data(), bytes.size());
  packed.array.bytes = bytes.size();
}

class Packer {
 public:
  Packer(GltfPayload plain, const GltfVertices& vertices, const GltfOptions& options,
         const FloatBox& bounds)
      : payload_(std::move(plain)),
        vertices_(vertices),
        options_(options),
        grid_(position_grid(bounds, options)),
        packed_(payload_.arrays.size()) {}

  GltfPayload operator()() {
    payload_.extensions = {"KHR_mesh_quantization"};
    if (is_meshopt())
      payload_.extensions.insert(payload_.extensions.begin(), "EXT_meshopt_compression");
    if (grid_.step > 0) {
      payload_.translation += grid_.origin;
      payload_.scale = grid_.step;
    }
    decoded_.resize(static_cast<std::size_t>(std::min(row_count(), options_.decoded_rows)));
    for (std::size_t i = 0; i < payload_.primitives.size(); ++i) pack_primitive(i);
    if (options_.decoded) options_.decoded(decoded_);
    assemble();
    return std::move(payload_);
  }

 private:
  [[nodiscard]] bool is_meshopt() const { return options_.compression == GltfCompression::Meshopt; }
  [[nodiscard]] std::int64_t row_count() const {
    std::int64_t count = vertices_.kept_rows;
    for (const std::int32_t row : vertices_.rows) count = std::max<std::int64_t>(count, row + 1);
    return count;
  }
  [[nodiscard]] std::span<const std::byte> plain_bytes(std::size_t array) const {
    const GltfArray& from = payload_.arrays[array];
    return std::span(payload_.pieces.front()).subspan(from.offset, from.bytes);
  }

  void pack_primitive(std::size_t primitive);
  void pack_indices(std::size_t array, const StripOrder& order);
  void pack_attribute(const std::string& name, std::size_t array, const GltfPart& part,
                      std::span<const std::uint32_t> order);
  void quantize(const std::string& name, std::span<const std::byte> bytes, PackedArray& packed);
  void compress(const std::string& name, std::span<const std::byte> bytes, PackedArray& packed);
  [[nodiscard]] RawVector<float> placed(std::span<const glm::vec3> positions) const;
  void note_decoded(PackedArray& packed, const GltfPart& part,
                    std::span<const std::uint32_t> order);
  void assemble();

  GltfPayload payload_;  // its arrays and bytes are the plain ones until all is packed
  const GltfVertices& vertices_;
  const GltfOptions& options_;
  PositionGrid grid_;
  std::vector<PackedArray> packed_;
  std::vector<glm::dvec3> decoded_;  // by row
};

// Vertices in their new order.
RawVector<std::byte> reordered(std::span<const std::byte> bytes, std::size_t size,
                               std::span<const std::uint32_t> order) {
  RawVector<std::byte> moved(bytes.size());
  constexpr std::size_t kGrain = std::size_t{1} << 14;
  parallel_each(order.size(), kGrain, [&](std::size_t i) {
    std::memcpy(moved.data() + size * order[i], bytes.data() + size * i, size);
  });
  return moved;
}

void Packer::pack_primitive(std::size_t primitive) {
  const GltfPrimitive& arrays = payload_.primitives[primitive];
  const GltfPart& part = vertices_.parts[primitive];
  if (!is_meshopt()) {
    packed_[arrays.indices].array = payload_.arrays[arrays.indices];
    use(packed_[arrays.indices], plain_bytes(arrays.indices));
    for (const auto& [name, array] : arrays.attributes) pack_attribute(name, array, part, {});
    return;
  }
  const std::span<const std::byte> bytes = plain_bytes(arrays.indices);
  RawVector<std::uint32_t> indices;
  if (payload_.arrays[arrays.indices].component == GltfComponent::UnsignedShort) {
    const auto narrow = values_in<std::uint16_t>(bytes);
    indices.assign(narrow.begin(), narrow.end());
  } else {
    const auto wide = values_in<std::uint32_t>(bytes);
    indices.assign(wide.begin(), wide.end());
  }
  const StripOrder order = strip_order(indices, static_cast<std::size_t>(part.vertex_count));
  indices = {};
  const std::vector<std::pair<std::string, std::size_t>> attributes(arrays.attributes.begin(),
                                                                    arrays.attributes.end());
  parallel_each(attributes.size() + 1, 1, [&](std::size_t i) {
    if (i == 0) return pack_indices(arrays.indices, order);
    const auto& [name, array] = attributes[i - 1];
    pack_attribute(name, array, part, order.new_vertices);
  });
}

void Packer::pack_indices(std::size_t array, const StripOrder& order) {
  PackedArray& packed = packed_[array];
  packed.array = payload_.arrays[array];
  packed.array.stream = GltfStream{.mode = "TRIANGLES"};
  packed.bytes = encode_triangles(order.indices, order.new_vertices.size());
}

void Packer::pack_attribute(const std::string& name, std::size_t array, const GltfPart& part,
                            std::span<const std::uint32_t> order) {
  PackedArray& packed = packed_[array];
  packed.array = payload_.arrays[array];
  const std::span<const std::byte> bytes = plain_bytes(array);
  if (is_meshopt()) {
    const RawVector<std::byte> moved = reordered(bytes, bytes.size() / packed.array.count, order);
    compress(name, moved, packed);
  } else {
    quantize(name, bytes, packed);
  }
  if (name == "POSITION") note_decoded(packed, part, order);
}

void Packer::quantize(const std::string& name, std::span<const std::byte> bytes,
                      PackedArray& packed) {
  GltfArray& array = packed.array;
  if (is_direction(name)) {
    array.component = GltfComponent::Short;
    array.normalized = true;
    array.stride = 8;
    use(packed, bytes_of(short_vectors(values_in<float>(bytes), width_of(array))));
  } else if (name == "POSITION" && grid_.step > 0) {
    array.component = GltfComponent::UnsignedShort;
    array.stride = 8;
    const auto positions = values_in<glm::vec3>(bytes);
    RawVector<std::uint16_t> places(4 * positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const glm::vec3 place = grid_.place(positions[i]);
      for (int axis = 0; axis < 3; ++axis)
        places[4 * i + axis] = static_cast<std::uint16_t>(place[axis]);
      places[4 * i + 3] = 0;
    }
    array.bounds = {grid_.place(array.bounds->minimum), grid_.place(array.bounds->maximum)};
    use(packed, bytes_of(places));
  } else {
    if (array.component != GltfComponent::Float) return use(packed, bytes);
    const auto numbers = values_in<float>(bytes);
    const bool fits =
        is_color(name) || (is_uv(name) && std::ranges::all_of(numbers, [](float number) {
                             return number >= 0 && number <= 1;
                           }));
    if (!fits) return use(packed, bytes);
    array.component = GltfComponent::UnsignedShort;
    array.normalized = true;
    use(packed, bytes_of(unit_shorts(numbers)));
  }
}

void Packer::compress(const std::string& name, std::span<const std::byte> bytes,
                      PackedArray& packed) {
  GltfArray& array = packed.array;
  GltfStream stream{.mode = "ATTRIBUTES"};
  const auto encode = [&](std::span<const std::byte> values) {
    array.bytes = values.size();
    packed.bytes = encode_vertices(values, values.size() / array.count);
  };
  const auto numbers = values_in<float>(bytes);
  if (array.component != GltfComponent::Float) {
    encode(bytes);
  } else if (is_direction(name)) {
    array.component = GltfComponent::Short;
    array.normalized = true;
    array.stride = 8;
    stream.filter = "OCTAHEDRAL";
    encode(bytes_of(octahedral(numbers, width_of(array))));
  } else if (is_color(name)) {
    array.component = GltfComponent::UnsignedShort;
    array.normalized = true;
    encode(bytes_of(unit_shorts(numbers)));
  } else if (name == "POSITION" && grid_.step > 0) {
    stream.filter = "EXPONENTIAL";
    encode(bytes_of(on_grid(placed(values_in<glm::vec3>(bytes)), 0)));
  } else if (const auto exponent = grid_exponent(numbers, is_uv(name) ? kUvError : 0)) {
    stream.filter = "EXPONENTIAL";
    encode(bytes_of(on_grid(numbers, *exponent)));
  } else {
    encode(bytes);
  }
  array.stream = stream;
}

// Numbers of places on the grid.
RawVector<float> Packer::placed(std::span<const glm::vec3> positions) const {
  RawVector<float> places(3 * positions.size());
  constexpr std::size_t kPlaceGrain = std::size_t{1} << 14;
  parallel_each(positions.size(), kPlaceGrain, [&](std::size_t i) {
    const glm::vec3 place = grid_.place(positions[i]);
    for (int axis = 0; axis < 3; ++axis) places[3 * i + axis] = place[axis];
  });
  return places;
}

// Positions as a reader has them, from the bytes of the file.
void Packer::note_decoded(PackedArray& packed, const GltfPart& part,
                          std::span<const std::uint32_t> order) {
  const auto count = static_cast<std::size_t>(packed.array.count);
  RawVector<glm::vec3> positions(count);
  if (packed.array.stream) {
    positions = packed.array.stream->filter == "NONE" ? decode_vectors(packed.bytes, count)
                                                      : decode_grid(packed.bytes, count);
    packed.array.bounds = bounds_of(positions);
  } else if (packed.array.component == GltfComponent::UnsignedShort) {
    const auto places = values_in<std::uint16_t>(packed.bytes);
    for (std::size_t i = 0; i < count; ++i)
      positions[i] = {places[4 * i], places[4 * i + 1], places[4 * i + 2]};
  } else {
    std::memcpy(positions.data(), packed.bytes.data(), packed.bytes.size());
  }
  const StoredPosition stored(options_);
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<std::size_t>(
        vertices_.row_of(part.first_vertex + static_cast<std::int64_t>(i)));
    if (row >= decoded_.size()) continue;
    const glm::vec3& position = positions[order.empty() ? i : order[i]];
    decoded_[row] = stored.unturn(payload_.translation + payload_.scale * glm::dvec3(position));
  }
}

void Packer::assemble() {
  std::uint64_t total = 0;
  for (const PackedArray& packed : packed_) total += padded(packed.bytes.size());
  RawVector<std::byte>& buffer = payload_.pieces.front();
  buffer = RawVector<std::byte>();  // the plain one goes first
  buffer.resize(total);
  std::byte* to = buffer.data();
  payload_.buffer_bytes = payload_.decoded_bytes = 0;
  for (std::size_t i = 0; i < packed_.size(); ++i) {
    PackedArray& packed = packed_[i];
    GltfArray& array = payload_.arrays[i] = packed.array;
    if (array.stream) {
      array.stream->offset = payload_.buffer_bytes;
      array.stream->bytes = packed.bytes.size();
      array.offset = payload_.decoded_bytes;
      payload_.decoded_bytes += padded(array.bytes);
    } else {
      array.offset = payload_.buffer_bytes;
    }
    const std::uint64_t size = padded(packed.bytes.size());
    std::memcpy(to, packed.bytes.data(), packed.bytes.size());
    std::fill(to + packed.bytes.size(), to + size, std::byte{0});
    payload_.buffer_bytes += size;
    to += size;
    packed.bytes = RawVector<std::byte>();
  }
}

}  // namespace

FloatBox bounds_of_all(const GltfPayload& payload) {
  FloatBox all;
  for (const GltfPrimitive& primitive : payload.primitives)
    all.add(*payload.arrays[primitive.attributes.at("POSITION")].bounds);
  return all;
}

GltfPayload pack_gltf(GltfPayload plain, const GltfVertices& vertices, const GltfOptions& options,
                      const FloatBox& bounds) {
  return Packer(std::move(plain), vertices, options, bounds)();
}

}  // namespace planish
