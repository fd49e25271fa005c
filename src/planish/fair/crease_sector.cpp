#include "planish/fair/crease_sector.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/fair/corner_offsets.h"
#include "planish/fair/planar_ring.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

namespace {

// Control points beside a sharp edge follow its handle, but not farther than this factor.
constexpr double kLongestInSector = 1.3;

VertexFrame sector_frame(const FairTopology& topology, std::span<const dvec3> given,
                         std::span<const dvec3> face_normals, const FairTopology::Sector& sector,
                         const SectorShape& shape) {
  const dvec3& handle = shape.handle;
  const dvec3 normal = shape.normal ? *shape.normal
                                    : angle_weighted_normal(topology, given, face_normals,
                                                            sector.vertex, topology.ring(sector));
  const double square = glm::dot(handle, handle);
  if (!(square > 0)) return frame_of(normal);
  const dvec3 upright = normal - glm::dot(normal, handle) / square * handle;
  const double length = glm::length(upright);
  constexpr double kParallel = 1e-6;  // the handle stands on the sector: no plane holds both
  return frame_of(length > kParallel ? upright / length : normal);
}

double handle_factor(double handle_length, const dvec3& edge) {
  const double arm = glm::length(edge) / 4.0;
  return arm > 0 ? std::min(kLongestInSector, handle_length / arm) : 1.0;
}

// How far a control point at `coordinate` of the edge goes along with its handle. Deep in a large
// face, where the edge's own length is little, it stays in the order of the face's others.
double moved(double factor, double coordinate) {
  return (factor - 1) * coordinate * std::clamp(2 - std::abs(coordinate), 0.0, 1.0);
}

}  // namespace

void build_sector(const FairTopology& topology, std::span<const dvec3> given, const GivenStep& step,
                  std::span<const dvec3> face_normals, const FairTopology::Sector& sector,
                  const SectorShape& shape, std::span<dvec3> offsets) {
  const VertexFrame frame = sector_frame(topology, given, face_normals, sector, shape);
  const double handle_length = glm::length(shape.handle);
  const FairTopology::Ring ring = topology.ring(sector);
  for (std::int32_t i = 0; i < sector.count; ++i) {
    const std::int32_t corner = ring.corners[i];
    const dvec3 next = given[ring.next[i]] - given[sector.vertex];
    const dvec3 previous = given[ring.previous[i]] - given[sector.vertex];
    const dvec2 flat_next = frame.project(next), flat_previous = frame.project(previous);
    dvec2 flat = frame.project(step.offset(corner));
    const PlanarRing::Wedge wedge = wedge_of(flat, flat_next, flat_previous);
    if (wedge.valid) {
      const double next_factor = i == 0 ? handle_factor(handle_length, next) : 1.0;
      const double previous_factor =
          i + 1 == sector.count ? handle_factor(handle_length, previous) : 1.0;
      flat += wedge_share(flat_next, flat_previous) *
              (moved(next_factor, wedge.along_next) * flat_next +
               moved(previous_factor, wedge.along_previous) * flat_previous);
    }
    offsets[corner] = shape.share * (offsets[corner] + shape.tensor_shift) +
                      (1 - shape.share) * (flat.x * frame.tangent1 + flat.y * frame.tangent2);
  }
}

}  // namespace planish
