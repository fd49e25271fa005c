#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <string>

#include "planish/core/visible_text.h"
#include "planish/files/ply/ply_body.h"
#include "planish/files/ply/ply_vertex_layout.h"

namespace planish {

/// What was made the best of.
struct PlyNotes {
  LineNote excess, color, uv, property;

  void join(const PlyNotes& behind) {
    excess.join(behind.excess);
    color.join(behind.color);
    uv.join(behind.uv);
    property.join(behind.property);
  }
};

/// What a vertex has, by the slots of PlyVertexLayout.
struct PlyVertex {
  std::array<double, kPlyFirstProperty + kMaxProperties> values;  // properties: if there

  [[nodiscard]] glm::dvec3 position() const { return {values[0], values[1], values[2]}; }
  [[nodiscard]] glm::dvec2 uv() const { return {values[3], values[4]}; }  ///< NaN: none
  [[nodiscard]] glm::vec4 color() const { return {values[5], values[6], values[7], values[8]}; }
  [[nodiscard]] glm::vec3 normal() const { return {values[9], values[10], values[11]}; }
  [[nodiscard]] float property(std::size_t k) const {
    return static_cast<float>(values[kPlyFirstProperty + k]);
  }
};

/// Reads an entry of the element `vertex`. Colours that are no numbers are NaN, and noted, as
/// texture coordinates are; further properties are 0 there, and noted. Throws
/// Error{UnreadableInput} for positions that are none.
template <class Cursor>
PlyVertex read_ply_vertex(Cursor& cursor, const PlyElement& element, const PlyVertexLayout& layout,
                          std::int64_t vertex, PlyNotes& notes) {
  PlyVertex found;
  auto& values = found.values;
  std::fill_n(values.begin(), kPlyFirstProperty, 0.0);
  values[8] = 1;  // opaque
  std::optional<std::size_t> bad_uv, bad_color, bad_property;
  const auto fault = [&](std::size_t i) {
    return place_of(element, vertex) + ": " + visible(element.properties[i].name) + " is " +
           shortest(values[layout.slots[i]]);
  };
  for (std::size_t i = 0; i < layout.slots.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const int slot = layout.slots[i];
    if (slot < 0) {
      skip_ply_value(cursor, property, element, vertex);
    } else if (slot < 3) {
      values[slot] = layout.takes_missing ? cursor.any_number(property.type, element, vertex)
                                          : cursor.number(property.type, element, vertex);
      const bool is_missing = layout.takes_missing && std::isnan(values[slot]);
      if (!std::isfinite(values[slot]) && !is_missing) cursor.fail(fault(i), vertex);
    } else if (slot > 8) {
      values[slot] = cursor.number_or_nan(property.type, element, vertex);
      const bool is_property = slot >= static_cast<int>(kPlyFirstProperty);
      const bool is_good = is_property ? std::isfinite(static_cast<float>(values[slot]))
                                       : std::isfinite(values[slot]);
      if (is_good) continue;
      if (is_property && !bad_property) {
        bad_property = i;
        cursor.note(notes.property, fault(i), vertex);
      }
      values[slot] = 0;
    } else {
      values[slot] = cursor.any_number(property.type, element, vertex);
      std::optional<std::size_t>& bad = slot < 5 ? bad_uv : bad_color;
      if (!std::isfinite(values[slot])) {
        if (!bad) bad = i;
      } else if (slot >= 5) {
        values[slot] = ply_color(values[slot], property.type);
      }
    }
  }
  if (bad_color) {
    cursor.note(notes.color, fault(*bad_color), vertex);
    std::fill_n(values.begin() + 5, 4, std::numeric_limits<double>::quiet_NaN());
  }
  if (bad_uv) {
    cursor.note(notes.uv, fault(*bad_uv), vertex);
    values[3] = values[4] = std::numeric_limits<double>::quiet_NaN();
  }
  return found;
}

}  // namespace planish
