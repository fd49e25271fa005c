#include "planish/files/ply/ply_vertex_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "planish/files/shared/identifier.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

struct Slot {
  std::string_view name;
  int index;
};
constexpr std::array<Slot, 16> kSlots = {{{"x", 0},
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
                                          {"alpha", 8},
                                          {"nx", 9},
                                          {"ny", 10},
                                          {"nz", 11}}};

constexpr std::size_t kMostNameBytes = 64;
// Names of USD, which knows the others apart by their case.
constexpr std::array<std::string_view, 3> kTakenNames = {"st", "displaycolor", "displayopacity"};

std::string lower(std::string name) {
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return name;
}

}  // namespace

PlyVertexLayout ply_vertex_layout(const PlyElement& element) {
  PlyVertexLayout layout;
  std::vector<int>& slots = layout.slots;
  std::array<bool, kSlots.size()> found{};
  for (const PlyProperty& property : element.properties) {
    const auto slot = std::ranges::find(kSlots, property.name, &Slot::name);
    const bool is_known = slot != kSlots.end() && !property.count_type;
    slots.push_back(is_known ? slot->index : -1);
    if (is_known) found[slot->index] = true;
  }
  for (const std::size_t axis : {2, 1, 0}) {
    if (!found[axis]) layout.missing_axis = kSlots[axis].name.front();
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
  std::set<std::string, std::less<>> taken(kTakenNames.begin(), kTakenNames.end());
  for (const Slot& slot : kSlots) taken.emplace(slot.name);
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.count_type || property.name.empty() ||
        std::ranges::find(kSlots, property.name, &Slot::name) != kSlots.end())
      continue;
    std::string name = identifier_of(property.name);
    if (layout.properties.size() < kMaxPlyProperties && name.size() <= kMostNameBytes &&
        taken.insert(lower(name)).second) {
      layout.slots[i] = static_cast<int>(kPlyFirstProperty + layout.properties.size());
      layout.properties.push_back(std::move(name));
    } else if (layout.left_out_count++ == 0) {
      layout.left_out = property.name;
    }
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

double ply_color(double value, PlyType type, bool is_alpha) {
  if (type == PlyType::Float32 || type == PlyType::Float64) return std::clamp(value, 0.0, 1.0);
  const auto bits = 8 * byte_count_of(type);
  const bool is_signed = type == PlyType::Int8 || type == PlyType::Int16 || type == PlyType::Int32;
  const double share =
      std::clamp(value / (std::ldexp(1, bits - (is_signed ? 1 : 0)) - 1), 0.0, 1.0);
  return is_alpha ? share : linear_of_srgb(share);
}

}  // namespace planish
