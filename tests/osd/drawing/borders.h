#pragma once

#include <opensubdiv/far/patchTable.h>

#include <vector>

#include "osd/drawing/drawn_patches.h"

namespace planish::testing {

struct Patch {
  OpenSubdiv::Far::PatchTable::PatchHandle handle;
  OpenSubdiv::Far::PatchParam param;
  int type;
};
[[nodiscard]] std::vector<Patch> patches_of(const OpenSubdiv::Far::PatchTable& table);
[[nodiscard]] bool is_triangle(int type);

/// Edges of triangles whose ends are not, bit by bit, those of an opposite one; how many.
[[nodiscard]] int loose_edges(const std::vector<DrawnVertex>& vertices);

/// Between the borders that patches of a closed mesh share; their ends are far apart.
[[nodiscard]] float widest_gap(const std::vector<Patch>& patches,
                               const std::vector<DrawnVertex>& vertices, float extent);

}  // namespace planish::testing
