#include "planish/files/gltf/gltf_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <mutex>
#include <numeric>
#include <string>

#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/stored_position.h"
#include "planish/files/gltf/triangulate.h"

namespace planish {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little endian");

// Rows or faces converted at once: about a MB of output, written while still in the cache.
constexpr std::int64_t kBufferRows = std::int64_t{1} << 16, kBufferFaces = std::int64_t{1} << 15;

// As the Khronos validator allows.
constexpr float kUnitLengthTolerance = 5e-4f;

// The first row with a fault, whatever the threads do.
struct Fault {
  std::int64_t row = -1;
  bool is_position = false;
  float normal_length = 1;
  // Positions come before normals.
  [[nodiscard]] bool before(const Fault& other) const {
    if (other.row < 0 || row < 0) return row >= 0;
    return is_position != other.is_position ? is_position : row < other.row;
  }
};

struct Survey {
  GltfBounds bounds{};
  DegenerateRows degenerate;
  Fault fault;
  bool is_empty = true;

  void add(const Survey& other) {
    if (other.is_empty) return;
    bounds = is_empty ? other.bounds
                      : GltfBounds{glm::min(bounds.minimum, other.bounds.minimum),
                                   glm::max(bounds.maximum, other.bounds.maximum)};
    is_empty = false;
    degenerate.add(other.degenerate);
    if (other.fault.before(fault)) fault = other.fault;
  }
};

// One range of rows.
class Surveyor {
 public:
  Surveyor(const SurfaceBlocks& surface, const GltfOptions& options)
      : surface_(surface), stored_(options), origin_(options.origin) {}

  Survey operator()(RowRange range) {
    const auto count = static_cast<std::size_t>(range.count);
    positions_.resize(count);
    normals_.resize(count);
    RowTarget target;
    target.stored = positions_;
    target.normals = normals_;
    target.origin = origin_;
    Survey survey;
    survey.degenerate = surface_.rows(range, target);
    for (std::size_t i = 0; i < count; ++i) {
      const glm::vec3 position = stored_.turn(positions_[i]);
      const auto row = range.first + static_cast<std::int64_t>(i);
      if (!is_finite(position)) note({row, true}, survey);
      const float length = glm::length(normals_[i]);
      if (!(std::abs(length - 1.0f) <= kUnitLengthTolerance)) note({row, false, length}, survey);
      if (i == 0) survey.bounds = {position, position};
      survey.bounds = {glm::min(survey.bounds.minimum, position),
                       glm::max(survey.bounds.maximum, position)};
    }
    survey.is_empty = count == 0;
    return survey;
  }

 private:
  static void note(const Fault& fault, Survey& survey) {
    if (fault.before(survey.fault)) survey.fault = fault;
  }

  const SurfaceBlocks& surface_;
  StoredPosition stored_;
  glm::dvec3 origin_;
  RawVector<glm::vec3> positions_, normals_;
};

[[noreturn]] void refuse(const Fault& fault, const GltfOptions& options) {
  if (fault.is_position) {
    refuse_to_write(options,
                    "vertex " + std::to_string(fault.row) +
                        " has a coordinate that float32 cannot hold; scale the model down",
                    fault.row);
  }
  refuse_to_write(options,
                  "the normal of vertex " + std::to_string(fault.row) + " has length " +
                      std::to_string(fault.normal_length) + ", not 1",
                  fault.row);
}

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
        sinks_(sinks) {
    for (std::size_t i = 0; i < vertices.rows.size(); ++i) {
      copied_.emplace_back(vertices.rows[i], i);
    }
    std::sort(copied_.begin(), copied_.end());
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
          auto copy =
              std::lower_bound(copied_.begin(), copied_.end(),
                               std::pair{static_cast<std::int32_t>(range.first), std::size_t{0}});
          for (; copy != copied_.end() && copy->first < range.first + range.count; ++copy) {
            copies[copy->second] = values[static_cast<std::size_t>(copy->first - range.first)];
          }
        },
        sinks_);
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
  std::span<const ByteSink> sinks_;
  std::vector<std::pair<std::int32_t, std::size_t>> copied_;  // row, place among the copies
};

void write_uvs(const SurfaceBlocks& surface, const GltfVertices& vertices,
               std::span<const ByteSink> sinks) {
  std::vector<glm::dvec2> uvs(static_cast<std::size_t>(surface.info().uv_count));
  surface.uvs({0, surface.info().uv_count}, uvs);
  stream(
      ranges_of(vertices.count(surface), kBufferRows),
      [&](RowRange range, RawVector<std::byte>& bytes) {
        const auto values = values_of<glm::vec2>(bytes, static_cast<std::size_t>(range.count));
        for (std::size_t i = 0; i < values.size(); ++i) {
          const std::int32_t uv = vertices.uvs[static_cast<std::size_t>(range.first) + i];
          values[i] = stored_uv(uv < 0 ? glm::dvec2(0.0) : uvs[uv]);
        }
      },
      sinks);
}

void write_field(const SurfaceBlocks& surface, const GltfVertices& vertices,
                 const NamedField& field, std::span<const ByteSink> sinks) {
  const std::int64_t own = surface.info().row_count;
  stream(
      ranges_of(vertices.count(surface), kBufferRows),
      [&](RowRange range, RawVector<std::byte>& bytes) {
        const auto values = values_of<float>(bytes, static_cast<std::size_t>(range.count));
        for (std::int64_t i = 0; i < range.count; ++i) {
          const std::int64_t vertex = range.first + i;
          const std::int64_t row = vertex < own ? vertex : vertices.rows[vertex - own];
          values[i] = field.values[row];
        }
      },
      sinks);
}

