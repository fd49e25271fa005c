// Based on: G. Turk, "The PLY Polygon File Format", 1994.
#include "planish/files/ply/read_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/drop_marked.h"
#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#include "planish/files/ply/ply_body.h"
#include "planish/files/ply/ply_texture_corners.h"
#include "planish/files/ply/ply_vertex.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/split_normals.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max() - 1;

struct Reading {
  std::size_t part_bytes = kTextPartBytes;
  bool wants_normals = false;  // of a mesh; those of a cloud are always read
  bool wants_properties = false;
  bool is_strict = false;
};

template <class Body>
class PlyReader {
 public:
  using Cursor = typename Body::Cursor;

  PlyReader(const FileBytes& file, const PlyHeader& header, const Reading& reading)
      : name_(file.name),
        body_(file, header, reading.part_bytes),
        header_(header),
        reading_(reading) {}

  MeshFile read() {
    file_.format = FileFormat::Ply;
    for (const std::string& comment : header_.comments)
      if (comment.starts_with("planish ")) file_.header.push_back(comment);
    vertex_count_ = require_single("vertex");
    if (vertex_count_ < 0) body_.fail("the header has no element `vertex`", -1);
    (void)require_single("face");
    (void)require_single("tristrips");
    for (const PlyElement& element : header_.elements) read_element(element);
    if (!file_.mesh.uvs.empty()) name_uvs();
    texture_.finish(file_);
    warn_of_textures();
    add_warnings();
    return std::move(file_);
  }
  [[nodiscard]] Body& body() { return body_; }

 private:
  std::int64_t require_single(std::string_view name);
  void read_element(const PlyElement& element);
  template <class Read>
  void for_pieces(const PlyElement& element, std::size_t pieces, const Read& read);
  PlyVertexLayout layout_of(const PlyElement& element) const;
  void make_room(const PlyVertexLayout& layout, std::int64_t count);
  void read_vertices(const PlyElement& element);
  void drop_missing();
  void read_vertex(Cursor& cursor, const PlyElement& element, const PlyVertexLayout& layout,
                   std::int64_t vertex, PlyNotes& notes);
  void read_faces(const PlyElement& element);
  std::int32_t read_face(Cursor& cursor, const PlyElement& element, const PlyProperty& indices,
                         std::int64_t face, std::vector<std::int32_t>& corners,
                         std::vector<double>& texture) const;
  void read_strips(const PlyElement& element);
  void read_strip(Cursor& cursor, const PlyElement& element, const PlyProperty& indices,
                  std::int64_t strip, FaceParts::Part& part) const;
  void append(const FaceParts& faces, const PlyElement& element);
  void warn_of_face_properties(const PlyElement& element);
  void warn_of_textures();
  std::int32_t read_index(Cursor& cursor, const PlyProperty& property, const PlyElement& element,
                          std::int64_t face, double least = 0) const;
  void name_uvs();
  void add_warnings();

  std::string_view name_;
  Body body_;
  const PlyHeader& header_;
  Reading reading_;
  MeshFile file_;
  PlyNotes notes_;
  PlyTextureCorners texture_;
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
  if (element.name == "tristrips") return read_strips(element);
  if (element.name == "edge") file_.dropped_element_count += element.count;
  const std::size_t pieces = body_.piece_count(element);
  for_pieces(element, pieces, [&](std::size_t, Cursor& cursor, std::int64_t entry, PlyNotes&) {
    for (const PlyProperty& property : element.properties)
      skip_ply_value(cursor, property, element, entry);
  });
}

// Calls read(piece, cursor, entry, notes) for each entry, those of a piece one after another.
// `pieces` is what piece_count() gives, which has to walk over lists.
template <class Body>
template <class Read>
void PlyReader<Body>::for_pieces(const PlyElement& element, std::size_t pieces, const Read& read) {
  std::vector<PlyNotes> notes(pieces);
  body_.for_pieces(element,
                   [&](std::size_t piece, Cursor& cursor, std::int64_t begin, std::int64_t end) {
                     for (std::int64_t entry = begin; entry < end; ++entry) {
                       cursor.begin();
                       read(piece, cursor, entry, notes[piece]);
                       cursor.end(element, entry, notes[piece].excess);
                     }
                   });
  for (const PlyNotes& of_piece : notes) notes_.join(of_piece);
}

