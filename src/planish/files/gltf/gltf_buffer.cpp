#include "planish/files/gltf/gltf_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_face_writer.h"
#include "planish/files/gltf/gltf_survey.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little endian");

// Rows or faces converted at once: about a MB of output, written while still in the cache.
constexpr std::int64_t kBufferRows = std::int64_t{1} << 16, kBufferFaces = std::int64_t{1} << 15;

// What of a row is written.
enum class Part { Position, Normal, Color };

// Writes the surface's rows, then those that seams have copied.
class RowWriter {
 public:
  RowWriter(const SurfaceBlocks& surface, const GltfVertices& vertices, const GltfOptions& options,
            std::span<const ByteSink> sinks)
      : surface_(surface),
        vertices_(vertices),
        stored_(options),
        origin_(options.origin),
        copied_(copied_rows(vertices)),
        sinks_(sinks) {
    if (vertices.kept_rows > 0) row_sinks_.assign(sinks.begin(), sinks.end());
  }

  template <class Vector>
  void write(Part part) {
    std::vector<Vector> copies(copied_.size());
    stream(
        sorted(surface_.row_blocks(kBufferRows)),
        [&](RowRange range, RawVector<std::byte>& bytes) {
          const auto values = values_of<Vector>(bytes, static_cast<std::size_t>(range.count));
          RowTarget target;
          target.origin = origin_;
          if constexpr (Vector::length() == 4) {
            target.colors = values;
          } else if (part == Part::Position) {
            target.stored = values;
          } else {
            target.normals = values;
          }
          (void)surface_.rows(range, target);
          for (Vector& value : values) value = finished(value);
          for (const CopiedRow& copy : copies_in(copied_, range)) {
            copies[copy.vertex - vertices_.kept_rows] = values[copy.row - range.first];
          }
        },
        row_sinks_);
    for (const ByteSink& sink : sinks_) sink(std::as_bytes(std::span(copies)));
  }

 private:
  [[nodiscard]] glm::vec3 finished(const glm::vec3& v) const { return stored_.turn(v); }
  [[nodiscard]] static glm::vec4 finished(const glm::vec4& color) {
    return glm::clamp(color, glm::vec4(0.0f), glm::vec4(1.0f));
  }

  const SurfaceBlocks& surface_;
  const GltfVertices& vertices_;
  StoredPosition stored_;
  glm::dvec3 origin_;
  std::vector<CopiedRow> copied_;
  std::span<const ByteSink> sinks_;
  std::vector<ByteSink> row_sinks_;  // empty where no row is kept
};

// The vertices of the primitives that have what is to be written.
template <class Has>
std::vector<RowRange> pieces_of(const GltfVertices& vertices, const Has& has) {
  std::vector<RowRange> pieces;
  for (const GltfPart& part : vertices.parts) {
    if (!has(part)) continue;
    for (RowRange piece : ranges_of(part.vertex_count, kBufferRows)) {
      piece.first += part.first_vertex;
      pieces.push_back(piece);
    }
  }
  return pieces;
}

// Calls take(i, value) with the first set's value of each texture coordinate in `uvs`. Neighbours
// mostly have near ones, so that nobody holds all of a surface.
template <class Take>
void for_each_uv(const SurfaceBlocks& surface, std::span<const std::int32_t> uvs,
                 const Take& take) {
  thread_local RawVector<glm::dvec2> values;
  for (std::size_t begin = 0, end = 0; begin < uvs.size(); begin = end) {
    std::int32_t first = uvs[begin], last = first;
    for (end = begin + 1; end < uvs.size(); ++end) {
      const std::int32_t least = std::min(first, uvs[end]), most = std::max(last, uvs[end]);
      if (std::int64_t{most} - least > 2 * static_cast<std::int64_t>(end - begin) + 16) break;
      first = least, last = most;
    }
    first = std::max(first, 0);
    values.resize(static_cast<std::size_t>(std::max(last + 1 - first, 0)));
    surface.uvs({first, std::ssize(values)}, values);
    for (std::size_t i = begin; i < end; ++i)
      take(i, uvs[i] < 0 ? glm::dvec2(0.0) : values[uvs[i] - first]);
  }
}

void write_uvs(const SurfaceBlocks& surface, const GltfVertices& vertices, int set,
               const GltfOptions& options, std::span<const ByteSink> sinks) {
  stream(
      pieces_of(vertices, [&](const GltfPart& part) { return part.uv_sets > set; }),
      [&](RowRange range, RawVector<std::byte>& bytes) {
        const auto values = values_of<glm::vec2>(bytes, static_cast<std::size_t>(range.count));
        const auto uvs =
            std::span(vertices.uvs).subspan(static_cast<std::size_t>(range.first), values.size());
        if (set == 0) {
          for_each_uv(surface, uvs,
                      [&](std::size_t i, const glm::dvec2& uv) { values[i] = stored_uv(uv); });
          return;
        }
        const auto& further = options.further_uvs[set - 1];
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = stored_uv(uvs[i] < 0 ? glm::dvec2(0.0) : further[uvs[i]]);
      },
      sinks);
}

