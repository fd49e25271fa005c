// Based on: G. Turk, "The PLY Polygon File Format", 1994.
#include "planish/files/ply/read_ply.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/files/ply/ply_body.h"
#include "planish/files/ply/ply_vertex_layout.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/split_normals.h"

namespace planish {
namespace {

constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max() - 1;

struct Reading {
  std::size_t part_bytes = std::size_t{1} << 20;
  bool wants_normals = false;  // of a mesh; those of a cloud are always read
};

template <class Body>
class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, std::string_view name, const PlyHeader& header,
            const Reading& reading)
      : body_(bytes, name), header_(header), reading_(reading) {
    body_.skip_header(header);
  }

  MeshFile read() {
    file_.format = FileFormat::Ply;
    for (const std::string& comment : header_.comments)
      if (comment.starts_with("planish ")) file_.header.push_back(comment);
    vertex_count_ = require_single("vertex");
    if (vertex_count_ < 0) body_.fail("the header has no element `vertex`", -1);
    (void)require_single("face");
    if (!read_text_parts()) {
      file_.mesh = {};
      file_.normals = {};
      for (const PlyElement& element : header_.elements) read_element(element);
    }
    if (!file_.mesh.uvs.empty()) file_.mesh.face_uvs = file_.mesh.face_vertices;
    return std::move(file_);
  }

 private:
  std::int64_t require_single(std::string_view name);
  void read_element(const PlyElement& element);
  PlyVertexLayout layout_of(const PlyElement& element) const;
  void make_room(const PlyVertexLayout& layout, std::int64_t count);
  bool read_text_parts();
  void read_vertices(const PlyElement& element);
  void read_vertex(Body& body, const PlyElement& element, const PlyVertexLayout& layout,
                   std::int64_t vertex);
  void read_faces(const PlyElement& element);
  std::int32_t read_face(Body& body, const PlyElement& element, const PlyProperty& indices,
                         std::int64_t face, std::vector<std::int32_t>& corners) const;
  bool read_face_records(const PlyElement& element, const PlyProperty& indices);
  std::int32_t read_index(Body& body, const PlyProperty& property, const PlyElement& element,
                          std::int64_t face) const;
  template <class PlaceOf, class Read>
  bool read_records(std::int64_t count, const PlaceOf& place_of_record, const Read& read) const;
  static std::optional<std::size_t> fixed_bytes(const PlyElement& element,
                                                const PlyProperty* besides);
  Body body_;
  const PlyHeader& header_;
  Reading reading_;
  MeshFile file_;
  std::int64_t vertex_count_ = -1;
};

// The count of the element, -1 if there is none.
template <class Body>
std::int64_t PlyReader<Body>::require_single(std::string_view name) {
  std::int64_t count = -1;
  for (const PlyElement& element : header_.elements) {
    if (element.name != name) continue;
    if (count >= 0) body_.fail("the header has element " + quote(name) + " twice", -1);
    count = element.count;
  }
  return count;
}

template <class Body>
void PlyReader<Body>::read_element(const PlyElement& element) {
  if (element.count > 0 && element.properties.empty())
    body_.fail("element " + quote(element.name) + " has no properties", -1);
  body_.require_room(element);
  if (element.name == "vertex") return read_vertices(element);
  if (element.name == "face") return read_faces(element);
  if (element.name == "edge") file_.dropped_element_count += element.count;
  if (element.name == "tristrips" && element.count > 0)
    file_.warnings.push_back({.code = "ignored-element",
                              .message = "triangle strips cannot be read; save them as faces",
                              .count = element.count});
  skip_ply_element(body_, element);
}

template <class Body>
PlyVertexLayout PlyReader<Body>::layout_of(const PlyElement& element) const {
  PlyVertexLayout layout = ply_vertex_layout(element);
  const bool has_faces = std::ranges::any_of(header_.elements, [](const PlyElement& other) {
    return other.name == "face" && other.count > 0;
  });
  if (has_faces && !reading_.wants_normals) {
    layout.has_normals = false;
    std::ranges::replace_if(
        layout.slots, [](int slot) { return slot > 8; }, -1);
  }
  if (layout.missing_axis != 0)
    body_.fail("element `vertex` has no property " + quote({&layout.missing_axis, 1}), -1);
  return layout;
}

