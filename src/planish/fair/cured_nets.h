#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/fair/fair_net.h"

namespace planish {

/// Nets of one mesh whose decisions differ in those of the cure alone (cures, leans, ellipses): all
/// that comes before it is made once, with the first. Made in fair_net.cpp.
class CuredNets {
 public:
  /// As for fair_net(); callbacks and decisions come with each net. The mesh, `subdivision`,
  /// `given` and the halo outlive this.
  CuredNets(const PolygonMesh& mesh, const Subdivision& subdivision,
            std::span<const glm::dvec3> given, const FairOptions& options);
  ~CuredNets();

  /// The bits of fair_net() with these decisions; also throws as that does.
  [[nodiscard]] FairNet net(const FairDecisions& decisions, const Callbacks& callbacks = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planish