template <class Number>
void write_attribute(const GltfVertices& vertices, const GltfAttribute& attribute,
                     std::span<const ByteSink> sinks) {
  const auto width = static_cast<std::size_t>(attribute.width);
  const std::size_t stride = attribute_bytes(attribute) / sizeof(Number);
  stream(
      pieces_of(vertices, [&](const GltfPart& part) { return attribute.is_in(part.group); }),
      [&](RowRange range, RawVector<std::byte>& bytes) {
        const auto values =
            values_of<Number>(bytes, stride * static_cast<std::size_t>(range.count));
        if (stride > width) std::ranges::fill(values, Number(0));
        for (std::int64_t i = 0; i < range.count; ++i) {
          const std::int64_t vertex = range.first + i;
          const std::int32_t uv = attribute.of_uvs ? vertices.uvs[vertex] : 0;
          const float* const from = attribute.numbers(uv, vertices.row_of(vertex));
          for (std::size_t k = 0; k < width; ++k)
            values[stride * static_cast<std::size_t>(i) + k] = static_cast<Number>(from[k]);
        }
      },
      sinks);
}

// Of the primitive that has most.
int uv_set_count(const GltfVertices& vertices) {
  int sets = 0;
  for (const GltfPart& part : vertices.parts) sets = std::max(sets, part.uv_sets);
  return sets;
}

// The format wants them of positions.
std::optional<GltfBounds> attribute_bounds(const GltfVertices& vertices, const GltfPart& part,
                                           const GltfAttribute& attribute) {
  if (!attribute.name.ends_with("/POSITION")) return std::nullopt;
  std::optional<GltfBounds> bounds;
  for (std::int64_t i = 0; i < part.vertex_count; ++i) {
    const float* at = attribute.values.data() + 3 * vertices.row_of(part.first_vertex + i);
    const glm::vec3 value(at[0], at[1], at[2]);
    if (!bounds) bounds = GltfBounds{value, value};
    bounds = GltfBounds{glm::min(bounds->minimum, value), glm::max(bounds->maximum, value)};
  }
  return bounds;
}

bool encodes_ngons(const GltfPart& part, const GltfOptions& options) {
  return !options.ngon_groups.empty() && options.ngon_groups[std::max(part.group, 0)] != 0;
}

// The face of a part that is written before one; -1: there is none.
std::int64_t face_before(const GltfPart& part, std::int64_t face) {
  std::int64_t before = -1;
  for (const RowRange& run : part.faces) {
    if (run.first >= face) break;
    before = std::min(run.first + run.count, face) - 1;
  }
  return before;
}

template <class Index>
void write_indices(const SurfaceBlocks& surface, const GltfVertices& vertices, const GltfPart& part,
                   bool is_of_ngons, std::span<const ByteSink> sinks) {
  std::vector<RowRange> pieces;
  for (const RowRange& run : part.faces) {
    for (RowRange piece : ranges_of(run.count, kBufferFaces)) {
      piece.first += run.first;
      pieces.push_back(piece);
    }
  }
  stream(
      pieces,
      [&](RowRange faces, RawVector<std::byte>& bytes) {
        FaceWriter<Index> write(surface, vertices);
        if (is_of_ngons) {
          write.ngons(faces, face_before(part, faces.first), bytes);
        } else {
          write(faces, bytes);
        }
      },
      sinks);
}

}  // namespace

GltfLayout gltf_layout(const SurfaceBlocks& surface, const GltfVertices& vertices,
                       const GltfOptions& options) {
  GltfLayout layout;
  layout.has_colors = surface.info().has_colors;
  layout.attributes = row_attributes(options);
  for (const GltfPart& part : vertices.parts) {
    const FaceGroup group = part.group < 0 ? FaceGroup{} : surface.info().groups[part.group];
    layout.primitives.push_back({.vertex_count = static_cast<std::uint64_t>(part.vertex_count),
                                 .triangle_count = part.triangle_count,
                                 .uv_sets = part.uv_sets,
                                 .name = group.name,
                                 .material = group.material,
                                 .group = part.group,
                                 .encodes_ngons = encodes_ngons(part, options),
                                 .bounds = {}});
    for (const GltfAttribute& attribute : layout.attributes)
      layout.primitives.back().bounds.push_back(attribute_bounds(vertices, part, attribute));
  }
  set_sizes(layout);
  return layout;
}

void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks) {
  const GltfLayout layout = gltf_layout(surface, vertices, options);
  LoopProgress progress(options.callbacks, "write", kGltfSurveyed, 1,
                        static_cast<std::int64_t>(layout.buffer_bytes));
  std::uint64_t written = 0;
  std::vector<ByteSink> all(sinks.begin(), sinks.end());
  all.push_back([&](std::span<const std::byte> bytes) {
    written += bytes.size();
    progress.add(std::ssize(bytes));
  });
  RowWriter rows(surface, vertices, options, all);
  rows.write<glm::vec3>(Part::Position);
  rows.write<glm::vec3>(Part::Normal);
  for (int set = 0; set < uv_set_count(vertices); ++set)
    write_uvs(surface, vertices, set, options, all);
  if (layout.has_colors) rows.write<glm::vec4>(Part::Color);
  for (const GltfAttribute& attribute : layout.attributes) {
    if (attribute.is_integer) {
      write_attribute<std::uint16_t>(vertices, attribute, all);
    } else {
      write_attribute<float>(vertices, attribute, all);
    }
  }
  const std::array<std::byte, 4> zeros{};
  for (std::size_t i = 0; i < vertices.parts.size(); ++i) {
    if (layout.primitives[i].index_size() == 2) {
      write_indices<std::uint16_t>(surface, vertices, vertices.parts[i],
                                   layout.primitives[i].encodes_ngons, all);
    } else {
      write_indices<std::uint32_t>(surface, vertices, vertices.parts[i],
                                   layout.primitives[i].encodes_ngons, all);
    }
    if (written % 4 == 0) continue;
    for (const ByteSink& sink : all) sink(std::span(zeros).first(4 - written % 4));
  }
}

}  // namespace planish
