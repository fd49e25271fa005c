// Based on: Khronos, "EXT_meshopt_compression", 2021; A. Kapoulkine, "meshoptimizer", 2017-2022.
#include "planish/files/gltf/packed_numbers.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

constexpr std::size_t kNumberGrain = std::size_t{1} << 14;
constexpr int kMantissaBits = 23;  // and a sign
constexpr int kLeastExponent = -100, kMostExponent = 100;
constexpr int kNormalBits = 14;

// Strips this long turn back before the codec, which packs 16 neighbours together, has forgotten
// what lies beside them: of 512 to 2^18 triangles the goblet is smallest with these.
constexpr std::int64_t kBlockTriangles = 2048;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Numbers the vertices of a block by themselves, since the optimiser takes time and memory by them.
class BlockOrder {
 public:
  void operator()(std::span<const std::uint32_t> from, std::span<std::uint32_t> to) {
    slots_.assign(kSlots, kNone);
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
    while (slots_[slot] != kNone && vertices_[slots_[slot]] != vertex) slot = (slot + 1) % kSlots;
    if (slots_[slot] == kNone) {
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
  order.new_vertices.assign(vertex_count, kNone);
  std::uint32_t next = 0;
  for (std::uint32_t& index : order.indices) {
    std::uint32_t& vertex = order.new_vertices[index];
    if (vertex == kNone) vertex = next++;
    index = vertex;
  }
  for (std::uint32_t& vertex : order.new_vertices)
    if (vertex == kNone) vertex = next++;
  return order;
}

}  // namespace planish
