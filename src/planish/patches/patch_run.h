#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/mesh/placement.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/patch_surface.h"

namespace planish {

// What all who make plans and run them share.

/// Adds an item to its bucket, which is made if there is none.
void add_item(const PatchPlace& place, std::int32_t class_index, std::int32_t first_sample,
              std::int32_t sample_count, PatchPlan::Results results, std::int64_t target,
              PatchPlan& plan);

/// Gathers the indices and targets of a plan's items.
void gather_items(const PatchMesh& mesh, const PatchClasses& classes, PatchPlan& plan);

/// Where the kernel writes; `offset` is the target's row of row 0 of a plan.
[[nodiscard]] PatchOutput output_at(const Placement& placement, const PatchTarget& target,
                                    std::ptrdiff_t offset);

/// Whether a normal came out zero.
[[nodiscard]] bool run_plan(const PatchClasses& classes, PatchKernel kernel, const PatchPlan& plan,
                            const PatchOutput& output, const double* state);

/// Any rows of a surface, which are named in ascending order, none twice: the same bits as
/// PatchSurface::rows() gives, at the cost of the rows of the corners that they lie in. The target
/// has a place for each. On the calling thread.
DegenerateRows patch_rows_at(const PatchSurface& surface, std::span<const glm::dvec3> state,
                             const Placement& placement, std::span<const std::int32_t> rows,
                             const PatchTarget& target);

}  // namespace planish
