#include "planish/files/gltf/gltf_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <string>

#include "planish/core/parallel.h"
#include "planish/files/gltf/stored_position.h"
#include "planish/files/gltf/triangulate.h"

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

// From an origin at the bottom left to glTF's at the top left.
glm::vec2 stored_uv(const glm::dvec2& uv) { return {uv.x, 1.0 - uv.y}; }

void require_faces(const SurfaceMesh& surface, const GltfOptions& options) {
  const auto& corners = surface.face_vertices;
  if (surface.face_count() < 1) refuse(options, "the surface has no face; glTF needs one");
  if (surface.face_offsets.empty()) {
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

void require_attributes(const SurfaceMesh& surface, const GltfOptions& options) {
  const auto require_size = [&](std::size_t size, std::size_t wanted, const std::string& what) {
    if (size != 0 && size != wanted)
      refuse(options, std::to_string(size) + " " + what + " where " + std::to_string(wanted) +
                          " are needed");
  };
  require_size(surface.face_uvs.size(), surface.face_vertices.size(), "corners of the texture");
  require_size(surface.colors.size(), surface.positions.size(), "colours");
  require_size(surface.face_groups.size(), static_cast<std::size_t>(surface.face_count()),
               "groups of faces");
  const auto require_indices = [&](std::span<const std::int32_t> indices, std::size_t count,
                                   const std::string& what) {
    const std::size_t wild = first_where(indices.size(), [&](std::size_t i) {
      return indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= count;
    });
    if (wild < indices.size())
      refuse(options,
             what + " " + std::to_string(wild) + " has number " + std::to_string(indices[wild]) +
                 " of " + std::to_string(count),
             static_cast<std::int64_t>(wild));
  };
  require_indices(surface.face_uvs, surface.uvs.size(), "the texture coordinate of corner");
  require_indices(surface.face_groups, surface.groups.size(), "the group of face");
  const auto require_finite = [&](std::size_t count, const auto& is_wrong,
                                  const std::string& what) {
    const std::size_t wild = first_where(count, is_wrong);
    if (wild < count)
      refuse(options, what + " " + std::to_string(wild) + " is not finite in float32",
             static_cast<std::int64_t>(wild));
  };
  require_finite(
      surface.uvs.size(),
      [&](std::size_t i) { return !is_finite(glm::vec3(stored_uv(surface.uvs[i]), 0.0f)); },
      "texture coordinate");
  require_finite(
      surface.colors.size(),
      [&](std::size_t i) {
        const glm::vec4& color = surface.colors[i];
        return !is_finite(glm::vec3(color)) || !std::isfinite(color.a);
      },
      "the colour of vertex");
}

// Sends value(0) to value(count - 1).
template <class Vector, class Value>
void write_vectors(std::size_t count, const Value& value, const ByteSink& sink) {
  static_assert(sizeof(Vector) == Vector::length() * sizeof(float));
  std::vector<Vector> piece(std::min(count, kPiece));
  for (std::size_t start = 0; start < count; start += kPiece) {
    const std::size_t length = std::min(kPiece, count - start);
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) piece[i] = value(start + i);
    });
    sink(std::as_bytes(std::span(piece.data(), length)));
  }
}

// Faces as a part of the file has them.
struct FaceRange {
  const SurfaceMesh& surface;
  const GltfVertices& vertices;
  std::size_t first, count;

  [[nodiscard]] std::size_t face(std::size_t i) const {
    return vertices.face_order.empty() ? first + i
                                       : static_cast<std::size_t>(vertices.face_order[first + i]);
  }
  // Vertices in the file, by corner.
  [[nodiscard]] std::span<const std::int32_t> corners() const {
    return vertices.corners.empty() ? std::span(surface.face_vertices)
                                    : std::span(vertices.corners);
  }
};

template <class Index>
void write_quads(const FaceRange& faces, const ByteSink& sink) {
  const auto& at = faces.surface.positions;
  std::vector<std::array<Index, 6>> piece(std::min(faces.count, kPiece));
  for (std::size_t start = 0; start < faces.count; start += kPiece) {
    const std::size_t length = std::min(kPiece, faces.count - start);
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t corner = 4 * faces.face(start + i);
        const std::int32_t* quad = faces.surface.face_vertices.data() + corner;
        const auto split = split_quad(at[quad[0]], at[quad[1]], at[quad[2]], at[quad[3]]);
        for (int k = 0; k < 6; ++k)
          piece[i][k] = static_cast<Index>(faces.corners()[corner + split[k]]);
      }
    });
    sink(std::as_bytes(std::span(piece.data(), length)));
  }
}

