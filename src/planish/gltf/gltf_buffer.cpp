#include "planish/gltf/gltf_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>

#include "planish/core/parallel.h"
#include "planish/gltf/stored_position.h"
#include "planish/gltf/triangulate.h"

namespace planish {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little endian");

// Vertices or faces converted at once: a few MB of output, written while still in the cache.
constexpr std::size_t kPiece = std::size_t{1} << 17;
constexpr std::size_t kGrain = std::size_t{1} << 13;

// As the Khronos validator allows.
constexpr float kUnitLengthTolerance = 5e-4f;

// Smallest i with wrong(i), whatever the threads do; count if there is none.
template <class Predicate>
std::size_t first_where(std::size_t count, const Predicate& wrong) {
  const std::size_t block_count = (count + kGrain - 1) / kGrain;
  std::vector<std::size_t> first(block_count, count);
  parallel_for(block_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) {
      const std::size_t stop = std::min(count, (block + 1) * kGrain);
      for (std::size_t i = block * kGrain; i < stop; ++i) {
        if (!wrong(i)) continue;
        first[block] = i;
        break;
      }
    }
  });
  return first.empty() ? count : *std::min_element(first.begin(), first.end());
}

[[noreturn]] void refuse(const GltfOptions& options, const std::string& what,
                         std::int64_t element = Error::kNoElement) {
  throw Error(ErrorCode::InvalidArgument, options.name + ": " + what, element);
}

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void require_faces(const SurfaceMesh& surface, const GltfOptions& options) {
  const auto& corners = surface.face_vertices;
  if (surface.face_count() < 1) refuse(options, "the surface has no face; glTF needs one");
  if (surface.level != 0) {
    if (corners.size() % 4 != 0) refuse(options, "the number of quad corners is no multiple of 4");
  } else {
    const auto& offsets = surface.face_offsets;
    const auto face_count = static_cast<std::size_t>(surface.face_count());
    const std::size_t small = first_where(face_count, [&](std::size_t f) {
      return offsets[f] < 0 || offsets[f + 1] - 3 < offsets[f];
    });
    if (small < face_count) {
      refuse(options, "face " + std::to_string(small) + " has fewer than 3 corners",
             static_cast<std::int64_t>(small));
    }
    if (offsets.front() != 0 || static_cast<std::size_t>(offsets.back()) != corners.size()) {
      refuse(options, "the face offsets do not span the face corners");
    }
  }
  const auto vertex_count = static_cast<std::int64_t>(surface.positions.size());
  const std::size_t wild = first_where(
      corners.size(), [&](std::size_t i) { return corners[i] < 0 || corners[i] >= vertex_count; });
  if (wild < corners.size()) {
    refuse(options,
           "face corner " + std::to_string(wild) + " names vertex " +
               std::to_string(corners[wild]) + " of " + std::to_string(vertex_count),
           static_cast<std::int64_t>(wild));
  }
}

// Sends value(0) to value(count - 1).
template <class Value>
void write_vectors(std::size_t count, const Value& value, const ByteSink& sink) {
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  std::vector<glm::vec3> piece(std::min(count, kPiece));
  for (std::size_t start = 0; start < count; start += kPiece) {
    const std::size_t length = std::min(kPiece, count - start);
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) piece[i] = value(start + i);
    });
    sink(std::as_bytes(std::span(piece.data(), length)));
  }
}

template <class Index>
void write_quads(const SurfaceMesh& surface, const ByteSink& sink) {
  const auto face_count = static_cast<std::size_t>(surface.face_count());
  std::vector<std::array<Index, 6>> piece(std::min(face_count, kPiece));
  for (std::size_t start = 0; start < face_count; start += kPiece) {
    const std::size_t length = std::min(kPiece, face_count - start);
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::int32_t* quad = surface.face_vertices.data() + 4 * (start + i);
        const auto& at = surface.positions;
        const auto split = split_quad(at[quad[0]], at[quad[1]], at[quad[2]], at[quad[3]]);
        for (int k = 0; k < 6; ++k) piece[i][k] = static_cast<Index>(quad[split[k]]);
      }
    });
    sink(std::as_bytes(std::span(piece.data(), length)));
  }
}

