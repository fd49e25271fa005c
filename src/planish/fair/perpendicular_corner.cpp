// What perpendicular_curve.h has of corners.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/unit_vector.h"
#include "planish/fair/perpendicular_curve.h"
#include "planish/fair/vertex_frame.h"
#include "planish/mesh/angle_between.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

namespace {

// A corner's sector that leaves less of a full turn than this on either side of the gap between its
// sharp edges, and of its outer faces less than a third, has them drawn apart.
constexpr double kLeastGap = 5 * std::numbers::pi / 180;
constexpr double kGapShare = 1.0 / 3;
// Gaps as wide as this on either side are left as they are.
constexpr double kWideGap = std::numbers::pi / 4;
// A corner's sectors are told apart up to this one: floats hold all bits below exactly.
constexpr std::uint32_t kLastSectorBit = 1U << 20;
// Part of the reflex angle where the drawing begins.
constexpr double kNearlyReflex = 0.9;
// From here on a corner's sector is reflex, as doosabin/sharp_features.cpp has it.
constexpr double kReflexAngle = 7 * std::numbers::pi / 6;
// 1 + cosine of the angle at a corner below which its control point moves away no farther.
constexpr double kWidestAngle = 0.2;

// How many faces of a reflex sector see its limit normal from behind.
std::int32_t turned_faces(const CurveSite& site, const FairTopology::Sector& sector) {
  const dvec3 normal = glm::cross(site.offsets[sector.curve1], site.offsets[sector.curve0]);
  std::int32_t count = 0;
  for (const std::int32_t corner : site.topology.ring(sector).corners) {
    const std::int32_t face = site.topology.corner_faces[corner];
    count += glm::dot(normal, site.face_normals[face]) > 0 ? 0 : 1;
  }
  return count;
}

// Where the sharp edges on both sides of a corner's reflex sector meet or cross, as at the tips of
// slits, the surface's sector would turn over: draws their curve points apart in its plane. Wide
// gaps are left gradually, so that what was opened once stays continuous. Beside steep faces the
// edges may stand over each other: their own plane says nothing then. Returns whether the sector is
// reflex.
bool open_sector(const CurveSite& site, const FairTopology::Sector& sector) {
  const FairTopology& topology = site.topology;
  const FairTopology::Ring ring = topology.ring(sector);
  const auto face_angle = [&](std::int32_t i) {
    return angle_between(site.edge(ring.next[i]), site.edge(ring.previous[i]));
  };
  double sum = 0;
  for (std::int32_t i = 0; i < ring.size(); ++i) sum += face_angle(i);
  const double reflex_share =
      std::clamp((sum / kReflexAngle - kNearlyReflex) / (1 - kNearlyReflex), 0.0, 1.0);
  const dvec3 normal =
      angle_weighted_normal(topology, site.given, site.face_normals, site.vertex, ring);
  const auto in_plane = [&](const dvec3& vector) {
    return unit_or_zero(vector - glm::dot(vector, normal) * normal);
  };
  const dvec3 a = in_plane(site.offsets[sector.curve0]), b = in_plane(site.offsets[sector.curve1]);
  const dvec3 middle = unit_or_zero(a + b), side = glm::cross(normal, middle);
  if (!(reflex_share > 0) || middle == dvec3(0.0)) return false;
  const auto draw = [&](std::int32_t curve, const dvec3& direction, std::int32_t place,
                        double sign) {
    const double least = std::min(kLeastGap, kGapShare * face_angle(place));
    const double own = sign * std::atan2(glm::dot(direction, side), glm::dot(direction, middle));
    const double angle = std::max(own, least);
    const double share =
        reflex_share * std::clamp((kWideGap - angle) / (kWideGap - least), 0.0, 1.0);
    dvec3& offset = site.offsets[curve];
    offset +=
        share *
        (glm::length(offset) * (std::cos(angle) * middle + sign * std::sin(angle) * side) - offset);
  };
  draw(sector.curve0, a, 0, 1);
  draw(sector.curve1, b, ring.size() - 1, -1);
  return sum > kReflexAngle;
}

// Whether opening the sector turns fewer faces back; does it then.
bool open_where_better(const CurveSite& site, const FairTopology::Sector& sector) {
  const dvec3 own0 = site.offsets[sector.curve0], own1 = site.offsets[sector.curve1];
  const std::int32_t own_count = turned_faces(site, sector);
  if (open_sector(site, sector) && turned_faces(site, sector) < own_count) return true;
  site.offsets[sector.curve0] = own0;
  site.offsets[sector.curve1] = own1;
  return false;
}

// Calls `use` with every sector between two curve points around a corner.
template <class Use>
void for_corner_sectors(const FairTopology& topology, std::int32_t vertex, const Use& use) {
  const std::int32_t first = topology.ring_offsets[vertex], end = topology.ring_offsets[vertex + 1];
  for (std::int32_t begin = first; begin < end;) {
    std::int32_t last = begin;
    const auto after = [&] { return topology.corner_ccw[topology.ring_corners[last]]; };
    while (last + 1 < end && after() < topology.corner_count) ++last;
    const std::int32_t before = topology.corner_cw[topology.ring_corners[begin]];
    if (before < topology.corner_count || after() < topology.corner_count) return;  // a cone
    use(FairTopology::Sector{vertex, begin, last + 1 - begin, before, after()});
    begin = last + 1;
  }
}

}  // namespace

