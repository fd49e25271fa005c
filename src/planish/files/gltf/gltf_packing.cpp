#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

constexpr double kMostShort = 65535;
constexpr double kMostMantissas = 2.0 * ((1 << 23) - 1);  // with a sign
// A node's translation that is within this of zero everywhere is left out by glTF-Transform, and by
// what is built on it.
constexpr double kLeastTranslation = 1e-5;

double extent_of(const FloatBox& all) {
  const glm::dvec3 sides = glm::dvec3(all.maximum) - glm::dvec3(all.minimum);
  return std::max({sides.x, sides.y, sides.z});
}

PositionGrid placed_grid(const FloatBox& all, const GltfOptions& options) {
  const glm::dvec3 least(all.minimum), sides = glm::dvec3(all.maximum) - least;
  const bool packs = options.compression == GltfCompression::Meshopt;
  if (options.grid_step > 0) {
    if (packs) return {glm::dvec3(0.0), options.grid_step};
    const double reach = std::ldexp(options.grid_step, 15);
    const bool fits = glm::all(glm::greaterThanEqual(least, glm::dvec3(-reach))) &&
                      glm::all(glm::lessThan(glm::dvec3(all.maximum), glm::dvec3(reach)));
    return fits ? PositionGrid{glm::dvec3(-reach), options.grid_step} : PositionGrid{};
  }
  const double extent = extent_of(all);
  const double coarsest = coarsest_step(options.position_error);
  const double step = packs ? coarsest : extent / kMostShort;
  if (!(step > 0) || step > coarsest || extent > kMostMantissas * step) return {};
  return {packs ? least + 0.5 * sides : least, step};
}

bool is_dropped(const glm::dvec3& translation) {
  return glm::all(glm::lessThanEqual(glm::abs(translation), glm::dvec3(kLeastTranslation)));
}

}  // namespace

double coarsest_step(double error) { return 2 / std::sqrt(3.0) * error; }

// Where its place would be lost the grid lies about zero: 16 bits, which have no sign, do not do
// then.
PositionGrid position_grid(const FloatBox& all, const GltfOptions& options) {
  const PositionGrid grid = placed_grid(all, options);
  if (grid.origin == glm::dvec3(0.0) || !is_dropped(grid.origin) || !is_dropped(options.origin))
    return grid;
  const glm::vec3 farthest = glm::max(glm::abs(all.minimum), glm::abs(all.maximum));
  const double reach = std::max({farthest.x, farthest.y, farthest.z});
  const bool fits =
      options.compression == GltfCompression::Meshopt && 2 * reach <= kMostMantissas * grid.step;
  return fits ? PositionGrid{.step = grid.step} : PositionGrid{};
}

void tell_kept_float(const GltfOptions& options, const FloatBox& bounds) {
  if (!options.kept_float || options.compression != GltfCompression::Quantize ||
      position_grid(bounds, options).step > 0)
    return;
  const bool is_for_place = placed_grid(bounds, options).step > 0;
  options.kept_float(is_for_place ? 0 : std::sqrt(3.0) / 2 * extent_of(bounds) / kMostShort);
}

namespace {

// Based on: Khronos, "EXT_meshopt_compression", 2021; A. Kapoulkine, "meshoptimizer", 2017-2022.

constexpr std::size_t kNumberGrain = std::size_t{1} << 14;
constexpr int kMantissaBits = 23;  // and a sign
constexpr int kLeastExponent = -100, kMostExponent = 100;
constexpr int kNormalBits = 14;

// Strips this long turn back before the codec, which packs 16 neighbours together, has forgotten
// what lies beside them: of 512 to 2^18 triangles the goblet is smallest with these.
constexpr std::int64_t kBlockTriangles = 2048;
constexpr std::uint32_t kNotYet = std::numeric_limits<std::uint32_t>::max();

// Numbers the vertices of a block by themselves, since the optimiser takes time and memory by them.
class BlockOrder {
 public:
  void operator()(std::span<const std::uint32_t> from, std::span<std::uint32_t> to) {
    slots_.assign(kSlots, kNotYet);
    vertices_.clear();
    corners_.resize(from.size());
    ordered_.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) corners_[i] = local(from[i]);
    meshopt_optimizeVertexCacheStrip(ordered_.data(), corners_.data(), corners_.size(),
                                     vertices_.size());
    std::ranges::transform(ordered_, to.begin(), [&](std::uint32_t v) { return vertices_[v]; });
  }

 private:
  // More than twice as many as corners.
  static constexpr int kSlotBits = 14;
  static constexpr std::size_t kSlots = std::size_t{1} << kSlotBits;
  static_assert(kSlots > 6 * kBlockTriangles);

  std::uint32_t local(std::uint32_t vertex) {
    constexpr std::uint32_t kGolden = 0x9e3779b9;
    std::size_t slot = vertex * kGolden >> (32 - kSlotBits);
    while (slots_[slot] != kNotYet && vertices_[slots_[slot]] != vertex) slot = (slot + 1) % kSlots;
    if (slots_[slot] == kNotYet) {
      slots_[slot] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
    }
    return slots_[slot];
  }

  RawVector<std::uint32_t> corners_, ordered_;
  std::vector<std::uint32_t> slots_, vertices_;
};

}  // namespace

