#include "planish/files/ply/ply_vertex_layout.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace planish {
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

}  // namespace planish
