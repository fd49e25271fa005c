// Based on: Khronos, "glTF 2.0 Specification", 2021, section 3.6.
#include "planish/files/gltf/gltf_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
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

// Attributes in the order in which they are written.
struct Attribute {
  std::string name;
  std::string_view type;
  std::uint64_t bytes;  // of a vertex
  GltfComponent component = GltfComponent::Float;
  int uv_sets = 0;  // that a part has which has it
  const GltfAttribute* given = nullptr;

  [[nodiscard]] bool belongs_to(const GltfPart& part) const {
    return uv_sets <= part.uv_sets && (given == nullptr || given->is_in(part.group));
  }
};

// Of a vertex, a multiple of 4.
std::uint64_t attribute_bytes(const GltfAttribute& attribute) {
  return padded(static_cast<std::uint64_t>(attribute.width) * (attribute.is_integer ? 2 : 4));
}

std::string_view type_name(int width) {
  constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  return kTypes[width - 1];
}

// Of the primitive that has most.
int uv_set_count(const GltfVertices& vertices) {
  int sets = 0;
  for (const GltfPart& part : vertices.parts) sets = std::max(sets, part.uv_sets);
  return sets;
}

std::vector<Attribute> attributes_of(const SurfaceInfo& info, const GltfVertices& vertices,
                                     std::span<const GltfAttribute> further) {
  std::vector<Attribute> attributes{{"POSITION", "VEC3", 12}, {"NORMAL", "VEC3", 12}};
  for (int set = 0; set < uv_set_count(vertices); ++set)
    attributes.push_back({.name = uv_name(set), .type = "VEC2", .bytes = 8, .uv_sets = set + 1});
  if (info.has_colors) attributes.push_back({"COLOR_0", "VEC4", 16});
  for (const GltfAttribute& attribute : further)
    attributes.push_back(
        {.name = attribute.name,
         .type = type_name(attribute.width),
         .bytes = attribute_bytes(attribute),
         .component = attribute.is_integer ? GltfComponent::UnsignedShort : GltfComponent::Float,
         .given = &attribute});
  return attributes;
}

