// Based on: G. Turk, "The PLY Polygon File Format", 1994.
#include "planish/files/ply/read_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "planish/core/error.h"
#include "planish/files/ply/ply_header.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/srgb.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max() - 1;

// Where in the file an error is: "vertex 12 of 345".
std::string place_of(const PlyElement& element, std::int64_t index) {
  return element.name + " " + std::to_string(index) + " of " + std::to_string(element.count);
}

class TextBody {
 public:
  TextBody(std::span<const std::byte> bytes, std::string_view name)
      : lines_(bytes, name), words_("") {}

  void skip_header(const PlyHeader& header) {
    while (lines_.number() < header.line_count) (void)lines_.next();
  }
  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    lines_.fail(what, index);
  }
  // An entry has at least one digit and one blank or line end for each of its values.
  void require_room(const PlyElement& element) const {
    const std::size_t least = 2 * std::max<std::size_t>(element.properties.size(), 1);
    if (static_cast<std::uint64_t>(element.count) > (lines_.bytes_left() + 1) / least)
      lines_.fail("header promises " + std::to_string(element.count) + " of element " +
                  quote(element.name) + ", but only " + std::to_string(lines_.bytes_left()) +
                  " bytes follow");
  }
  void begin(const PlyElement& element, std::int64_t index) {
    if (!lines_.next_with_words())
      lines_.fail("the file ends at " + place_of(element, index), index);
    words_ = Words(lines_.line());
  }
  void end(const PlyElement& element, std::int64_t index) {
    if (const std::string_view word = words_.next(); !word.empty())
      lines_.fail(place_of(element, index) + " has a value too many: " + quote(word), index);
  }
  void skip(PlyType, const PlyElement& element, std::int64_t index) { (void)word(element, index); }
  double number(PlyType, const PlyElement& element, std::int64_t index) {
    const std::string_view text = word(element, index);
    double value = 0;
    if (!parse_number(text, value))
      lines_.fail(place_of(element, index) + ": " + quote(text) + " is no finite number", index);
    return value;
  }
  [[nodiscard]] std::size_t values_left(PlyType) const { return words_.rest().size(); }

 private:
  std::string_view word(const PlyElement& element, std::int64_t index) {
    const std::string_view text = words_.next();
    if (text.empty()) lines_.fail(place_of(element, index) + " has too few values", index);
    return text;
  }

  TextLines lines_;
  Words words_;
};

class BinaryBody {
 public:
  BinaryBody(std::span<const std::byte> bytes, std::string_view name) : left_(bytes), name_(name) {}

  void skip_header(const PlyHeader& header) {
    left_ = left_.subspan(header.byte_count);
    order_ = header.format == PlyFormat::BigEndian ? std::endian::big : std::endian::little;
  }
  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what, index);
  }
  void require_room(const PlyElement& element) const {
    const std::size_t least = std::max<std::size_t>(element.least_bytes(), 1);
    if (static_cast<std::uint64_t>(element.count) > left_.size() / least)
      fail("header promises " + std::to_string(element.count) + " of element " +
               quote(element.name) + " of at least " + std::to_string(least) + " bytes, but only " +
               std::to_string(left_.size()) + " bytes follow",
           -1);
  }
  void begin(const PlyElement&, std::int64_t) {}
  void end(const PlyElement&, std::int64_t) {}
  void skip(PlyType type, const PlyElement& element, std::int64_t index) {
    (void)take(byte_count_of(type), element, index);
  }
  double number(PlyType type, const PlyElement& element, std::int64_t index) {
    const auto bytes = take(byte_count_of(type), element, index);
    switch (type) {
      case PlyType::Int8:
        return load<std::int8_t>(bytes, order_);
      case PlyType::UInt8:
        return load<std::uint8_t>(bytes, order_);
      case PlyType::Int16:
        return load<std::int16_t>(bytes, order_);
      case PlyType::UInt16:
        return load<std::uint16_t>(bytes, order_);
      case PlyType::Int32:
        return load<std::int32_t>(bytes, order_);
      case PlyType::UInt32:
        return load<std::uint32_t>(bytes, order_);
      case PlyType::Float32:
        return load<float>(bytes, order_);
      case PlyType::Float64:
        return load<double>(bytes, order_);
    }
    return 0;
  }
  [[nodiscard]] std::size_t values_left(PlyType type) const {
    return left_.size() / byte_count_of(type);
  }

 private:
  std::span<const std::byte> take(std::size_t count, const PlyElement& element,
                                  std::int64_t index) {
    if (count > left_.size()) fail("the file ends at " + place_of(element, index), index);
    const auto bytes = left_.first(count);
    left_ = left_.subspan(count);
    return bytes;
  }

  std::span<const std::byte> left_;
  std::string name_;
  std::endian order_ = std::endian::little;
};

