#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_builder.h"
#include "planish/vulkan/backend/vulkan_machine.h"

namespace planish::vulkan {

/// The fair net of a topology in one submission, in float relative to the given points. Throws as
/// FairBuilder says.
[[nodiscard]] FairNet build_fair_net(VulkanMachine& machine, const FairTopology& topology,
                                     std::span<const glm::dvec3> given, const FairOptions& options);

}  // namespace planish::vulkan