template <class Body>
void PlyReader<Body>::make_room(const PlyVertexLayout& layout, std::int64_t count) {
  const auto vertices = static_cast<std::size_t>(count);
  file_.mesh.positions.resize(vertices);
  file_.mesh.uvs.resize(layout.has_uvs ? vertices : 0);
  file_.mesh.colors.resize(layout.has_colors ? vertices : 0);
  file_.normals.resize(layout.has_normals ? vertices : 0);
}

// Text of vertices and faces and nothing else, on all threads. False for other files, and where
// something is wrong: reading one line after another finds the first.
template <class Body>
bool PlyReader<Body>::read_text_parts() {
  if constexpr (std::is_same_v<Body, PlyTextBody>) {
    const std::vector<PlyElement>& elements = header_.elements;
    if (elements.size() != 2 || elements[0].name != "vertex" || elements[1].name != "face")
      return false;
    const PlyElement &vertices = elements[0], &faces = elements[1];
    const LineRecords records(body_.lines(), reading_.part_bytes);
    const PlyProperty* indices = ply_vertex_list(faces);
    if (records.part_count() == 1 || indices == nullptr || vertices.count > records.count() ||
        faces.count > records.count() - vertices.count)
      return false;
    try {
      const PlyVertexLayout layout = layout_of(vertices);
      make_room(layout, vertices.count);
      FaceParts parts;
      parts.parts.resize(records.part_count());
      const auto read_vertex_lines = [&](std::size_t, const TextLines& lines, std::int64_t begin,
                                         std::int64_t end) {
        PlyTextBody body(lines);
        for (std::int64_t v = begin; v < end; ++v) read_vertex(body, vertices, layout, v);
      };
      const auto read_face_lines = [&](std::size_t part, const TextLines& lines, std::int64_t begin,
                                       std::int64_t end) {
        PlyTextBody body(lines);
        FaceParts::Part& of = parts.parts[part];
        for (std::int64_t f = begin; f < end; ++f)
          of.sizes.push_back(read_face(body, faces, *indices, f - vertices.count, of.vertices));
      };
      return records.for_parts(0, vertices.count, read_vertex_lines) &&
             records.for_parts(vertices.count, vertices.count + faces.count, read_face_lines) &&
             parts.append_to(file_.mesh);
    } catch (const Error&) {
      return false;
    }
  }
  return false;
}

template <class Body>
void PlyReader<Body>::read_vertices(const PlyElement& element) {
  const PlyVertexLayout layout = layout_of(element);
  if (element.count > kMaxCount)
    body_.fail("more vertices than 32 bits can count: " + std::to_string(element.count), -1);
  const auto count = static_cast<std::size_t>(element.count);
  make_room(layout, element.count);
  if constexpr (std::is_same_v<Body, PlyBinaryBody>) {
    const std::optional<std::size_t> bytes = fixed_bytes(element, nullptr);
    const auto read = [&](Body& body, std::int64_t vertex) {
      read_vertex(body, element, layout, vertex);
    };
    if (bytes && read_records(
                     element.count, [&](std::int64_t v) { return v * *bytes; }, read)) {
      body_ = body_.behind(count * *bytes);
      return;
    }
  }
  for (std::int64_t vertex = 0; vertex < element.count; ++vertex)
    read_vertex(body_, element, layout, vertex);
}

