#include "planish/files/gltf/gltf_payload.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/writers.h"

namespace planish {
namespace {

// Rows surveyed at once, which fit into a core's own cache.
constexpr std::int64_t kSurveyedRows = std::int64_t{1} << 13;

// As the Khronos validator allows.
constexpr float kUnitLengthTolerance = 5e-4f;

// The first row with a fault, whatever the threads do.
struct Fault {
  std::int64_t row = -1;
  bool is_position = false;
  float normal_length = 1;
  glm::vec3 position{};
  // Positions come before normals.
  [[nodiscard]] bool before(const Fault& other) const {
    if (other.row < 0 || row < 0) return row >= 0;
    return is_position != other.is_position ? is_position : row < other.row;
  }
};

struct Survey {
  std::vector<FloatBox> parts;
  DegenerateRows degenerate;
  Fault fault;

  void add(const Survey& other) {
    parts.resize(other.parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].add(other.parts[i]);
    degenerate.add(other.degenerate);
    if (other.fault.before(fault)) fault = other.fault;
  }
};

// One range of rows.
class Surveyor {
 public:
  // `copied` is copied_rows() of the vertices.
  Surveyor(const SurfaceBlocks& surface, const GltfVertices& vertices,
           std::span<const CopiedRow> copied, const GltfOptions& options)
      : surface_(surface),
        vertices_(vertices),
        copied_(copied),
        stored_(options),
        origin_(options.origin) {}

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
    const FloatBox box = box_of(positions_);
    if (!box.is_finite || !are_surely_units(normals_, kUnitLengthTolerance))
      look_for_faults(range, survey);
    add_bounds(range, box, survey);
    return survey;
  }

 private:
  void look_for_faults(RowRange range, Survey& survey) const {
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      const auto row = range.first + static_cast<std::int64_t>(i);
      if (!is_finite(positions_[i])) note({row, true, 0, positions_[i]}, survey);
      const float length = glm::length(normals_[i]);
      if (!(std::abs(length - 1.0f) <= kUnitLengthTolerance)) note({row, false, length}, survey);
    }
  }
  void add_bounds(RowRange range, const FloatBox& box, Survey& survey) const {
    survey.parts.resize(vertices_.parts.size());
    // One primitive has all rows: its copies have the places of others.
    if (survey.parts.size() == 1) {
      for (const glm::vec3& corner : {box.minimum, box.maximum})
        survey.parts[0].add(stored_.turn(corner));
      return;
    }
    for (const CopiedRow& copy : copies_in(copied_, range)) {
      const auto part = std::ranges::upper_bound(vertices_.parts, copy.vertex, std::less<>(),
                                                 &GltfPart::first_vertex) -
                        1;
      survey.parts[part - vertices_.parts.begin()].add(
          stored_.turn(positions_[copy.row - range.first]));
    }
  }

  static void note(const Fault& fault, Survey& survey) {
    if (fault.before(survey.fault)) survey.fault = fault;
  }

  const SurfaceBlocks& surface_;
  const GltfVertices& vertices_;
  std::span<const CopiedRow> copied_;
  StoredPosition stored_;
  glm::dvec3 origin_;
  RawVector<glm::vec3> positions_, normals_;
};

[[noreturn]] void refuse(const Fault& fault, const GltfOptions& options) {
  if (fault.is_position) {
    refuse_to_write(options,
                    formatted("vertex {} has a coordinate that float32 cannot hold: {}; scale the "
                              "model down, or mend what made it",
                              fault.row, number_words(fault.position)),
                    fault.row);
  }
  refuse_to_write(options,
                  "the normal of vertex " + std::to_string(fault.row) + " has length " +
                      std::to_string(fault.normal_length) + ", not 1",
                  fault.row);
}

}  // namespace

GltfSurvey gltf_survey(const SurfaceBlocks& surface, const GltfVertices& vertices,
                       const GltfOptions& options, std::span<const std::int32_t> surface_rows) {
  const std::vector<CopiedRow> copied = copied_rows(vertices);
  const std::vector<RowRange> pieces = surface.row_blocks(kSurveyedRows);
  Survey all;
  std::mutex mutex;
  LoopProgress progress(options.callbacks, "write", 0, kGltfSurveyed, std::ssize(pieces));
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    Surveyor survey(surface, vertices, copied, options);
    for (std::size_t i = begin; i < end; ++i) {
      const Survey part = survey(pieces[i]);
      const std::lock_guard lock(mutex);
      all.add(part);
      progress.add();
    }
  });
  if (all.fault.row >= 0) {
    if (!surface_rows.empty()) all.fault.row = surface_rows[all.fault.row];
    refuse(all.fault, options);
  }
  return {std::move(all.parts), all.degenerate};
}

std::vector<FloatBox> gltf_bounds(const SurfaceBlocks& surface, const GltfVertices& vertices,
                                  const GltfOptions& options) {
  GltfSurvey found = gltf_survey(surface, vertices, options);
  warn_of(found.degenerate, options.callbacks);
  return std::move(found.bounds);
}

