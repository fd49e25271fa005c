#include "planish/fair/tensor_share.h"

#include <algorithm>

#include "planish/core/work.h"
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

// Faces around a vertex from which on its error is made once.
constexpr std::int32_t kHubValence = 64;

// How far the limit point moves beyond those of its neighbours. Where a row of quads bends in its
// tangent plane all of them move together, far out of narrow wedges, and nothing folds.
dvec3 relative_error(const GivenErrors& errors, std::int32_t vertex) {
  dvec3 around(0.0);
  for (const std::int32_t other : errors.topology.ring(vertex).next) around += errors.of(other);
  return errors.of(vertex) - around / static_cast<double>(errors.topology.valence(vertex));
}

double share_of(double rho) {
  return std::clamp((kNoShareFrom - rho) / (kNoShareFrom - kFullShareBelow), 0.0, 1.0);
}

}  // namespace

GivenErrors::GivenErrors(const FairTopology& of, std::span<const dvec3> points,
                         std::span<const dvec3> offsets)
    : topology(of), given(points), corner_offsets(offsets) {
  for (std::int32_t v = 0; v < topology.vertex_count; ++v)
    if (is_hub(v)) of_hubs_.emplace(v, made(v));
}

bool GivenErrors::is_hub(std::int32_t vertex) const {
  return topology.valence(vertex) >= kHubValence;
}

dvec3 GivenErrors::made(std::int32_t vertex) const {
  if (is_hub(vertex)) count_work(Work::Points, topology.valence(vertex));
  return limit_error(topology, given, given, corner_offsets, vertex);
}

dvec3 GivenErrors::of(std::int32_t vertex) const {
  return is_hub(vertex) ? of_hubs_.at(vertex) : made(vertex);
}

double tensor_share(const GivenErrors& errors, const dvec3& normal, std::int32_t vertex,
                    PlanarRing& scratch) {
  const FairTopology& topology = errors.topology;
  if (!topology.is_regular[vertex] || topology.kind(vertex) == VertexKind::Corner) return 0;
  if (topology.kind(vertex) == VertexKind::Crease) {
    return share_of(imbalance(crease_arms(topology, errors.given, vertex)));
  }
  const VertexFrame frame = frame_of(normal);
  project_ring(errors.given, errors.corner_offsets, vertex, topology.ring(vertex), frame, scratch);
  const double rho = imbalance(scratch);
  if (rho <= kFullShareBelow) return 1;
  scratch.mean = frame.project(relative_error(errors, vertex));
  return share_of(std::min(rho, kRelativeWeight * imbalance(scratch)));
}

}  // namespace planish
