// Based on: Khronos, "glTF 2.0 Specification", 2021, sections 3.6 and 4.4.
#include "planish/files/gltf/gltf_layout.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>

#include "planish/core/error.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

// Attributes in the order in which they are written.
struct Attribute {
  std::string name;
  std::string_view type;
  std::uint64_t bytes;  // of a vertex
  GltfComponent component = GltfComponent::Float;
  int uv_sets = 0;  // that a primitive has which has it
  int place = -1;   // among GltfLayout::attributes
  const GltfAttribute* given = nullptr;

  [[nodiscard]] bool belongs_to(const GltfPrimitive& primitive) const {
    return uv_sets <= primitive.uv_sets && (given == nullptr || given->is_in(primitive.group));
  }
};

std::string_view type_name(int width) {
  constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  return kTypes[width - 1];
}

std::vector<Attribute> attributes_of(const GltfLayout& layout) {
  std::vector<Attribute> attributes{{"POSITION", "VEC3", 12}, {"NORMAL", "VEC3", 12}};
  int sets = 0;
  for (const GltfPrimitive& primitive : layout.primitives) sets = std::max(sets, primitive.uv_sets);
  for (int set = 0; set < sets; ++set)
    attributes.push_back({.name = uv_name(set), .type = "VEC2", .bytes = 8, .uv_sets = set + 1});
  if (layout.has_colors) attributes.push_back({"COLOR_0", "VEC4", 16});
  for (std::size_t i = 0; i < layout.attributes.size(); ++i) {
    const GltfAttribute& attribute = layout.attributes[i];
    attributes.push_back(
        {.name = attribute.name,
         .type = type_name(attribute.width),
         .bytes = attribute_bytes(attribute),
         .component = attribute.is_integer ? GltfComponent::UnsignedShort : GltfComponent::Float,
         .place = static_cast<int>(i),
         .given = &attribute});
  }
  return attributes;
}

// glTF wants an underscore before names of one's own, and capitals.
std::string own_name(const std::string& field) {
  std::string name = "_";
  for (const char c : field) name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
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

std::uint32_t GltfPrimitive::index_size() const {
  return vertex_count <= kMaxShortIndexVertices ? 2 : 4;
}

GltfLayout gltf_layout(std::uint64_t vertex_count, std::uint64_t triangle_count) {
  GltfLayout layout;
  GltfPrimitive& primitive = layout.primitives.emplace_back();
  primitive.vertex_count = vertex_count;
  primitive.triangle_count = triangle_count;
  set_sizes(layout);
  return layout;
}

void set_sizes(GltfLayout& layout) {
  layout.vertex_count = layout.triangle_count = layout.buffer_bytes = 0;
  for (const GltfPrimitive& primitive : layout.primitives) {
    layout.vertex_count += primitive.vertex_count;
    layout.triangle_count += primitive.triangle_count;
    for (const Attribute& attribute : attributes_of(layout)) {
      if (attribute.belongs_to(primitive))
        layout.buffer_bytes += attribute.bytes * primitive.vertex_count;
    }
    layout.buffer_bytes += padded(primitive.index_bytes());
  }
}

GltfDocument plain_document(const GltfLayout& layout, std::span<const GltfBounds> bounds,
                            const GltfOptions& options) {
  GltfDocument document;
  document.translation = StoredPosition(options).translation();
  document.buffer_bytes = layout.buffer_bytes;
  std::uint64_t offset = 0;
  const auto add = [&](GltfArray array, std::uint64_t bytes) {
    array.offset = offset;
    array.bytes = bytes;
    document.arrays.push_back(array);
    offset += padded(bytes);
    return document.arrays.size() - 1;
  };
  document.primitives.resize(layout.primitives.size());
  for (const Attribute& attribute : attributes_of(layout)) {
    for (std::size_t i = 0; i < layout.primitives.size(); ++i) {
      const GltfPrimitive& primitive = layout.primitives[i];
      if (!attribute.belongs_to(primitive)) continue;
      GltfArray array{.type = attribute.type,
                      .component = attribute.component,
                      .count = primitive.vertex_count};
      // Bytes that are skipped.
      if (attribute.given != nullptr && attribute.given->is_integer &&
          attribute.given->width % 2 != 0)
        array.stride = static_cast<std::uint32_t>(attribute.bytes);
      if (attribute.name == "POSITION") array.bounds = bounds[i];
      if (attribute.place >= 0 && !primitive.bounds.empty())
        array.bounds = primitive.bounds[attribute.place];
      document.primitives[i].attributes[attribute.name] =
          add(array, attribute.bytes * primitive.vertex_count);
    }
  }
  for (std::size_t i = 0; i < layout.primitives.size(); ++i) {
    const GltfPrimitive& primitive = layout.primitives[i];
    document.primitives[i].indices =
        add({.type = "SCALAR",
             .component = primitive.index_size() == 2 ? GltfComponent::UnsignedShort
                                                      : GltfComponent::UnsignedInt,
             .count = 3 * primitive.triangle_count,
             .is_indices = true},
            primitive.index_bytes());
    document.primitives[i].name = primitive.name;
    document.primitives[i].material = primitive.material;
    document.primitives[i].group = primitive.group;
    document.primitives[i].encodes_ngons = primitive.encodes_ngons;
  }
  return document;
}

std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                             std::string_view name) {
  const std::uint64_t bytes =
      kGlbHeaderBytes + 2 * kGlbChunkHeaderBytes + padded(json_bytes) + padded(buffer_bytes);
  if (bytes > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} bytes are more than a .glb file can hold (4294967295); write "
                          ".gltf, whose .bin has no such limit, or use fewer levels",
                          name, bytes));
  }
  return bytes;
}

}  // namespace planish