namespace {

// Based on: Khronos, "glTF 2.0 Specification", 2021, section 3.6.

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
                   std::size_t most_fanned, std::span<const ByteSink> sinks) {
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
        if (most_fanned > 0) {
          write.ngons(faces, face_before(part, faces.first), most_fanned, bytes);
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
    const std::size_t most_fanned = encodes_ngons(part, options) ? options.most_fanned : 0;
    if (index_size(part) == 2) {
      write_indices<std::uint16_t>(surface, vertices, part, most_fanned, all);
    } else {
      write_indices<std::uint32_t>(surface, vertices, part, most_fanned, all);
    }
    if (written % 4 == 0) continue;
    for (const ByteSink& sink : all) sink(std::span(zeros).first(4 - written % 4));
  }
}

namespace {

// Of which all stand in memory.
constexpr std::size_t kBlocksAtOnce = 8;
// Of the room in a buffer: the vertices where two blocks meet are in both.
constexpr double kFill = 0.98;

// Packing needs all of a plain buffer.
void hold_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                 const GltfOptions& options, GltfPayload& plain) {
  RawVector<std::byte>& buffer = plain.pieces.emplace_back();
  buffer.reserve(plain.buffer_bytes);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    buffer.insert(buffer.end(), piece.begin(), piece.end());
  };
  write_buffer(surface, vertices, options, std::span(&append, 1));
}

GltfPayload pack_at_once(const SurfaceBlocks& surface, const GltfOptions& given) {
  GltfOptions options = given;
  options.callbacks = share_of(given.callbacks, 0, 0.5);
  const GltfVertices vertices = gltf_vertices(surface, options);
  GltfPayload plain = plain_payload(surface.info(), vertices, options);
  set_bounds(plain, gltf_bounds(surface, vertices, options), vertices, options);
  hold_buffer(surface, vertices, options, plain);
  const FloatBox bounds = bounds_of_all(plain);
  tell_kept_float(options, bounds);
  return pack_gltf(std::move(plain), vertices, options, bounds);
}

struct PackedBlock {
  GltfPayload payload;
  std::vector<glm::dvec3> decoded;
  std::vector<std::int32_t> rows;  // of the surface, of those
};

PackedBlock pack_block(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options,
                       const FloatBox& bounds) {
  GltfBlock block(surface, faces, options);
  const auto rows = block.surface().surface_rows();
  const auto given = std::ranges::lower_bound(rows, options.decoded_rows) - rows.begin();
  PackedBlock packed;
  packed.rows.assign(rows.begin(), rows.begin() + given);
  block.options().decoded_rows = given;
  block.options().decoded = [&](std::span<const glm::dvec3> decoded) {
    packed.decoded.assign(decoded.begin(), decoded.end());
  };
  DegenerateRows known;  // by the survey of the whole
  GltfPayload plain = block.payload(known);
  hold_buffer(block.surface(), block.vertices(), block.options(), plain);
  packed.payload = pack_gltf(std::move(plain), block.vertices(), block.options(), bounds);
  return packed;
}

// Of all rows.
FloatBox bounds_of_rows(const SurfaceBlocks& surface, const GltfOptions& options) {
  GltfVertices all;
  all.kept_rows = surface.info().row_count;
  all.parts = {{.vertex_count = all.kept_rows}};
  return gltf_bounds(surface, all, options).front();
}

// Arrays and primitives of a block behind those of `all`, into the same mesh.
void append(GltfPayload block, GltfPayload& all) {
  const std::size_t first = all.arrays.size();
  for (GltfArray& array : block.arrays) {
    // The arrays that streams stand for lie in a buffer of their own.
    array.offset += array.stream ? all.decoded_bytes : all.buffer_bytes;
    if (array.stream) array.stream->offset += all.buffer_bytes;
    all.arrays.push_back(array);
  }
  for (GltfPrimitive& primitive : block.primitives) {
    for (auto& [name, array] : primitive.attributes) array += first;
    primitive.indices += first;
    all.primitives.push_back(std::move(primitive));
  }
  for (RawVector<std::byte>& piece : block.pieces) all.pieces.push_back(std::move(piece));
  all.buffer_bytes += block.buffer_bytes;
  all.decoded_bytes += block.decoded_bytes;
  all.vertex_count += block.vertex_count;
  all.triangle_count += block.triangle_count;
}

GltfPayload pack_by_blocks(const SurfaceBlocks& surface, const GltfOptions& options) {
  const FloatBox bounds = bounds_of_rows(surface, options);
  tell_kept_float(options, bounds);
  const std::vector<RowRange> ranges = ranges_of(surface.info().face_count, kPackedFaces);
  LoopProgress progress(options.callbacks, "write", kGltfSurveyed, kGltfPacked, std::ssize(ranges));
  GltfPayload all;
  std::vector<glm::dvec3> decoded(
      static_cast<std::size_t>(std::min(surface.info().row_count, options.decoded_rows)));
  for (std::size_t first = 0; first < ranges.size(); first += kBlocksAtOnce) {
    std::vector<PackedBlock> blocks(std::min(kBlocksAtOnce, ranges.size() - first));
    parallel_each(blocks.size(), 1, [&](std::size_t i) {
      // A thread that waits here must not begin another block.
      oneapi::tbb::this_task_arena::isolate(
          [&] { blocks[i] = pack_block(surface, ranges[first + i], options, bounds); });
      progress.add();
    });
    for (PackedBlock& block : blocks) {
      for (std::size_t i = 0; i < block.decoded.size(); ++i)
        decoded[block.rows[i]] = block.decoded[i];
      if (all.arrays.empty()) {
        all = std::move(block.payload);
      } else {
        append(std::move(block.payload), all);
      }
    }
  }
  all.shares_materials = true;
  if (options.decoded) options.decoded(decoded);
  return all;
}

}  // namespace