struct Slot {
  std::string_view name;
  int index;
};
constexpr std::array<Slot, 13> kSlots = {{{"x", 0},
                                          {"y", 1},
                                          {"z", 2},
                                          {"s", 3},
                                          {"t", 4},
                                          {"u", 3},
                                          {"v", 4},
                                          {"texture_u", 3},
                                          {"texture_v", 4},
                                          {"red", 5},
                                          {"green", 6},
                                          {"blue", 7},
                                          {"alpha", 8}}};

// Linear, 0 to 1. Integers are sRGB by convention, floating-point numbers are linear.
double color_of(double value, PlyType type, bool is_alpha) {
  if (type == PlyType::Float32 || type == PlyType::Float64) return std::clamp(value, 0.0, 1.0);
  const auto bits = 8 * byte_count_of(type);
  const bool is_signed = type == PlyType::Int8 || type == PlyType::Int16 || type == PlyType::Int32;
  const double share =
      std::clamp(value / (std::ldexp(1, bits - (is_signed ? 1 : 0)) - 1), 0.0, 1.0);
  return is_alpha ? share : linear_of_srgb(share);
}

template <class Body>
class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, std::string_view name, const PlyHeader& header)
      : body_(bytes, name), header_(header) {
    body_.skip_header(header);
  }

  MeshFile read() {
    file_.format = FileFormat::Ply;
    for (const std::string& comment : header_.comments)
      if (comment.starts_with("planish ")) file_.header.push_back(comment);
    vertex_count_ = require_single("vertex");
    if (vertex_count_ < 0) body_.fail("the header has no element `vertex`", -1);
    (void)require_single("face");
    for (const PlyElement& element : header_.elements) read_element(element);
    if (!file_.mesh.uvs.empty()) file_.mesh.face_uvs = file_.mesh.face_vertices;
    return std::move(file_);
  }

 private:
  std::int64_t require_single(std::string_view name);
  void read_element(const PlyElement& element);
  std::vector<int> vertex_slots(const PlyElement& element) const;
  void read_vertices(const PlyElement& element);
  void read_faces(const PlyElement& element);
  void skip_all(const PlyElement& element);
  void skip(const PlyProperty& property, const PlyElement& element, std::int64_t index);
  std::int64_t read_count(const PlyProperty& property, const PlyElement& element,
                          std::int64_t index);

  Body body_;
  const PlyHeader& header_;
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
  skip_all(element);
}

// Where each property of a vertex goes: the coordinates, texture coordinates, colours; -1 for what
// is passed over.
template <class Body>
std::vector<int> PlyReader<Body>::vertex_slots(const PlyElement& element) const {
  std::vector<int> slots;
  std::array<bool, kSlots.size()> found{};
  for (const PlyProperty& property : element.properties) {
    const auto slot = std::ranges::find(kSlots, property.name, &Slot::name);
    const bool is_known = slot != kSlots.end() && !property.count_type;
    slots.push_back(is_known ? slot->index : -1);
    if (is_known) found[slot->index] = true;
  }
  for (const std::size_t axis : {0, 1, 2}) {
    if (!found[axis])
      body_.fail("element `vertex` has no property " + quote(kSlots[axis].name), -1);
  }
  // Half of a texture coordinate or of a colour is none.
  for (int& slot : slots) {
    const bool is_uv = slot == 3 || slot == 4;
    const bool is_half = is_uv ? !found[3] || !found[4] : !found[5] || !found[6] || !found[7];
    if (slot > 2 && is_half) slot = -1;
  }
  return slots;
}

