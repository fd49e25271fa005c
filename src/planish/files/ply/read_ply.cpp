#include "planish/files/ply/read_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/shared/weld.h"

namespace planish {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{
    {"char", PlyType::Int8},
    {"uchar", PlyType::UInt8},
    {"short", PlyType::Int16},
    {"ushort", PlyType::UInt16},
    {"int", PlyType::Int32},
    {"uint", PlyType::UInt32},
    {"float", PlyType::Float32},
    {"double", PlyType::Float64},
    {"int8", PlyType::Int8},
    {"uint8", PlyType::UInt8},
    {"int16", PlyType::Int16},
    {"uint16", PlyType::UInt16},
    {"int32", PlyType::Int32},
    {"uint32", PlyType::UInt32},
    {"float32", PlyType::Float32},
    {"float64", PlyType::Float64},
}};

PlyType read_type(std::string_view word, const TextLines& lines) {
  const auto found = std::ranges::find(kTypes, word, &std::pair<std::string_view, PlyType>::first);
  if (found == kTypes.end()) lines.fail("unknown type " + quote(word));
  return found->second;
}

PlyFormat read_format(Words words, const TextLines& lines) {
  const std::string_view format = words.next();
  const std::string_view version = words.next();
  if (version != "1.0") lines.fail("PLY version " + quote(version) + " is not 1.0");
  if (format == "ascii") return PlyFormat::Text;
  if (format == "binary_little_endian") return PlyFormat::LittleEndian;
  if (format == "binary_big_endian") return PlyFormat::BigEndian;
  lines.fail("unknown format " + quote(format));
}

PlyElement read_element(Words words, const TextLines& lines) {
  PlyElement element{.name = std::string(words.next())};
  const std::string_view count = words.next();
  if (!parse_integer(count, element.count) || element.count < 0)
    lines.fail("element count " + quote(count) + " is no integer from 0");
  return element;
}

PlyProperty read_property(Words words, const TextLines& lines) {
  PlyProperty property{};
  std::string_view word = words.next();
  if (word == "list") {
    property.count_type = read_type(words.next(), lines);
    if (*property.count_type == PlyType::Float32 || *property.count_type == PlyType::Float64)
      lines.fail("a list cannot be counted by a floating-point number");
    word = words.next();
  }
  property.type = read_type(word, lines);
  property.name = words.next();
  if (property.name.empty()) lines.fail("property without a name");
  return property;
}

// Of two properties of one name nobody could say which counts.
void add_property(Words words, const TextLines& lines, PlyElement& element) {
  PlyProperty property = read_property(words, lines);
  if (std::ranges::find(element.properties, property.name, &PlyProperty::name) !=
      element.properties.end())
    lines.fail("element " + quote(element.name) + " has two properties " + quote(property.name) +
               "; rename one");
  element.properties.push_back(std::move(property));
}

// A line that may be a misspelt element or property, on which the places of all values depend,
// cannot be passed over.
void pass_over(Words words, std::string_view keyword, const TextLines& lines, PlyHeader& header) {
  const std::string what = "unknown keyword " + quote(keyword);
  std::array<std::string_view, 5> rest;
  std::size_t count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    rest[std::min(count++, rest.size() - 1)] = word;
  std::int64_t ignored = 0;
  const bool may_be_element = count == 2 && parse_integer(rest[1], ignored);
  const bool may_be_property = !header.elements.empty() && (count == 2 || count == 4);
  if (may_be_element || may_be_property) lines.fail(what);
  lines.note(header.unknown, what);
}

}  // namespace

std::size_t byte_count_of(PlyType type) {
  switch (type) {
    case PlyType::Int8:
    case PlyType::UInt8:
      return 1;
    case PlyType::Int16:
    case PlyType::UInt16:
      return 2;
    case PlyType::Int32:
    case PlyType::UInt32:
    case PlyType::Float32:
      return 4;
    case PlyType::Float64:
      return 8;
  }
  return 0;
}

std::size_t PlyElement::least_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += byte_count_of(property.count_type.value_or(property.type));
  return bytes;
}

std::optional<std::size_t> PlyElement::fixed_bytes(const PlyProperty* besides) const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (&property == besides) continue;
    if (property.count_type) return std::nullopt;
    bytes += byte_count_of(property.type);
  }
  return bytes;
}

