#include "planish/fair/tensor_share.h"

#include <algorithm>

#include "planish/fair/crease_handle.h"
#include "planish/fair/masked_iteration.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

namespace {

using glm::dvec3;

// Imbalance from which the share falls below 1, and where it reaches 0: at 1 translation would put
// a control point on the edge of its wedge.
constexpr double kFullShareBelow = 0.4;
constexpr double kNoShareFrom = 0.9;
// Where neighbours move together they do not meet, but not all neighbours are asked: such an
// imbalance counts this much.
constexpr double kRelativeWeight = 2.0;

// How far the limit point moves beyond those of its neighbours. Where a row of quads bends in its
// tangent plane all of them move together, far out of narrow wedges, and nothing folds.
dvec3 relative_error(const FairTopology& topology, std::span<const dvec3> given,
                     std::span<const dvec3> corner_offsets, std::int32_t vertex) {
  const auto error = [&](std::int32_t v) {
    return limit_error(topology, given, given, corner_offsets, v);
  };
  dvec3 around(0.0);
  for (const std::int32_t other : topology.ring(vertex).next) around += error(other);
  return error(vertex) - around / static_cast<double>(topology.valence(vertex));
}

double share_of(double rho) {
  return std::clamp((kNoShareFrom - rho) / (kNoShareFrom - kFullShareBelow), 0.0, 1.0);
}

}  // namespace

double tensor_share(const FairTopology& topology, std::span<const dvec3> given,
                    std::span<const dvec3> corner_offsets, const dvec3& normal, std::int32_t vertex,
                    PlanarRing& scratch) {
  if (!topology.is_regular[vertex] || topology.kind(vertex) == VertexKind::Corner) return 0;
  if (topology.kind(vertex) == VertexKind::Crease) {
    return share_of(imbalance(crease_arms(topology, given, vertex)));
  }
  const VertexFrame frame = frame_of(normal);
  project_ring(given, corner_offsets, vertex, topology.ring(vertex), frame, scratch);
  const double rho = imbalance(scratch);
  if (rho <= kFullShareBelow) return 1;
  scratch.mean = frame.project(relative_error(topology, given, corner_offsets, vertex));
  return share_of(std::min(rho, kRelativeWeight * imbalance(scratch)));
}

}  // namespace planish