void GltfPayload::write(std::span<const ByteSink> sinks) const {
  if (pieces.empty()) return write_plain(sinks);
  for (const RawVector<std::byte>& piece : pieces) write_padded(piece, sinks);
}

GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  require_a_face(surface.info().face_count, options);
  if (options.compression != GltfCompression::None) {
    require_numbers(surface, options);
    const bool is_small = surface.info().face_count <= kPackedFaces;
    return is_small ? pack_at_once(surface, options) : pack_by_blocks(surface, options);
  }
  const auto vertices = std::make_shared<const GltfVertices>(gltf_vertices(surface, options));
  require_numbers(surface, options);
  GltfPayload payload = plain_payload(surface.info(), *vertices, options);
  // Before the work: it may not fit.
  if (is_glb) (void)glb_byte_count(0, payload.buffer_bytes, options.name);
  set_bounds(payload, gltf_bounds(surface, *vertices, options), *vertices, options);
  payload.write_plain = [&surface, &options, vertices](std::span<const ByteSink> sinks) {
    write_buffer(surface, *vertices, options, sinks);
  };
  return payload;
}

GltfBlock::GltfBlock(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options)
    : surface_(surface, faces), options_(options) {
  options_.callbacks = {};
  options_.fields.clear();
  options_.attributes = row_attributes(options);
  for (GltfAttribute& attribute : options_.attributes) {
    std::vector<float>& values = values_.emplace_back();
    const auto width = static_cast<std::size_t>(attribute.width);
    for (const std::int32_t i :
         attribute.of_uvs ? surface_.surface_uvs() : surface_.surface_rows()) {
      const auto of_one = attribute.values.subspan(width * static_cast<std::size_t>(i), width);
      values.insert(values.end(), of_one.begin(), of_one.end());
    }
    attribute.values = values;
    take_further(attribute);
  }
  for (std::span<const glm::dvec2>& set : options_.further_uvs) {
    std::vector<glm::dvec2>& values = uvs_.emplace_back();
    for (const std::int32_t uv : surface_.surface_uvs()) values.push_back(set[uv]);
    set = values;
  }
  vertices_ = gltf_vertices(surface_, options_);
  buffer_bytes_ = plain_payload(surface_.info(), vertices_, options_).buffer_bytes;
}

// Those in the block, under its numbers.
void GltfBlock::take_further(GltfAttribute& attribute) {
  if (attribute.further.empty()) return;
  std::vector<UvOnRow>& further = further_.emplace_back();
  std::vector<float>& values = values_.emplace_back();
  const auto place_of = [](std::span<const std::int32_t> all, std::int32_t number) {
    const auto found = std::ranges::lower_bound(all, number);
    return found != all.end() && *found == number ? static_cast<std::int32_t>(found - all.begin())
                                                  : -1;
  };
  for (const UvOnRow& one : attribute.further) {
    const std::int32_t uv = place_of(surface_.surface_uvs(), one.uv);
    const std::int32_t row = place_of(surface_.surface_rows(), one.row);
    if (uv < 0 || row < 0) continue;
    further.push_back({uv, row});
    const float* const numbers = attribute.numbers(one.uv, one.row);
    values.insert(values.end(), numbers, numbers + attribute.width);
  }
  attribute.further = further;
  attribute.further_values = values;
}

GltfPayload GltfBlock::payload(DegenerateRows& degenerate) const {
  const GltfSurvey found = gltf_survey(surface_, vertices_, options_, surface_.surface_rows());
  degenerate.add(found.degenerate);
  GltfPayload payload = plain_payload(surface_.info(), vertices_, options_);
  set_bounds(payload, found.bounds, vertices_, options_);
  payload.write_plain = [this](std::span<const ByteSink> sinks) {
    write_buffer(surface_, vertices_, options_, sinks);
  };
  return payload;
}

RowRange faces_of_buffer(const SurfaceBlocks& surface, std::int64_t first,
                         std::uint64_t surface_bytes, const GltfOptions& options) {
  const std::int64_t all = surface.info().face_count;
  const double share =
      kFill * static_cast<double>(options.buffer_bytes) / static_cast<double>(surface_bytes);
  const auto count = static_cast<std::int64_t>(share * static_cast<double>(all));
  return {first, std::clamp<std::int64_t>(count, 1, all - first)};
}

}  // namespace planish
