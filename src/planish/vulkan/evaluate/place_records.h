#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/patch_mesh.h"
#include "planish/vulkan/evaluate/patch_records.h"

namespace planish::vulkan {

/// What the kernel of places knows of a mesh beside PatchRecords::links; see shaders/shared.h.
struct PlaceRecords {
  std::vector<std::uint32_t> words;
  std::vector<std::array<float, 4>> weights;
  std::uint32_t face_count = 0;
  std::uint32_t corner_count = 0;
};

/// Throws Error{OutOfMemory}, naming the limit, before memory is taken for the weights.
[[nodiscard]] PlaceRecords place_records(const PatchMesh& mesh, Weights weights,
                                         const PatchLimits& limits);

}  // namespace planish::vulkan