std::optional<int> grid_exponent(std::span<const float> numbers, double error) {
  if (!(error > 0)) return std::nullopt;
  // Half a step in each of three directions.
  const double step = error * 2 / std::sqrt(3.0);
  if (!(step > std::ldexp(1.0, kLeastExponent))) return std::nullopt;
  const int exponent = std::min(std::ilogb(step), kMostExponent);
  double largest = 0;
  for (const float number : numbers)
    largest = std::max(largest, std::abs(static_cast<double>(number)));
  const double most = std::ldexp(1.0, kMantissaBits) - 1;
  if (largest / std::ldexp(1.0, exponent) > most) return std::nullopt;
  return exponent;
}

RawVector<std::uint32_t> on_grid(std::span<const float> numbers, int exponent) {
  RawVector<std::uint32_t> words(numbers.size());
  const double scale = std::ldexp(1.0, -exponent);
  const std::uint32_t high = static_cast<std::uint32_t>(static_cast<std::uint8_t>(exponent)) << 24;
  parallel_each(numbers.size(), kNumberGrain, [&](std::size_t i) {
    const auto mantissa = static_cast<std::int32_t>(std::lround(numbers[i] * scale));
    words[i] = high | (static_cast<std::uint32_t>(mantissa) & 0xffffffu);
  });
  return words;
}

RawVector<std::int16_t> octahedral(std::span<const float> vectors, std::size_t width) {
  const std::size_t count = vectors.size() / width;
  RawVector<std::int16_t> packed(4 * count);
  parallel_for(count, kNumberGrain, [&](std::size_t begin, std::size_t end) {
    RawVector<float> wide(4 * (end - begin));
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = 0; k < 4; ++k)
        wide[4 * (i - begin) + k] = k < width ? vectors[width * i + k] : 0;
    }
    meshopt_encodeFilterOct(packed.data() + 4 * begin, end - begin, 8, kNormalBits, wide.data());
  });
  return packed;
}

RawVector<std::int16_t> short_vectors(std::span<const float> vectors, std::size_t width) {
  const std::size_t count = vectors.size() / width;
  RawVector<std::int16_t> packed(4 * count);
  parallel_each(count, kNumberGrain, [&](std::size_t i) {
    for (std::size_t k = 0; k < 4; ++k) {
      const float value = k < width ? vectors[width * i + k] : 0;
      packed[4 * i + k] =
          static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 32767));
    }
  });
  return packed;
}

RawVector<std::uint16_t> unit_shorts(std::span<const float> numbers) {
  RawVector<std::uint16_t> packed(numbers.size());
  parallel_each(numbers.size(), kNumberGrain, [&](std::size_t i) {
    packed[i] = static_cast<std::uint16_t>(std::lround(std::clamp(numbers[i], 0.0f, 1.0f) * 65535));
  });
  return packed;
}

RawVector<std::byte> encode_vertices(std::span<const std::byte> vertices, std::size_t size) {
  const std::size_t count = vertices.size() / size;
  RawVector<std::byte> encoded(meshopt_encodeVertexBufferBound(count, size));
  encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                            encoded.size(), vertices.data(), count, size));
  PLANISH_ASSERT(!encoded.empty());
  return encoded;
}

RawVector<std::byte> encode_triangles(std::span<const std::uint32_t> indices,
                                      std::size_t vertex_count) {
  RawVector<std::byte> encoded(meshopt_encodeIndexBufferBound(indices.size(), vertex_count));
  encoded.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                           encoded.size(), indices.data(), indices.size()));
  PLANISH_ASSERT(!encoded.empty());
  return encoded;
}

RawVector<glm::vec3> decode_vectors(std::span<const std::byte> encoded, std::size_t count) {
  RawVector<glm::vec3> decoded(count);
  const int failed = meshopt_decodeVertexBuffer(
      decoded.data(), count, sizeof(glm::vec3),
      reinterpret_cast<const unsigned char*>(encoded.data()), encoded.size());
  PLANISH_ASSERT(failed == 0);
  return decoded;
}

RawVector<glm::vec3> decode_grid(std::span<const std::byte> encoded, std::size_t count) {
  RawVector<glm::vec3> decoded = decode_vectors(encoded, count);
  meshopt_decodeFilterExp(decoded.data(), count, sizeof(glm::vec3));
  return decoded;
}

StripOrder strip_order(std::span<const std::uint32_t> indices, std::size_t vertex_count) {
  StripOrder order;
  order.indices.resize(indices.size());
  const std::vector<RowRange> blocks =
      ranges_of(static_cast<std::int64_t>(indices.size() / 3), kBlockTriangles);
  parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    BlockOrder reorder;
    for (std::size_t i = begin; i < end; ++i) {
      const auto first = static_cast<std::size_t>(3 * blocks[i].first);
      const auto count = static_cast<std::size_t>(3 * blocks[i].count);
      reorder(indices.subspan(first, count), std::span(order.indices).subspan(first, count));
    }
  });
  order.new_vertices.assign(vertex_count, kNotYet);
  std::uint32_t next = 0;
  for (std::uint32_t& index : order.indices) {
    std::uint32_t& vertex = order.new_vertices[index];
    if (vertex == kNotYet) vertex = next++;
    index = vertex;
  }
  for (std::uint32_t& vertex : order.new_vertices)
    if (vertex == kNotYet) vertex = next++;
  return order;
}

namespace {

// Based on: Khronos, "KHR_mesh_quantization", 2020, and "EXT_meshopt_compression", 2021.

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