template <class Body>
void PlyReader<Body>::read_vertex(Body& body, const PlyElement& element,
                                  const PlyVertexLayout& layout, std::int64_t vertex) {
  body.begin(element, vertex);
  std::array<double, 12> values{};
  values[8] = 1;  // opaque
  for (std::size_t i = 0; i < layout.slots.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const int slot = layout.slots[i];
    if (slot < 0) {
      skip_ply_value(body, property, element, vertex);
      continue;
    }
    if (slot > 8) {
      values[slot] = body.number_or_zero(property.type, element, vertex);
      continue;
    }
    const double value = body.number(property.type, element, vertex);
    if (!std::isfinite(value))
      body.fail(place_of(element, vertex) + ": " + property.name + " is " + shortest(value),
                vertex);
    values[slot] = slot < 5 ? value : ply_color(value, property.type, slot == 8);
  }
  body.end(element, vertex);
  PolygonMesh& mesh = file_.mesh;
  mesh.positions[vertex] = {values[0], values[1], values[2]};
  if (layout.has_uvs) mesh.uvs[vertex] = {values[3], values[4]};
  if (layout.has_normals) file_.normals[vertex] = {values[9], values[10], values[11]};
  if (layout.has_colors) mesh.colors[vertex] = {values[5], values[6], values[7], values[8]};
}

// Calls read(body, record) with a body at each record's place, on all threads. False where one was
// wrong: reading one after another finds the first.
template <class Body>
template <class PlaceOf, class Read>
bool PlyReader<Body>::read_records(std::int64_t count, const PlaceOf& place_of_record,
                                   const Read& read) const {
  constexpr std::size_t kPlyGrain = 4096;
  std::atomic<bool> sound{true};
  parallel_for(static_cast<std::size_t>(count), kPlyGrain, [&](std::size_t begin, std::size_t end) {
    if (!sound.load(std::memory_order_relaxed)) return;
    const std::size_t place = place_of_record(static_cast<std::int64_t>(begin));
    if (place > body_.bytes_left()) return sound.store(false, std::memory_order_relaxed);
    Body body = body_.behind(place);
    try {
      for (std::size_t i = begin; i < end; ++i) read(body, static_cast<std::int64_t>(i));
    } catch (const Error&) {
      sound.store(false, std::memory_order_relaxed);
    }
  });
  return sound.load();
}

// Bytes of a record without the one list `besides`; nothing where it has another list.
template <class Body>
std::optional<std::size_t> PlyReader<Body>::fixed_bytes(const PlyElement& element,
                                                        const PlyProperty* besides) {
  std::size_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    if (&property == besides) continue;
    if (property.count_type) return std::nullopt;
    bytes += byte_count_of(property.type);
  }
  return bytes;
}

template <class Body>
void PlyReader<Body>::read_faces(const PlyElement& element) {
  const PlyProperty* indices = ply_vertex_list(element);
  if (element.count > 0 && indices == nullptr)
    body_.fail("element `face` has no list `vertex_indices`", -1);
  if (element.count > kMaxCount)
    body_.fail("more faces than 32 bits can count: " + std::to_string(element.count), -1);
  if (indices == nullptr) return;
  if constexpr (std::is_same_v<Body, PlyBinaryBody>) {
    if (read_face_records(element, *indices)) return;
    file_.mesh.face_offsets = {0};
  }
  auto& corners = file_.mesh.face_vertices;
  corners.clear();
  file_.mesh.face_offsets.reserve(element.count + 1);
  for (std::int64_t face = 0; face < element.count; ++face) {
    (void)read_face(body_, element, *indices, face, corners);
    if (corners.size() > static_cast<std::size_t>(kMaxCount))
      body_.fail("more face corners than 32 bits can count", face);
    file_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
  }
}

// Appends a face's corners and returns how many they are.
template <class Body>
std::int32_t PlyReader<Body>::read_face(Body& body, const PlyElement& element,
                                        const PlyProperty& indices, std::int64_t face,
                                        std::vector<std::int32_t>& corners) const {
  std::int64_t size = 0;
  body.begin(element, face);
  for (const PlyProperty& property : element.properties) {
    if (&property != &indices) {
      skip_ply_value(body, property, element, face);
      continue;
    }
    size = ply_list_count(body, property, element, face);
    for (std::int64_t i = 0; i < size; ++i)
      corners.push_back(read_index(body, property, element, face));
  }
  body.end(element, face);
  return static_cast<std::int32_t>(size);
}