template <class Body>
PlyVertexLayout PlyReader<Body>::layout_of(const PlyElement& element) const {
  PlyVertexLayout layout = ply_vertex_layout(element);
  const bool has_faces = std::ranges::any_of(header_.elements, [](const PlyElement& other) {
    return (other.name == "face" || other.name == "tristrips") && other.count > 0;
  });
  layout.takes_missing = !has_faces && !reading_.is_strict;
  if (has_faces && !reading_.wants_normals) {
    layout.has_normals = false;
    std::ranges::replace_if(
        layout.slots, [](int slot) { return slot > 8; }, -1);
  }
  if (reading_.wants_properties) add_ply_properties(element, layout);
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
  for (const std::string& name : layout.properties.names())
    file_.mesh.attributes.push_back(attribute_of_size(name, 1, vertices));
  layout.properties.warn(file_.warnings, name_, "vertices");
}

template <class Body>
void PlyReader<Body>::read_vertices(const PlyElement& element) {
  const PlyVertexLayout layout = layout_of(element);
  if (element.count > kMaxCount)
    body_.fail(formatted("more vertices than 32 bits can count: {}", element.count), -1);
  make_room(layout, element.count);
  const std::size_t pieces = body_.piece_count(element);
  for_pieces(element, pieces,
             [&](std::size_t, Cursor& cursor, std::int64_t vertex, PlyNotes& notes) {
               read_vertex(cursor, element, layout, vertex, notes);
             });
  settle_colors(file_.mesh.colors, name_, /*whole_is_usual=*/false, file_.warnings);
  if (layout.takes_missing) drop_missing();
}

// Points that a depth camera did not see.
template <class Body>
void PlyReader<Body>::drop_missing() {
  PolygonMesh& mesh = file_.mesh;
  std::vector<std::uint8_t> is_missing(mesh.positions.size());
  for (std::size_t i = 0; i < is_missing.size(); ++i) {
    const glm::dvec3& p = mesh.positions[i];
    is_missing[i] = std::isnan(p.x) || std::isnan(p.y) || std::isnan(p.z);
    file_.missing_count += is_missing[i];
  }
  if (file_.missing_count == 0) return;
  drop_marked(mesh.positions, is_missing);
  if (!mesh.uvs.empty()) drop_marked(mesh.uvs, is_missing);
  if (!mesh.colors.empty()) drop_marked(mesh.colors, is_missing);
  if (!file_.normals.empty()) drop_marked(file_.normals, is_missing);
  for (VertexAttribute& attribute : mesh.attributes) drop_marked(attribute.values, is_missing);
}

template <class Body>
void PlyReader<Body>::read_vertex(Cursor& cursor, const PlyElement& element,
                                  const PlyVertexLayout& layout, std::int64_t vertex,
                                  PlyNotes& notes) {
  const PlyVertex found = read_ply_vertex(cursor, element, layout, vertex, notes);
  PolygonMesh& mesh = file_.mesh;
  mesh.positions[vertex] = found.position();
  if (layout.has_uvs) mesh.uvs[vertex] = found.uv();
  if (layout.has_normals) file_.normals[vertex] = found.normal();
  if (layout.has_colors) mesh.colors[vertex] = found.color();
  for (std::size_t k = 0; k < layout.properties.names().size(); ++k)
    mesh.attributes[k].values[vertex] = found.property(k);
}

template <class Body>
void PlyReader<Body>::read_faces(const PlyElement& element) {
  const PlyProperty* indices = ply_vertex_list(element);
  if (element.count > 0 && indices == nullptr)
    body_.fail("element `face` has no list `vertex_indices`", -1);
  if (element.count > kMaxCount)
    body_.fail(formatted("more faces than 32 bits can count: {}", element.count), -1);
  if (indices == nullptr) return;
  FaceParts faces;
  const std::size_t pieces = body_.piece_count(element);
  faces.parts.resize(pieces);
  const bool has_texture = ply_texture_list(element) != nullptr;
  std::vector<PlyTextureCorners> textures(has_texture ? faces.parts.size() : 0);
  for_pieces(element, pieces, [&](std::size_t piece, Cursor& cursor, std::int64_t face, PlyNotes&) {
    FaceParts::Part& part = faces.parts[piece];
    std::vector<double> texture;
    part.sizes.push_back(read_face(cursor, element, *indices, face, part.vertices, texture));
    if (has_texture) textures[piece].add_face(texture, static_cast<std::size_t>(part.sizes.back()));
  });
  for (const PlyTextureCorners& texture : textures) texture_.append(texture);
  append(faces, element);
  if (element.count > 0 && reading_.wants_properties) warn_of_face_properties(element);
}