PlyHeader read_ply_header(const FileBytes& file) {
  TextLines lines = TextLines::of_header(file);
  PlyHeader header;
  bool has_format = false;
  const bool has_line = lines.next();
  Words first(lines.line());
  if (!has_line || first.next() != "ply" || !first.next().empty())
    lines.fail(quote(lines.line()) + " stands in the place of `ply`");
  while (lines.next()) {
    Words words(lines.line());
    const std::string_view keyword = words.next();
    if (keyword == "end_header") {
      if (!has_format) lines.fail("the header names no format");
      header.byte_count = file.bytes.size() - lines.bytes_left();
      header.line_count = lines.number();
      return header;
    }
    if (keyword == "format") {
      header.format = read_format(words, lines);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(read_element(words, lines));
    } else if (keyword == "property") {
      if (header.elements.empty()) lines.fail("property before the first element");
      add_property(words, lines, header.elements.back());
    } else if (keyword == "comment") {
      const std::size_t begin = words.rest().find_first_not_of(' ');
      header.comments.emplace_back(begin == std::string_view::npos ? ""
                                                                   : words.rest().substr(begin));
    } else if (!keyword.empty() && keyword != "obj_info") {
      pass_over(words, keyword, lines, header);
    }
  }
  lines.fail("the file ends inside the header");
}

TextLines ply_lines_behind(const FileBytes& file, const PlyHeader& header) {
  FileBytes body = file;
  body.bytes = file.bytes.subspan(header.byte_count);
  TextLines lines(body);
  lines.count_from(header.line_count);
  return lines;
}

namespace {

// An entry has at least one digit and one blank or line end for each of its values.
template <class Place>
void require_text_room(const PlyElement& element, std::size_t bytes_left, const Place& place) {
  const std::size_t least = 2 * std::max<std::size_t>(element.properties.size(), 1);
  if (static_cast<std::uint64_t>(element.count) > (bytes_left + 1) / least)
    place.fail(formatted("header promises {} of element {}, but only {} bytes follow",
                         element.count, quote(element.name), bytes_left),
               -1);
}

}  // namespace

void PlyTextBody::require_room(const PlyElement& element) const {
  const TextLines lines = records_.before(first_);
  require_text_room(element, lines.bytes_left(), lines);
}

void PlyWrappedBody::require_room(const PlyElement& element) const {
  require_text_room(element, cursor_.values_left(PlyType::UInt8), cursor_);
}

void PlyBinaryBody::require_room(const PlyElement& element) const {
  const std::size_t least = std::max<std::size_t>(element.least_bytes(), 1);
  if (static_cast<std::uint64_t>(element.count) > bytes_left() / least)
    fail(
        formatted("header promises {} of element {} of at least {} bytes, but only {} bytes follow",
                  element.count, quote(element.name), least, bytes_left()),
        -1);
}

// The counts of lists say where entries begin. Where one is wrong its piece is the last: whoever
// reads it meets the same.
std::size_t PlyBinaryBody::piece_count(const PlyElement& element) {
  places_.clear();
  bytes_ = 0;
  if (const std::optional<std::size_t> stride = element.fixed_bytes()) {
    for (std::int64_t entry = 0; entry < element.count; entry += kPieceEntries)
      places_.push_back(static_cast<std::size_t>(entry) * *stride);
    bytes_ = static_cast<std::size_t>(element.count) * *stride;
    return places_.size();
  }
  PlyBinaryCursor cursor = cursor_;
  const auto place = [&] { return cursor_.bytes_left() - cursor.bytes_left(); };
  try {
    for (std::int64_t entry = 0; entry < element.count; ++entry) {
      if (entry % kPieceEntries == 0) {
        check_stop();
        places_.push_back(place());
      }
      for (const PlyProperty& property : element.properties)
        skip_ply_value(cursor, property, element, entry);
    }
    bytes_ = place();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
  }
  return places_.size();
}

PlyVertexLayout ply_vertex_layout(const PlyElement& element) {
  PlyVertexLayout layout;
  std::vector<int>& slots = layout.slots;
  std::array<bool, kKnownProperties.size()> found{};
  for (const PlyProperty& property : element.properties) {
    const auto slot = std::ranges::find(kKnownProperties, property.name, &KnownProperty::name);
    const bool is_known = slot != kKnownProperties.end() && !property.count_type;
    // Of two names of one thing the first counts.
    const bool is_taken = is_known && !found[slot->slot];
    slots.push_back(is_taken ? slot->slot : -1);
    if (is_taken) found[slot->slot] = true;
  }
  for (const std::size_t axis : {2, 1, 0}) {
    if (!found[axis]) layout.missing_axis = kKnownProperties[axis].name.front();
  }
  // Half of a texture coordinate, of a colour or of a normal is none.
  const bool has_uv = found[3] && found[4], has_color = found[5] && found[6] && found[7],
             has_normal = found[9] && found[10] && found[11];
  for (int& slot : slots) {
    const bool is_whole = slot < 3 || (slot < 5 ? has_uv : slot < 9 ? has_color : has_normal);
    if (!is_whole) slot = -1;
  }
  layout.has_uvs = std::ranges::find(slots, 3) != slots.end();
  layout.has_colors = std::ranges::find(slots, 5) != slots.end();
  layout.has_normals = std::ranges::find(slots, 9) != slots.end();
  return layout;
}