// First the sizes, whose sums tell where each record lies, then the corners on all threads. False
// where something is wrong, or where records hold further lists.
template <class Body>
bool PlyReader<Body>::read_face_records(const PlyElement& element, const PlyProperty& indices) {
  const std::optional<std::size_t> others = fixed_bytes(element, &indices);
  if (!others) return false;
  std::size_t before = 0;  // bytes of a record in front of the list
  for (const PlyProperty* property = element.properties.data(); property != &indices; ++property)
    before += byte_count_of(property->type);
  const std::size_t index_bytes = byte_count_of(indices.type);
  const std::size_t fixed = *others + byte_count_of(*indices.count_type);
  const auto place_of_record = [&](std::int64_t face) {
    return static_cast<std::size_t>(face) * fixed +
           static_cast<std::size_t>(file_.mesh.face_offsets[face]) * index_bytes;
  };

  std::vector<std::int32_t>& offsets = file_.mesh.face_offsets;
  offsets.resize(element.count + 1);
  std::int64_t corner_count = 0;
  for (std::int64_t face = 0; face < element.count; ++face) {
    const std::size_t place = place_of_record(face);
    if (place + fixed > body_.bytes_left()) return false;
    const double size = body_.behind_number(place + before, *indices.count_type);
    if (!(size >= 0) || size != std::floor(size) || size > static_cast<double>(kMaxCount))
      return false;
    corner_count += static_cast<std::int64_t>(size);
    if (corner_count > kMaxCount) return false;
    offsets[face + 1] = static_cast<std::int32_t>(corner_count);
  }
  const std::size_t end = place_of_record(element.count);
  if (end > body_.bytes_left()) return false;
  file_.mesh.face_vertices.resize(corner_count);
  const auto read = [&](Body& body, std::int64_t face) {
    for (const PlyProperty& property : element.properties) {
      if (&property != &indices) {
        skip_ply_value(body, property, element, face);
        continue;
      }
      (void)ply_list_count(body, property, element, face);
      for (std::int32_t c = offsets[face]; c < offsets[face + 1]; ++c)
        file_.mesh.face_vertices[c] = read_index(body, property, element, face);
    }
  };
  if (!read_records(element.count, place_of_record, read)) return false;
  body_ = body_.behind(end);
  return true;
}

template <class Body>
std::int32_t PlyReader<Body>::read_index(Body& body, const PlyProperty& property,
                                         const PlyElement& element, std::int64_t face) const {
  const double vertex = body.number(property.type, element, face);
  // The negated comparison catches NaN.
  if (!(vertex >= 0 && vertex < static_cast<double>(vertex_count_)) || vertex != std::floor(vertex))
    body.fail(place_of(element, face) + " names vertex " + shortest(vertex) + " of " +
                  std::to_string(vertex_count_),
              face);
  return static_cast<std::int32_t>(vertex);
}

MeshFile read_as(std::span<const std::byte> bytes, std::string_view name, const Reading& reading) {
  const PlyHeader header = read_ply_header(bytes, name);
  if (header.format == PlyFormat::Text)
    return PlyReader<PlyTextBody>(bytes, name, header, reading).read();
  return PlyReader<PlyBinaryBody>(bytes, name, header, reading).read();
}

}  // namespace

MeshFile read_ply(std::span<const std::byte> bytes, std::string_view name) {
  return read_as(bytes, name, {});
}

MeshFile read_ply_in_parts(std::span<const std::byte> bytes, std::string_view name,
                           std::size_t part_bytes) {
  return read_as(bytes, name, {.part_bytes = part_bytes});
}

MeshFile read_ply(const FileBytes& file) {
  MeshFile found = read_as(file.bytes, file.name, {.wants_normals = file.split_normals_crease});
  if (!file.split_normals_crease || found.mesh.face_count() == 0) return found;
  const CornerNormals normals{.values = std::exchange(found.normals, {}),
                              .of_corners = found.mesh.face_vertices};
  if (normals.values.empty()) return found;
  weld_repeated_vertices(found);
  mark_split_normals(found.mesh, normals);
  return found;
}

}  // namespace planish