// glTF wants an underscore before names of one's own, and capitals.
std::string own_name(const std::string& field) {
  std::string name = "_";
  for (const char c : field) name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

bool encodes_ngons(const GltfPart& part, const GltfOptions& options) {
  return !options.ngon_groups.empty() && options.ngon_groups[std::max(part.group, 0)] != 0;
}

// 2 or 4.
std::uint32_t index_size(const GltfPart& part) {
  return static_cast<std::uint64_t>(part.vertex_count) <= kMaxShortIndexVertices ? 2 : 4;
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

// Of all vertices of a part.
FloatBox target_bounds(const GltfVertices& vertices, const GltfPart& part,
                       const GltfAttribute& target) {
  FloatBox bounds;
  for (std::int64_t i = 0; i < part.vertex_count; ++i) {
    const float* at = target.values.data() + 3 * vertices.row_of(part.first_vertex + i);
    bounds.add(glm::vec3(at[0], at[1], at[2]));
  }
  return bounds;
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

const float* GltfAttribute::numbers(std::int32_t uv, std::int64_t row) const {
  if (!of_uvs) return values.data() + width * row;
  if (!further.empty()) {
    const UvOnRow place{uv, static_cast<std::int32_t>(row)};
    const auto found = std::ranges::lower_bound(further, place);
    if (found != further.end() && *found == place)
      return further_values.data() + width * (found - further.begin());
  }
  return values.data() + width * std::max(uv, 0);  // no corner names a vertex without one
}

int uv_set(std::string_view attribute) {
  constexpr std::string_view kUvs = "TEXCOORD_";
  if (!attribute.starts_with(kUvs)) return -1;
  int set = -1;
  const char* const end = attribute.data() + attribute.size();
  const auto read = std::from_chars(attribute.data() + kUvs.size(), end, set);
  return read.ptr == end ? set : -1;
}

std::vector<GltfAttribute> row_attributes(const GltfOptions& options) {
  std::vector<GltfAttribute> all;
  for (const NamedField& field : options.fields)
    all.push_back({.name = own_name(field.name), .width = field.width, .values = field.values});
  all.insert(all.end(), options.attributes.begin(), options.attributes.end());
  return all;
}

GltfPayload plain_payload(const SurfaceInfo& info, const GltfVertices& vertices,
                          const GltfOptions& options) {
  GltfPayload payload;
  payload.translation = StoredPosition(options).translation();
  const auto add = [&](GltfArray array) {
    array.offset = payload.buffer_bytes;
    payload.buffer_bytes += padded(array.bytes);
    payload.arrays.push_back(array);
    return payload.arrays.size() - 1;
  };
  payload.primitives.resize(vertices.parts.size());
  const std::vector<GltfAttribute> further = row_attributes(options);
  for (const Attribute& attribute : attributes_of(info, vertices, further)) {
    for (std::size_t i = 0; i < vertices.parts.size(); ++i) {
      if (!attribute.belongs_to(vertices.parts[i])) continue;
      const auto count = static_cast<std::uint64_t>(vertices.parts[i].vertex_count);
      GltfArray array{.type = attribute.type,
                      .component = attribute.component,
                      .count = count,
                      .bytes = attribute.bytes * count};
      // Bytes that are skipped.
      if (attribute.given != nullptr && attribute.given->is_integer &&
          attribute.given->width % 2 != 0)
        array.stride = static_cast<std::uint32_t>(attribute.bytes);
      payload.primitives[i].attributes[attribute.name] = add(array);
    }
  }
  for (std::size_t i = 0; i < vertices.parts.size(); ++i) {
    const GltfPart& part = vertices.parts[i];
    GltfPrimitive& primitive = payload.primitives[i];
    const std::uint64_t index_count = 3 * part.triangle_count;
    primitive.indices = add({.type = "SCALAR",
                             .component = index_size(part) == 2 ? GltfComponent::UnsignedShort
                                                                : GltfComponent::UnsignedInt,
                             .count = index_count,
                             .is_indices = true,
                             .bytes = index_size(part) * index_count});
    if (part.group >= 0) {
      primitive.name = info.groups[part.group].name;
      primitive.material = info.groups[part.group].material;
    }
    primitive.group = part.group;
    primitive.encodes_ngons = encodes_ngons(part, options);
    payload.vertex_count += static_cast<std::uint64_t>(part.vertex_count);
    payload.triangle_count += part.triangle_count;
  }
  return payload;
}

void set_bounds(GltfPayload& payload, std::span<const FloatBox> positions,
                const GltfVertices& vertices, const GltfOptions& options) {
  for (std::size_t i = 0; i < vertices.parts.size(); ++i) {
    const std::map<std::string, std::size_t>& attributes = payload.primitives[i].attributes;
    payload.arrays[attributes.at("POSITION")].bounds = positions[i];
    for (const GltfAttribute& attribute : options.attributes)
      if (attribute.name.ends_with("/POSITION") && attribute.is_in(vertices.parts[i].group))
        payload.arrays[attributes.at(attribute.name)].bounds =
            target_bounds(vertices, vertices.parts[i], attribute);
  }
}

void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks) {
  const std::uint64_t bytes = plain_payload(surface.info(), vertices, options).buffer_bytes;
  LoopProgress progress(options.callbacks, "write", kGltfSurveyed, 1,
                        static_cast<std::int64_t>(bytes));
  std::uint64_t written = 0;
  std::vector<ByteSink> all(sinks.begin(), sinks.end());
  all.push_back([&](std::span<const std::byte> piece) {
    written += piece.size();
    progress.add(std::ssize(piece));
  });
  RowWriter rows(surface, vertices, options, all);
  rows.write<glm::vec3>(Part::Position);
  rows.write<glm::vec3>(Part::Normal);
  for (int set = 0; set < uv_set_count(vertices); ++set)
    write_uvs(surface, vertices, set, options, all);
  if (surface.info().has_colors) rows.write<glm::vec4>(Part::Color);
  for (const GltfAttribute& attribute : row_attributes(options)) {
    if (attribute.is_integer) {
      write_attribute<std::uint16_t>(vertices, attribute, all);
    } else {
      write_attribute<float>(vertices, attribute, all);
    }
  }
  const std::array<std::byte, 4> zeros{};
  for (const GltfPart& part : vertices.parts) {
    const bool is_of_ngons = encodes_ngons(part, options);
    if (index_size(part) == 2) {
      write_indices<std::uint16_t>(surface, vertices, part, is_of_ngons, all);
    } else {
      write_indices<std::uint32_t>(surface, vertices, part, is_of_ngons, all);
    }
    if (written % 4 == 0) continue;
    for (const ByteSink& sink : all) sink(std::span(zeros).first(4 - written % 4));
  }
}

}  // namespace planish