template <class Body>
void PlyReader<Body>::append(const FaceParts& faces, const PlyElement& element) {
  if (const std::int64_t face = faces.append_to(file_.mesh); face >= 0)
    body_.fail(place_of(element, face) + ": more face corners than 32 bits can count", face);
}

template <class Body>
void PlyReader<Body>::warn_of_face_properties(const PlyElement& element) {
  std::string names;
  for (const PlyProperty& property : element.properties)
    if (&property != ply_vertex_list(element) && &property != ply_texture_list(element) &&
        property.name != "flags")  // a program's own marks
      names += (names.empty() ? "" : ", ") + visible(property.name);
  if (!names.empty())
    file_.warnings.push_back(
        {.code = "ignored-face-properties",
         .message = formatted("{}: properties of faces are left out: {}; those of vertices are "
                              "read",
                              name_, names)});
}

// Programs name pictures in comments, and a number of one for each face.
template <class Body>
void PlyReader<Body>::warn_of_textures() {
  constexpr std::string_view kKeyword = "TextureFile";
  std::string names;
  for (const std::string& comment : header_.comments) {
    if (!comment.starts_with(kKeyword)) continue;
    Words words(std::string_view(comment).substr(kKeyword.size()));
    const std::string_view name = words.next();
    names += (names.empty() ? "" : ", ") + visible(name) + visible(words.rest());
  }
  if (!names.empty())
    file_.warnings.push_back(
        {.code = "left-out-textures",
         .message = formatted("{}: textures are left out: {}; a material of an OBJ or glTF keeps "
                              "its own",
                              name_, names)});
}

// A strip's triangles turn now left, now right; a vertex twice in a row only turns them. -1 begins
// another strip.
template <class Body>
void PlyReader<Body>::read_strips(const PlyElement& element) {
  const PlyProperty* indices = ply_vertex_list(element);
  if (element.count > 0 && indices == nullptr)
    body_.fail("element `tristrips` has no list `vertex_indices`", -1);
  if (indices == nullptr) return;
  FaceParts faces;
  const std::size_t pieces = body_.piece_count(element);
  faces.parts.resize(pieces);
  for_pieces(element, pieces,
             [&](std::size_t piece, Cursor& cursor, std::int64_t strip, PlyNotes&) {
               read_strip(cursor, element, *indices, strip, faces.parts[piece]);
             });
  for (const FaceParts::Part& part : faces.parts)
    for (std::size_t triangle = 0; triangle < part.sizes.size(); ++triangle)
      texture_.add_face({}, 3);
  append(faces, element);
}

template <class Body>
void PlyReader<Body>::read_strip(Cursor& cursor, const PlyElement& element,
                                 const PlyProperty& indices, std::int64_t strip,
                                 FaceParts::Part& part) const {
  for (const PlyProperty& property : element.properties) {
    if (&property != &indices) {
      skip_ply_value(cursor, property, element, strip);
      continue;
    }
    std::array<std::int32_t, 2> last{};
    std::int64_t length = 0;  // of the strip so far
    const std::int64_t count = ply_list_count(cursor, property, element, strip);
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int32_t vertex = read_index(cursor, property, element, strip, /*least=*/-1);
      if (vertex < 0) {
        length = 0;
        continue;
      }
      const bool turns_left = length % 2 == 0;
      if (++length >= 3 && last[0] != last[1] && last[1] != vertex && vertex != last[0]) {
        part.sizes.push_back(3);
        part.vertices.insert(part.vertices.end(),
                             {last[turns_left ? 0 : 1], last[turns_left ? 1 : 0], vertex});
      }
      last = {last[1], vertex};
    }
  }
}

// Appends a face's corners and returns how many they are.
template <class Body>
std::int32_t PlyReader<Body>::read_face(Cursor& cursor, const PlyElement& element,
                                        const PlyProperty& indices, std::int64_t face,
                                        std::vector<std::int32_t>& corners,
                                        std::vector<double>& texture) const {
  const PlyProperty* const coordinates = ply_texture_list(element);
  std::int64_t size = 0;
  for (const PlyProperty& property : element.properties) {
    if (&property == coordinates) {
      const std::int64_t count = ply_list_count(cursor, property, element, face);
      for (std::int64_t i = 0; i < count; ++i)
        texture.push_back(cursor.any_number(property.type, element, face));
      continue;
    }
    if (&property != &indices) {
      skip_ply_value(cursor, property, element, face);
      continue;
    }
    size = ply_list_count(cursor, property, element, face);
    for (std::int64_t i = 0; i < size; ++i)
      corners.push_back(read_index(cursor, property, element, face));
  }
  return static_cast<std::int32_t>(size);
}