void build_perpendicular_corner(const CurveSite& site, glm::vec2& lean) {
  const FairTopology& topology = site.topology;
  const double size = site.heights.size_at(site.vertex);
  const FairTopology::Ring ring = topology.ring(site.vertex);
  for (std::int32_t i = 0; i < ring.size(); ++i) {
    const std::int32_t corner = ring.corners[i];
    const dvec3 next = unit_or_zero(site.edge(ring.next[i]));
    const dvec3 previous = unit_or_zero(site.edge(ring.previous[i]));
    // Within the size at right angles, where the point is farther than the circle.
    const double radius = size * std::numbers::sqrt2 / 2;
    const double widening = std::max(1 + glm::dot(next, previous), kWidestAngle);
    site.offsets[corner] = radius / widening * (next + previous);
    if (topology.corner_cw[corner] >= topology.corner_count) {
      site.offsets[topology.corner_cw[corner]] = radius * next;
    }
    if (topology.corner_ccw[corner] >= topology.corner_count) {
      site.offsets[topology.corner_ccw[corner]] = radius * previous;
    }
  }
  const bool is_decided = is_chosen(lean);
  if (!is_decided) lean = glm::vec2(0.0F);
  std::uint32_t opened = static_cast<std::uint32_t>(lean.x), bit = 1;
  for_corner_sectors(topology, site.vertex, [&](const FairTopology::Sector& sector) {
    if (!is_decided) {
      opened |= open_where_better(site, sector) ? bit : 0;
    } else if ((opened & bit) != 0) {
      (void)open_sector(site, sector);
    }
    bit = bit < kLastSectorBit ? 2 * bit : bit;
  });
  lean.x = static_cast<float>(opened);
}

namespace {

// Where a point lies in the wedge of two edges, in the sense of least squares: the sum of its parts
// along them, 1 on the line between their ends.
double part_of_wedge(const dvec3& point, const dvec3& next, const dvec3& previous) {
  const double nn = glm::dot(next, next), pp = glm::dot(previous, previous);
  const double np = glm::dot(next, previous), determinant = nn * pp - np * np;
  const double n = glm::dot(point, next), p = glm::dot(point, previous);
  if (!(determinant > 1e-12 * nn * pp)) return 0;
  return (n * pp - p * np + p * nn - n * np) / determinant;
}

}  // namespace

double farthest_fan_point(const FairTopology& topology, std::span<const dvec3> given,
                          std::span<const dvec3> offsets, std::int32_t vertex) {
  double farthest = 0;
  for_corner_sectors(topology, vertex, [&](const FairTopology::Sector& sector) {
    const FairTopology::Ring ring = topology.ring(sector);
    for (std::int32_t i = 0; i < sector.count; ++i) {
      // The convex corner's fan; wider ones reach no farther.
      const double t = (i + 0.5) / sector.count * std::numbers::pi / 2;
      const dvec3 fan = std::numbers::sqrt2 * (std::cos(t) * offsets[sector.curve0] +
                                               std::sin(t) * offsets[sector.curve1]);
      const dvec3 point = (fan + offsets[ring.corners[i]]) / 4.0;
      const dvec3 next = given[ring.next[i]] - given[vertex];
      const dvec3 previous = given[ring.previous[i]] - given[vertex];
      farthest = std::max(farthest, part_of_wedge(point, next, previous));
    }
  });
  return farthest;
}

}  // namespace planish
