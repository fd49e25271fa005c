#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/patches/patch_evaluator.h"
#include "planish/vulkan/backend/vulkan_machine.h"

namespace planish::vulkan {

/// PatchEvaluator::evaluate_patches() on the command's device.
void evaluate_patches(VulkanMachine& machine, const PatchSurface& surface,
                      std::span<const glm::dvec3> state, std::span<PatchEvaluator::Row> rows);

}  // namespace planish::vulkan
