#pragma once

#include <cstdint>
#include <vector>

#include "planish/patches/patch_mesh.h"
#include "planish/vulkan/evaluate/patch_records.h"

namespace planish::vulkan {

/// What edits must know of a mesh beside what all frames do. Lists of a vertex: words [v] to
/// [v + 1] say where it begins and ends among all words.
struct EditRecords {
  std::vector<std::uint32_t> slots;   ///< per row of the limit masks, DeviceTable::slots()
  std::vector<std::uint32_t> places;  ///< lists: corners at the vertex, points that it owns beside
                                      ///< sharp edges and at corner vertices
  std::vector<std::uint32_t> jobs;    ///< lists: patches whose points its faces have, ascending
  std::uint64_t job_count = 0;        ///< lanes of all groups of patches
};

/// `patches` were made of `mesh`, with their owners. Throws Error{OutOfMemory} where words do not
/// count the jobs.
[[nodiscard]] EditRecords edit_records(const PatchMesh& mesh, const PatchRecords& patches,
                                       std::vector<std::uint32_t> slots);

}  // namespace planish::vulkan