template <class Index>
void write_polygons(const FaceRange& faces, const ByteSink& sink) {
  const auto& offsets = faces.surface.face_offsets;
  std::vector<std::size_t> starts;  // of each face's indices in the piece
  std::vector<Index> piece;
  for (std::size_t start = 0; start < faces.count; start += kPiece) {
    const std::size_t length = std::min(kPiece, faces.count - start);
    starts.assign(1, 0);
    for (std::size_t i = start; i < start + length; ++i) {
      const std::size_t face = faces.face(i);
      starts.push_back(starts.back() + 3 * (offsets[face + 1] - offsets[face] - 2));
    }
    piece.resize(starts.back());
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<glm::dvec3> positions;
      std::vector<std::int32_t> numbers;
      std::vector<std::uint32_t> triangles;
      for (std::size_t i = begin; i < end; ++i) {
        // By number of the corner, because the file's vertex may be another than the surface's.
        const std::size_t first = offsets[faces.face(start + i)];
        const auto polygon = faces.surface.face(static_cast<std::int64_t>(faces.face(start + i)));
        positions.clear();
        for (const std::int32_t v : polygon) positions.push_back(faces.surface.positions[v]);
        numbers.resize(polygon.size());
        std::iota(numbers.begin(), numbers.end(), 0);
        triangles.resize(3 * (polygon.size() - 2));
        triangulate(numbers, positions, triangles);
        for (std::size_t k = 0; k < triangles.size(); ++k)
          piece[starts[i] + k] = static_cast<Index>(faces.corners()[first + triangles[k]]);
      }
    });
    sink(std::as_bytes(std::span(piece)));
  }
}

template <class Index>
void write_indices(const FaceRange& faces, const ByteSink& sink) {
  if (!faces.surface.face_offsets.empty()) {
    write_polygons<Index>(faces, sink);
  } else {
    write_quads<Index>(faces, sink);
  }
}

void write_attributes(const SurfaceMesh& surface, const GltfVertices& vertices,
                      const GltfOptions& options, const ByteSink& sink) {
  const StoredPosition stored(options);
  const std::size_t count = vertices.count(surface);
  const auto row = [&](std::size_t i) { return vertices.row(surface, i); };
  write_vectors<glm::vec3>(
      count, [&](std::size_t i) { return stored.store(surface.positions[row(i)]); }, sink);
  write_vectors<glm::vec3>(
      count, [&](std::size_t i) { return stored.turn(surface.normals[row(i)]); }, sink);
  if (!vertices.uvs.empty()) {
    write_vectors<glm::vec2>(
        count,
        [&](std::size_t i) {
          const std::int32_t uv = vertices.uvs[i];
          return stored_uv(uv < 0 ? glm::dvec2(0.0) : surface.uvs[uv]);
        },
        sink);
  }
  if (!surface.colors.empty()) {
    write_vectors<glm::vec4>(
        count,
        [&](std::size_t i) {
          return glm::clamp(surface.colors[row(i)], glm::vec4(0.0f), glm::vec4(1.0f));
        },
        sink);
  }
}

}  // namespace

void require_writable(const SurfaceMesh& surface, const GltfOptions& options) {
  if (surface.normals.size() != surface.positions.size()) {
    refuse(options, std::to_string(surface.normals.size()) + " normals for " +
                        std::to_string(surface.positions.size()) + " positions");
  }
  require_faces(surface, options);
  require_attributes(surface, options);
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

GltfLayout gltf_layout(const SurfaceMesh& surface, const GltfVertices& vertices) {
  GltfLayout layout;
  layout.vertex_count = vertices.count(surface);
  layout.has_uvs = !vertices.uvs.empty();
  layout.has_colors = !surface.colors.empty();
  for (const GltfPart& part : vertices.parts) {
    const FaceGroup group = part.group < 0 ? FaceGroup{} : surface.groups[part.group];
    layout.primitives.push_back({part.triangle_count, group.name, group.material});
  }
  set_sizes(layout);
  return layout;
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

void write_buffer(const SurfaceMesh& surface, const GltfVertices& vertices,
                  const GltfOptions& options, const ByteSink& sink) {
  const GltfLayout layout = gltf_layout(surface, vertices);
  std::uint64_t written = 0;
  const ByteSink counted = [&](std::span<const std::byte> bytes) {
    options.callbacks.check_cancelled();
    sink(bytes);
    written += bytes.size();
    options.callbacks.report(
        "write", static_cast<double>(written) / static_cast<double>(layout.buffer_bytes));
  };
  write_attributes(surface, vertices, options, counted);
  const std::array<std::byte, 4> zeros{};
  std::size_t first = 0;
  for (const GltfPart& part : vertices.parts) {
    const FaceRange faces{surface, vertices, first, static_cast<std::size_t>(part.face_count)};
    if (layout.index_size == 2) {
      write_indices<std::uint16_t>(faces, counted);
    } else {
      write_indices<std::uint32_t>(faces, counted);
    }
    if (written % 4 != 0) counted(std::span(zeros).first(4 - written % 4));
    first += faces.count;
  }
}

}  // namespace planish
