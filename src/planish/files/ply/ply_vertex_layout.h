#pragma once

#include <cstddef>
#include <vector>

#include "planish/files/ply/ply_header.h"
#include "planish/files/shared/property_names.h"

namespace planish {

/// The slot of the first further property of a vertex.
inline constexpr std::size_t kPlyFirstProperty = 12;

/// Where each property of a vertex goes.
struct PlyVertexLayout {
  /// By property: 0 to 2 the coordinates, 3 and 4 the texture coordinates, 5 to 8 the colour, 9
  /// to 11 the normal, from 12 on further properties; -1 for what is passed over.
  std::vector<int> slots;
  bool has_uvs = false, has_colors = false, has_normals = false;
  bool takes_missing = false;  ///< coordinates may be NaN
  char missing_axis = 0;       ///< a coordinate that the element lacks, as x
  PropertyNames properties;    ///< further ones
};

[[nodiscard]] PlyVertexLayout ply_vertex_layout(const PlyElement& element);

/// Gives slots to further properties, numbers of any name that the format's convention does not
/// know: see PropertyNames.
void add_ply_properties(const PlyElement& element, PlyVertexLayout& layout);

/// The list of a face's vertices, null if it has none.
[[nodiscard]] const PlyProperty* ply_vertex_list(const PlyElement& face);

/// The list of texture coordinates of a face's corners, two numbers each; null if it has none.
[[nodiscard]] const PlyProperty* ply_texture_list(const PlyElement& face);

/// Of a colour or its alpha: integers as shares of their type's largest, floating-point numbers as
/// they are, for settle_colors().
[[nodiscard]] double ply_color(double value, PlyType type);

}  // namespace planish
