#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish {

/// Triangles of a mesh that give way to fewer or as many new ones.
struct TriangleChange {
  std::int32_t removed_vertex = -1;     ///< whose point is a vertex no more; -1: none
  std::int32_t added_point = -1;        ///< that becomes a vertex; -1: none
  std::vector<std::int32_t> old_slots;  ///< indices of the triangles that go
  std::vector<Triangle> triangles;      ///< that come
  std::vector<std::int32_t> slots;      ///< indices that they take, all of them among old_slots

  void clear() {
    removed_vertex = added_point = -1;
    old_slots.clear();
    triangles.clear();
    slots.clear();
  }
};

}  // namespace planish