template <class Index>
void write_polygons(const SurfaceMesh& surface, const ByteSink& sink) {
  const auto face_count = static_cast<std::size_t>(surface.face_count());
  const auto& offsets = surface.face_offsets;
  // Indices of the triangles before a face.
  const auto index_offset = [&](std::size_t face) {
    return 3 * (static_cast<std::size_t>(offsets[face]) - 2 * face);
  };
  std::vector<std::uint32_t> wide;
  std::vector<Index> piece;
  for (std::size_t start = 0; start < face_count; start += kPiece) {
    const std::size_t stop = std::min(face_count, start + kPiece);
    const std::size_t base = index_offset(start);
    wide.resize(index_offset(stop) - base);
    parallel_for(stop - start, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = start + begin; f < start + end; ++f) {
        const std::size_t size = offsets[f + 1] - offsets[f];
        triangulate(std::span(surface.face_vertices).subspan(offsets[f], size), surface.positions,
                    std::span(wide).subspan(index_offset(f) - base, 3 * (size - 2)));
      }
    });
    piece.assign(wide.begin(), wide.end());
    sink(std::as_bytes(std::span(piece)));
  }
}

template <class Index>
void write_indices(const SurfaceMesh& surface, const ByteSink& sink) {
  if (surface.level == 0) {
    write_polygons<Index>(surface, sink);
  } else {
    write_quads<Index>(surface, sink);
  }
}

}  // namespace

void require_writable(const SurfaceMesh& surface, const GltfOptions& options) {
  if (surface.normals.size() != surface.positions.size()) {
    refuse(options, std::to_string(surface.normals.size()) + " normals for " +
                        std::to_string(surface.positions.size()) + " positions");
  }
  require_faces(surface, options);
  const StoredPosition stored(options);
  const std::size_t count = surface.positions.size();
  const std::size_t wild = first_where(
      count, [&](std::size_t i) { return !is_finite(stored.store(surface.positions[i])); });
  if (wild < count) {
    refuse(options,
           "vertex " + std::to_string(wild) +
               " has a coordinate that float32 cannot hold; scale the model down",
           static_cast<std::int64_t>(wild));
  }
  const std::size_t skewed = first_where(count, [&](std::size_t i) {
    const float length = glm::length(surface.normals[i]);
    return !(std::abs(length - 1.0f) <= kUnitLengthTolerance);
  });
  if (skewed < count) {
    refuse(options,
           "the normal of vertex " + std::to_string(skewed) + " has length " +
               std::to_string(glm::length(surface.normals[skewed])) + ", not 1",
           static_cast<std::int64_t>(skewed));
  }
}

GltfLayout gltf_layout(const SurfaceMesh& surface) {
  const auto face_count = static_cast<std::uint64_t>(surface.face_count());
  return gltf_layout(surface.positions.size(), surface.face_vertices.size() - 2 * face_count);
}

GltfBounds gltf_bounds(const SurfaceMesh& surface, const GltfOptions& options) {
  const StoredPosition stored(options);
  const std::size_t count = surface.positions.size();
  const glm::vec3 first = stored.store(surface.positions.at(0));
  std::vector<GltfBounds> blocks((count + kGrain - 1) / kGrain, {first, first});
  parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * kGrain; i < std::min(count, end * kGrain); ++i) {
      const glm::vec3 position = stored.store(surface.positions[i]);
      GltfBounds& block = blocks[i / kGrain];
      block = {glm::min(block.minimum, position), glm::max(block.maximum, position)};
    }
  });
  GltfBounds all = blocks.front();
  for (const GltfBounds& block : blocks) {
    all = {glm::min(all.minimum, block.minimum), glm::max(all.maximum, block.maximum)};
  }
  return all;
}

void write_buffer(const SurfaceMesh& surface, const GltfOptions& options, const ByteSink& sink) {
  const GltfLayout layout = gltf_layout(surface);
  const StoredPosition stored(options);
  std::uint64_t written = 0;
  const ByteSink counted = [&](std::span<const std::byte> bytes) {
    options.callbacks.check_cancelled();
    sink(bytes);
    written += bytes.size();
    options.callbacks.report(
        "write", static_cast<double>(written) / static_cast<double>(layout.buffer_bytes));
  };
  write_vectors(
      surface.positions.size(), [&](std::size_t i) { return stored.store(surface.positions[i]); },
      counted);
  write_vectors(
      surface.normals.size(), [&](std::size_t i) { return stored.turn(surface.normals[i]); },
      counted);
  if (layout.index_size == 2) {
    write_indices<std::uint16_t>(surface, counted);
  } else {
    write_indices<std::uint32_t>(surface, counted);
  }
  const std::array<std::byte, 4> zeros{};
  if (written < layout.buffer_bytes) {
    counted(std::span(zeros).first(layout.buffer_bytes - written));
  }
}

}  // namespace planish
