#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// What a backend also is that builds fair nets on its device. For the others there is fair_net().
class FairBuilder {
 public:
  virtual ~FairBuilder() = default;

  /// As fair_net(), in the device's precision. Also throws Error{OutOfMemory}, naming the limit,
  /// and Error{DeviceLost}.
  [[nodiscard]] virtual FairNet build_fair_net(const FairTopology& topology,
                                               std::span<const glm::dvec3> given,
                                               const FairOptions& options) = 0;
};

}  // namespace planish