template <class Body>
void PlyReader<Body>::read_vertices(const PlyElement& element) {
  const std::vector<int> slots = vertex_slots(element);
  const bool has_uvs = std::ranges::find(slots, 3) != slots.end();
  const bool has_colors = std::ranges::find(slots, 5) != slots.end();
  if (element.count > kMaxCount)
    body_.fail("more vertices than 32 bits can count: " + std::to_string(element.count), -1);
  PolygonMesh& mesh = file_.mesh;
  mesh.positions.reserve(element.count);
  for (std::int64_t vertex = 0; vertex < element.count; ++vertex) {
    body_.begin(element, vertex);
    std::array<double, 9> values{};
    values[8] = 1;  // opaque
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (slots[i] < 0) {
        skip(property, element, vertex);
        continue;
      }
      const double value = body_.number(property.type, element, vertex);
      if (!std::isfinite(value))
        body_.fail(place_of(element, vertex) + ": " + property.name + " is " + shortest(value),
                   vertex);
      values[slots[i]] = slots[i] < 5 ? value : color_of(value, property.type, slots[i] == 8);
    }
    body_.end(element, vertex);
    mesh.positions.emplace_back(values[0], values[1], values[2]);
    if (has_uvs) mesh.uvs.emplace_back(values[3], values[4]);
    if (has_colors) mesh.colors.emplace_back(values[5], values[6], values[7], values[8]);
  }
}

template <class Body>
void PlyReader<Body>::read_faces(const PlyElement& element) {
  const auto is_indices = [](const PlyProperty& property) {
    return property.count_type &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  const auto indices = std::ranges::find_if(element.properties, is_indices);
  if (element.count > 0 && indices == element.properties.end())
    body_.fail("element `face` has no list `vertex_indices`", -1);
  if (element.count > kMaxCount)
    body_.fail("more faces than 32 bits can count: " + std::to_string(element.count), -1);
  auto& corners = file_.mesh.face_vertices;
  file_.mesh.face_offsets.reserve(element.count + 1);
  for (std::int64_t face = 0; face < element.count; ++face) {
    body_.begin(element, face);
    for (const PlyProperty& property : element.properties) {
      if (&property != &*indices) {
        skip(property, element, face);
        continue;
      }
      const std::int64_t size = read_count(property, element, face);
      for (std::int64_t i = 0; i < size; ++i) {
        const double vertex = body_.number(property.type, element, face);
        // The negated comparison catches NaN.
        if (!(vertex >= 0 && vertex < static_cast<double>(vertex_count_)) ||
            vertex != std::floor(vertex))
          body_.fail(place_of(element, face) + " names vertex " + shortest(vertex) + " of " +
                         std::to_string(vertex_count_),
                     face);
        corners.push_back(static_cast<std::int32_t>(vertex));
      }
    }
    body_.end(element, face);
    if (corners.size() > static_cast<std::size_t>(kMaxCount))
      body_.fail("more face corners than 32 bits can count", face);
    file_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
  }
}

template <class Body>
void PlyReader<Body>::skip_all(const PlyElement& element) {
  for (std::int64_t index = 0; index < element.count; ++index) {
    body_.begin(element, index);
    for (const PlyProperty& property : element.properties) skip(property, element, index);
    body_.end(element, index);
  }
}

template <class Body>
void PlyReader<Body>::skip(const PlyProperty& property, const PlyElement& element,
                           std::int64_t index) {
  const std::int64_t count = property.count_type ? read_count(property, element, index) : 1;
  for (std::int64_t i = 0; i < count; ++i) body_.skip(property.type, element, index);
}

template <class Body>
std::int64_t PlyReader<Body>::read_count(const PlyProperty& property, const PlyElement& element,
                                         std::int64_t index) {
  const double count = body_.number(*property.count_type, element, index);
  if (count < 0 || count != std::floor(count) ||
      count > static_cast<double>(body_.values_left(property.type)))
    body_.fail(place_of(element, index) + ": list " + quote(property.name) + " promises " +
                   shortest(count) + " values, but no more than " +
                   std::to_string(body_.values_left(property.type)) + " can follow",
               index);
  return static_cast<std::int64_t>(count);
}

}  // namespace

MeshFile read_ply(std::span<const std::byte> bytes, std::string_view name) {
  const PlyHeader header = read_ply_header(bytes, name);
  if (header.format == PlyFormat::Text) return PlyReader<TextBody>(bytes, name, header).read();
  return PlyReader<BinaryBody>(bytes, name, header).read();
}

PointCloud read_ply_points(std::span<const std::byte> bytes, std::string_view name) {
  MeshFile file = read_ply(bytes, name);
  PointCloud cloud = cloud_of(std::move(file.mesh.positions), name);
  cloud.warnings = std::move(file.warnings);
  return cloud;
}

}  // namespace planish