void add_ply_properties(const PlyElement& element, PlyVertexLayout& layout) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.count_type || property.name.empty() ||
        std::ranges::find(kKnownProperties, property.name, &KnownProperty::name) !=
            kKnownProperties.end())
      continue;
    const std::size_t place = layout.properties.names().size();
    if (layout.properties.add(property.name))
      layout.slots[i] = static_cast<int>(kPlyFirstProperty + place);
  }
}

const PlyProperty* ply_vertex_list(const PlyElement& face) {
  for (const PlyProperty& property : face.properties) {
    const bool is_named = property.name == "vertex_indices" || property.name == "vertex_index";
    if (property.count_type && is_named) return &property;
  }
  return nullptr;
}

const PlyProperty* ply_texture_list(const PlyElement& face) {
  const auto found = std::ranges::find(face.properties, "texcoord", &PlyProperty::name);
  return found != face.properties.end() && found->count_type ? &*found : nullptr;
}

double ply_color(double value, PlyType type) {
  if (type == PlyType::Float32 || type == PlyType::Float64) return value;
  const auto bits = 8 * byte_count_of(type);
  const bool is_signed = type == PlyType::Int8 || type == PlyType::Int16 || type == PlyType::Int32;
  return std::clamp(value / (std::ldexp(1, bits - (is_signed ? 1 : 0)) - 1), 0.0, 1.0);
}

namespace {

// Texture coordinates that faces have at their corners, face by face.
class PlyTextureCorners {
 public:
  // Two numbers a corner, or none. Any other count, and numbers that are not finite, are none,
  // too.
  void add_face(std::span<const double> numbers, std::size_t corner_count);

  // Adds the faces behind.
  void append(const PlyTextureCorners& behind);

  // Gives the mesh coordinates, unless no face has any: corners at one vertex with the same
  // coordinates share one, so that there is a seam only where they differ. Warns of faces whose
  // lists were none.
  void finish(MeshFile& file) const;

 private:
  std::vector<glm::dvec2> values_;  // of every corner
  std::vector<std::uint8_t> has_;
  std::int64_t wrong_count_ = 0, first_wrong_ = -1, face_count_ = 0;
};

void PlyTextureCorners::add_face(std::span<const double> numbers, std::size_t corner_count) {
  const bool is_whole =
      numbers.size() == 2 * corner_count &&
      std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
  if (!is_whole && !numbers.empty() && wrong_count_++ == 0) first_wrong_ = face_count_;
  for (std::size_t i = 0; i < corner_count; ++i) {
    values_.push_back(is_whole ? glm::dvec2(numbers[2 * i], numbers[2 * i + 1]) : glm::dvec2(0.0));
    has_.push_back(is_whole ? 1 : 0);
  }
  ++face_count_;
}

void PlyTextureCorners::append(const PlyTextureCorners& behind) {
  if (wrong_count_ == 0 && behind.wrong_count_ > 0)
    first_wrong_ = face_count_ + behind.first_wrong_;
  wrong_count_ += behind.wrong_count_;
  face_count_ += behind.face_count_;
  values_.insert(values_.end(), behind.values_.begin(), behind.values_.end());
  has_.insert(has_.end(), behind.has_.begin(), behind.has_.end());
}

void PlyTextureCorners::finish(MeshFile& file) const {
  if (wrong_count_ > 0)
    file.warnings.push_back(
        {.code = "ignored-texture-coordinates",
         .message = formatted("faces whose list `texcoord` has not two finite numbers for each "
                              "corner, left without texture coordinates: {}",
                              wrong_count_),
         .count = wrong_count_,
         .first = first_wrong_});
  if (std::ranges::find(has_, 1) == has_.end()) return;
  PolygonMesh& mesh = file.mesh;
  std::vector<std::int32_t> corners, lead(has_.size());
  for (std::size_t c = 0; c < has_.size(); ++c)
    if (has_[c] != 0) corners.push_back(static_cast<std::int32_t>(c));
  const auto key_of = [&](std::int32_t c) {
    return std::tuple(mesh.face_vertices[c], values_[c].x, values_[c].y);
  };
  std::ranges::sort(corners, {}, [&](std::int32_t c) { return std::pair(key_of(c), c); });
  // Of those that share one the first corner leads, so that coordinates come in their order.
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool is_first = i == 0 || key_of(corners[i]) != key_of(corners[i - 1]);
    lead[corners[i]] = is_first ? corners[i] : lead[corners[i - 1]];
  }
  mesh.uvs.clear();
  mesh.face_uvs.assign(mesh.face_vertices.size(), -1);
  for (std::size_t c = 0; c < has_.size(); ++c) {
    if (has_[c] == 0) continue;
    const bool leads = lead[c] == static_cast<std::int32_t>(c);
    mesh.face_uvs[c] = leads ? static_cast<std::int32_t>(mesh.uvs.size()) : mesh.face_uvs[lead[c]];
    if (leads) mesh.uvs.push_back(values_[c]);
  }
}

// Based on: G. Turk, "The PLY Polygon File Format", 1994.

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