template <class Body>
std::int32_t PlyReader<Body>::read_index(Cursor& cursor, const PlyProperty& property,
                                         const PlyElement& element, std::int64_t face,
                                         double least) const {
  const double vertex = cursor.number(property.type, element, face);
  // The negated comparison catches NaN.
  if (!(vertex >= least && vertex < static_cast<double>(vertex_count_)) ||
      vertex != std::floor(vertex))
    cursor.fail(formatted("{} names vertex {} of {}", place_of(element, face), shortest(vertex),
                          vertex_count_),
                face);
  return static_cast<std::int32_t>(vertex);
}

// Corners have the coordinates of their vertices, where these have some.
template <class Body>
void PlyReader<Body>::name_uvs() {
  PolygonMesh& mesh = file_.mesh;
  mesh.face_uvs = mesh.face_vertices;
  if (notes_.uv.count == 0) return;
  for (std::int32_t& uv : mesh.face_uvs)
    if (std::isnan(mesh.uvs[uv].x)) uv = -1;
  for (glm::dvec2& uv : mesh.uvs)
    if (std::isnan(uv.x)) uv = glm::dvec2(0.0);
}

template <class Body>
void PlyReader<Body>::add_warnings() {
  header_.unknown.warn(file_.warnings, "unknown-keyword", name_, "such lines are passed over");
  notes_.excess.warn(file_.warnings, "excess-values", name_,
                     "what stands behind an entry's last value is passed over");
  notes_.color.warn(file_.warnings, "missing-colors", name_, "such vertices are white");
  notes_.uv.warn(file_.warnings, "missing-texture-coordinates", name_,
                 "corners at such vertices have none");
  notes_.property.warn(file_.warnings, "missing-properties", name_, "such properties are 0 there");
}

// Some writers put an entry on several lines, or several on one. That the words end with the last
// entry says that all of them are what they are taken for; nothing where that is not so.
std::optional<MeshFile> read_wrapped(const FileBytes& file, const PlyHeader& header,
                                     const Reading& reading) {
  try {
    PlyReader<PlyWrappedBody> reader(file, header, reading);
    MeshFile found = reader.read();
    if (!reader.body().is_at_end()) return std::nullopt;
    found.warnings.push_back(
        {.code = "wrapped-lines",
         .message = formatted("{}: entries go over lines; the numbers are read one after another, "
                              "and are as many as wanted",
                              file.name)});
    return found;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    return std::nullopt;
  }
}

MeshFile read_as(const FileBytes& file, const Reading& reading) {
  const PlyHeader header = read_ply_header(file);
  if (header.format != PlyFormat::Text)
    return PlyReader<PlyBinaryBody>(file, header, reading).read();
  try {
    return PlyReader<PlyTextBody>(file, header, reading).read();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput || file.is_strict) throw;
    std::optional<MeshFile> wrapped = read_wrapped(file, header, reading);
    if (!wrapped) throw;
    return std::move(*wrapped);
  }
}

}  // namespace

MeshFile read_binary_ply_body(const FileBytes& file, const PlyHeader& header) {
  PlyReader<PlyBinaryBody> reader(file, header, {});
  MeshFile found = reader.read();
  if (const std::size_t left = reader.body().bytes_left(); left > 0)
    reader.body().fail(formatted("{} bytes more follow after the last face", left), -1);
  return found;
}

MeshFile read_ply(const FileBytes& file, std::size_t part_bytes) {
  MeshFile found = read_as(file, {.part_bytes = part_bytes,
                                  .wants_normals = file.split_normals_crease,
                                  .wants_properties = true,
                                  .is_strict = file.is_strict});
  if (!file.split_normals_crease || found.mesh.face_count() == 0) return found;
  const CornerNormals normals{.values = std::exchange(found.normals, {}),
                              .of_corners = found.mesh.face_vertices};
  if (normals.values.empty()) return found;
  weld_repeated_vertices(found);
  mark_split_normals(found.mesh, normals);
  return found;
}

}  // namespace planish