// glTF wants an underscore before names of one's own, and capitals.
std::string attribute_name(const std::string& field) {
  std::string name = "_";
  for (const char c : field) name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

// The indices of a range of faces.
template <class Index>
class FaceWriter {
 public:
  FaceWriter(const SurfaceBlocks& surface, const GltfVertices& vertices)
      : surface_(surface), vertices_(vertices) {}

  void operator()(RowRange faces, RawVector<std::byte>& bytes) {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const std::int64_t last = info.first_corner(faces.first + faces.count);
    take_corners(faces, static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
    const auto triangles = static_cast<std::size_t>(last - first - 2 * faces.count);
    Index* to = values_of<Index>(bytes, 3 * triangles).data();
    for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
      const auto begin = static_cast<std::size_t>(info.first_corner(f) - first);
      const auto end = static_cast<std::size_t>(info.first_corner(f + 1) - first);
      to = end - begin == 4 ? quad(begin, to) : polygon(begin, end - begin, to);
    }
  }

 private:
  void take_corners(RowRange faces, std::size_t first, std::size_t count) {
    positions_.resize(count);
    normals_.resize(count);
    surface_.corners(faces, positions_, normals_);
    if (!vertices_.corners.empty()) {
      corners_ = std::span(vertices_.corners).subspan(first, count);
      return;
    }
    rows_.resize(count);
    surface_.face_vertices(faces, rows_);
    corners_ = rows_;
  }

  Index* quad(std::size_t at, Index* to) const {
    const glm::dvec3* p = positions_.data() + at;
    for (const std::uint8_t k : split_quad(p[0], p[1], p[2], p[3])) {
      *to++ = static_cast<Index>(corners_[at + k]);
    }
    return to;
  }

  Index* polygon(std::size_t at, std::size_t size, Index* to) {
    numbers_.resize(size);
    std::iota(numbers_.begin(), numbers_.end(), 0);
    triangles_.resize(3 * (size - 2));
    triangulate(numbers_, std::span<const glm::dvec3>(positions_).subspan(at, size), triangles_);
    for (const std::uint32_t k : triangles_) *to++ = static_cast<Index>(corners_[at + k]);
    return to;
  }

  const SurfaceBlocks& surface_;
  const GltfVertices& vertices_;
  RawVector<glm::dvec3> positions_;
  RawVector<glm::vec3> normals_;
  RawVector<std::int32_t> rows_;
  std::span<const std::int32_t> corners_;
  std::vector<std::int32_t> numbers_;
  std::vector<std::uint32_t> triangles_;
};

template <class Index>
void write_indices(const SurfaceBlocks& surface, const GltfVertices& vertices, const GltfPart& part,
                   std::span<const ByteSink> sinks) {
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
        FaceWriter<Index>(surface, vertices)(faces, bytes);
      },
      sinks);
}

}  // namespace

GltfLayout gltf_layout(const SurfaceBlocks& surface, const GltfVertices& vertices,
                       const GltfOptions& options) {
  GltfLayout layout;
  layout.vertex_count = static_cast<std::uint64_t>(vertices.count(surface));
  layout.has_uvs = !vertices.uvs.empty();
  layout.has_colors = surface.info().has_colors;
  for (const NamedField& field : options.fields)
    layout.fields.push_back(attribute_name(field.name));
  for (const GltfPart& part : vertices.parts) {
    const FaceGroup group = part.group < 0 ? FaceGroup{} : surface.info().groups[part.group];
    layout.primitives.push_back({part.triangle_count, group.name, group.material});
  }
  set_sizes(layout);
  return layout;
}

GltfBounds gltf_bounds(const SurfaceBlocks& surface, const GltfOptions& options) {
  const std::vector<RowRange> pieces = surface.row_blocks(kBufferRows);
  Survey all;
  std::mutex mutex;
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    Surveyor survey(surface, options);
    for (std::size_t i = begin; i < end; ++i) {
      options.callbacks.check_cancelled();
      const Survey part = survey(pieces[i]);
      const std::lock_guard lock(mutex);
      all.add(part);
    }
  });
  if (all.fault.row >= 0) refuse(all.fault, options);
  warn_of(all.degenerate, options.callbacks);
  return all.bounds;
}

void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks) {
  const GltfLayout layout = gltf_layout(surface, vertices, options);
  std::uint64_t written = 0;
  std::vector<ByteSink> all(sinks.begin(), sinks.end());
  all.push_back([&](std::span<const std::byte> bytes) {
    options.callbacks.check_cancelled();
    written += bytes.size();
    options.callbacks.report(
        "write", static_cast<double>(written) / static_cast<double>(layout.buffer_bytes));
  });
  RowWriter rows(surface, vertices, options, all);
  rows.write<glm::vec3>(Part::Position);
  rows.write<glm::vec3>(Part::Normal);
  if (layout.has_uvs) write_uvs(surface, vertices, all);
  if (layout.has_colors) rows.write<glm::vec4>(Part::Color);
  for (const NamedField& field : options.fields) write_field(surface, vertices, field, all);
  const std::array<std::byte, 4> zeros{};
  for (const GltfPart& part : vertices.parts) {
    if (layout.index_size == 2) {
      write_indices<std::uint16_t>(surface, vertices, part, all);
    } else {
      write_indices<std::uint32_t>(surface, vertices, part, all);
    }
    if (written % 4 == 0) continue;
    for (const ByteSink& sink : all) sink(std::span(zeros).first(4 - written % 4));
  }
}

}  // namespace planish
