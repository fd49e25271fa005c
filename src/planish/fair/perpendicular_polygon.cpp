#include "planish/fair/perpendicular_polygon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>

#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/work.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/vertex_polygon.h"
#include "planish/mesh/face_geometry.h"

namespace planish {

using glm::dvec3;

namespace {

// Smaller rings cost less than the count of them.
constexpr std::size_t kCounted = 32;

auto worst_face(const FairTopology& topology, std::span<const dvec3> face_normals,
                std::int32_t vertex) {
  return [=, &topology, corners = topology.ring(vertex).corners](const dvec3& direction) {
    if (corners.size() >= kCounted) count_work(Work::Points, std::ssize(corners));
    return least_seen<dvec3>(corners, direction, [&](std::int32_t corner) {
      return face_normals[topology.corner_faces[corner]];
    });
  };
}

dvec3 normalised_or(const dvec3& vector, const dvec3& otherwise) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : otherwise;
}

}  // namespace

double least_face_cosine(const FairTopology& topology, std::span<const dvec3> face_normals,
                         std::int32_t vertex, const dvec3& direction) {
  return worst_face(topology, face_normals, vertex)(direction).cosine;
}

NormalCap smallest_cap(const FairTopology& topology, std::span<const dvec3> face_normals,
                       std::int32_t vertex, const dvec3& normal) {
  const auto best = best_view(normal, worst_face(topology, face_normals, vertex));
  return {best.vector, best.cosine};
}

dvec3 tilted_normal(const FairTopology& topology, std::span<const dvec3> face_normals,
                    std::int32_t vertex, const dvec3& normal) {
  return turned_to_see(normal, worst_face(topology, face_normals, vertex), normalised_or);
}

// Names: e_i the edges' directions in the plane, s_i the weights with sum s_i e_i = 0, x_i the
// points: x_i - x_(i-1) = s_i e_i turned by a right angle.

using glm::dvec2;

namespace {

// Of the least height of the faces around: a polygon of half of it stays off their other sides.
constexpr double kSize = 0.5;
// Of how far the weights are to be used: from here on they are all there is.
constexpr double kFullChain = 0.05;

// The points about their mean; returns the farthest one's distance.
double set_points(PerpendicularScratch& scratch) {
  dvec2 at(0.0), mean(0.0);
  const std::size_t n = scratch.edges.size();
  for (std::size_t i = 0; i < n; ++i) {
    at += scratch.weights[i] * dvec2(-scratch.edges[i].y, scratch.edges[i].x);
    scratch.points[i] = at;
    mean += at;
  }
  mean /= static_cast<double>(n);
  double farthest = 0;
  for (dvec2& point : scratch.points) {
    point -= mean;
    farthest = std::max(farthest, glm::length(point));
  }
  return farthest;
}

// As complex numbers.
dvec2 rotated(const dvec2& point, const dvec2& by) {
  return {point.x * by.x - point.y * by.y, point.x * by.y + point.y * by.x};
}

// Where on the circle the first of evenly spread points lies: half a step beyond where the edges
// point to, so that the points stand near to the bisectors of their faces.
dvec2 circle_start(const dvec2& direction, std::int32_t count) {
  const double half_step = std::numbers::pi / count;
  return rotated(direction, {portable::cos(half_step), portable::sin(half_step)});
}

}  // namespace

double chain_share(double usable) { return std::min(1.0, usable / kFullChain); }

FaceHeights::FaceHeights(const FairTopology& topology, std::span<const dvec3> given)
    : topology_(topology), given_(given) {
  for (const std::int32_t face : topology.large_faces) of_large_.push_back(measured(face));
}

double FaceHeights::measured(std::int32_t face) const {
  const std::int32_t first = topology_.face_offsets[face], m = topology_.face_size(face);
  const dvec3& origin = given_[topology_.corner_vertices[first]];
  dvec3 area(0.0);  // twice
  double longest = 0;
  for (std::int32_t k = 0; k < m; ++k) {
    const dvec3 a = given_[topology_.corner_vertices[first + k]] - origin;
    const dvec3 b = given_[topology_.corner_vertices[first + (k + 1) % m]] - origin;
    area += glm::cross(a, b);
    longest = std::max(longest, glm::length(b - a));
  }
  if (!(longest > 0)) return 0;
  return glm::length(area) / longest / (m > 3 ? 2 : 1);
}

double FaceHeights::of(std::int32_t face) const {
  const std::int32_t large = topology_.large_face(face);
  return large < 0 ? measured(face) : of_large_[large];
}

double FaceHeights::size_at(std::int32_t vertex) const {
  double least = HUGE_VAL;
  for (const std::int32_t corner : topology_.ring(vertex).corners) {
    const double height = of(topology_.corner_faces[corner]);
    if (height > 0) least = std::min(least, height);
  }
  return least < HUGE_VAL ? kSize * least : 0;
}

void build_perpendicular_polygon(const FairTopology& topology, std::span<const dvec3> given,
                                 std::int32_t vertex, const dvec3& normal, double size,
                                 PerpendicularScratch& scratch, std::span<dvec3> offsets) {
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  const VertexFrame frame = frame_of(normal);
  scratch.edges.resize(static_cast<std::size_t>(n));
  scratch.points.resize(scratch.edges.size());
  scratch.weights.resize(scratch.edges.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const dvec2 edge = frame.project(given[ring.next[i]] - given[vertex]);
    const double length = glm::length(edge);
    scratch.edges[i] = length > 0 ? edge / length : dvec2(0.0);
  }
  const double usable = balance(scratch.edges, scratch.weights);
  const double farthest = usable > 0 ? set_points(scratch) : 0;
  const double chain = farthest > 0 ? chain_share(usable) : 0;
  // As far as the edges do not surround the vertex, the points of a circle: its sides cross no
  // edges at right angles, but the limit normal is the plane's.
  const dvec2 start =
      chain < 1 ? circle_start(ring_direction(topology, given, vertex, frame), n) : dvec2(0.0);
  const auto circle = topology.unit_circle.of(n);
  for (std::int32_t i = 0; i < n; ++i) {
    dvec2 point = (1 - chain) * size * rotated(start, circle[i]);
    if (chain > 0) point += chain * size / farthest * scratch.points[i];
    offsets[ring.corners[i]] = point.x * frame.tangent1 + point.y * frame.tangent2;
  }
}

// Names: t the curve's direction towards the curve point w0 that a sector begins with, n across it
// in the sector's plane, e_0..e_k the edges, s_i > 0 with sum s_i e_i along n, x_i the control
// points: x_1 = w0 + s_0 turned(e_0), x_(i+1) = x_i + s_i turned(e_i), and w1 = -w0 in the end.

namespace {

constexpr double kHalfOfCurve = 0.5;
// Edges that reach less far across the curve than this, times chain_share()'s own ramp, leave its
// chain gradually: at 0 there is none.
constexpr double kFullRise = 0.4;
// Of the highest that the edges reach across the curve: what they are balanced about.
constexpr double kAcrossShare = 0.5;

// Where the convex hull of the edges' directions crosses the line across the curve, the farther of
// the two times; 0 where they all lie to one side. Of unit vectors those nearest to the line make
// it.
double highest_across(std::span<const dvec2> edges) {
  const dvec2 *right = nullptr, *left = nullptr;
  for (const dvec2& edge : edges) {
    const dvec2*& side = edge.x < 0 ? left : right;
    if (!side || edge.y > side->y) side = &edge;
  }
  if (!right || !left) return 0;
  return std::max(0.0, (right->x * left->y - left->x * right->y) / (right->x - left->x));
}

// Weights with sum s_i edges[i] across the curve; returns how far they are to be used. Needles lie
// flat along the curve: heights are scaled to the same spread as the rest, which changes no sum.
double balance_along(PerpendicularScratch& scratch) {
  const double rise = kAcrossShare * highest_across(scratch.edges);
  if (!(rise > 0)) return 0;
  double spread = 0;
  for (const dvec2& edge : scratch.edges) spread = std::max(spread, std::abs(edge.y - rise));
  scratch.points = scratch.edges;
  for (dvec2& edge : scratch.points) edge.y = (edge.y - rise) / spread;
  return balance(scratch.points, scratch.weights);
}

struct SectorPlane {
  dvec3 along, across;
};

// At right angles to the curve, unless it stands on it.
dvec3 turned_upright(const dvec3& vector, const dvec3& along, const dvec3& otherwise) {
  const dvec3 upright = unit_or_zero(vector - glm::dot(vector, along) * along);
  return upright == dvec3(0.0) ? otherwise : upright;
}

// As tilted_normal(), among directions at right angles to the curve.
dvec3 tilted_sector_normal(const CurveSite& site, const FairTopology::Sector& sector,
                           const dvec3& own, const dvec3& along) {
  const auto worst_of = [&, corners = site.topology.ring(sector).corners](const dvec3& direction) {
    return least_seen<dvec3>(corners, direction, [&](std::int32_t corner) {
      const dvec3& normal = site.face_normals[site.topology.corner_faces[corner]];
      return normal - glm::dot(normal, along) * along;
    });
  };
  return turned_to_see(own, worst_of, [&](const dvec3& vector, const dvec3& otherwise) {
    return turned_upright(vector, along, otherwise);
  });
}

// The normal of a sector's plane: its faces', about the curve by the angle that is to be chosen
// where it is not yet.
dvec3 sector_normal(const CurveSite& site, const FairTopology::Sector& sector, const dvec3& along,
                    bool is_decided, float& lean) {
  const dvec3 weighted = angle_weighted_normal(site.topology, site.given, site.face_normals,
                                               site.vertex, site.topology.ring(sector));
  const dvec3 own = turned_upright(weighted, along, weighted);
  const dvec3 left = glm::cross(along, own);
  if (!is_decided) {
    const dvec3 tilted = tilted_sector_normal(site, sector, own, along);
    lean = tilted == own
               ? 0.0F
               : static_cast<float>(portable::atan2(glm::dot(tilted, left), glm::dot(tilted, own)));
  }
  if (lean == 0) return own;
  return portable::cos(double{lean}) * own + portable::sin(double{lean}) * left;
}

// Fills the chain of a sector for a handle of length 1; returns how far it is to be used.
double shape_sector(const CurveSite& site, const FairTopology::Sector& sector,
                    const SectorPlane& plane, PerpendicularScratch& scratch) {
  const FairTopology::Ring ring = site.topology.ring(sector);
  const auto k = static_cast<std::size_t>(sector.count);
  for (auto* vectors : {&scratch.edges, &scratch.points}) vectors->resize(k + 1);
  scratch.weights.resize(k + 1);
  for (std::size_t i = 0; i <= k; ++i) {
    const dvec3 edge = site.edge(i < k ? ring.next[i] : ring.previous.back());
    const dvec2 flat(glm::dot(edge, plane.along), glm::dot(edge, plane.across));
    const double length = glm::length(flat);
    if (!(length > 0)) return 0;
    scratch.edges[i] = flat / length;
  }
  const double usable = std::min(balance_along(scratch), highest_across(scratch.edges) / kFullRise);
  if (!(usable > 0)) return 0;
  double rise = 0;
  for (std::size_t i = 0; i <= k; ++i) rise += scratch.weights[i] * scratch.edges[i].y;
  if (!(rise > 0)) return 0;
  const double scale = 2 / rise;  // from w0 = 1 along to w1 = -1
  dvec2 at(1.0, 0.0);
  for (std::size_t i = 0; i < k; ++i) {
    at += scale * scratch.weights[i] * dvec2(-scratch.edges[i].y, scratch.edges[i].x);
    scratch.points[i] = at;
  }
  return usable;
}

}  // namespace

void scale_curve_vertex(const CurveSite& site, double factor) {
  const FairTopology& topology = site.topology;
  const auto corners = topology.ring(site.vertex).corners;
  std::int32_t begins = -1;  // the curve point that the first sector begins with
  bool is_closed = true;
  for (const std::int32_t corner : corners) {
    site.offsets[corner] *= factor;
    const std::int32_t before = topology.corner_cw[corner];
    if (before < topology.corner_count) continue;
    site.offsets[before] *= factor;
    if (begins < 0) begins = before;
  }
  // Around a whole ring the last sector ends where the first begins.
  const std::int32_t end = topology.corner_ccw[corners.back()];
  is_closed = end == begins || end < topology.corner_count;
  if (!is_closed) site.offsets[end] *= factor;
}

void build_perpendicular_crease(const CurveSite& site, glm::vec2& lean,
                                PerpendicularScratch& scratch) {
  const FairTopology& topology = site.topology;
  const std::int32_t crease = topology.crease_of_vertex[site.vertex];
  const auto sectors = std::span(topology.sectors)
                           .subspan(static_cast<std::size_t>(topology.sector_offsets[crease]),
                                    static_cast<std::size_t>(topology.sector_offsets[crease + 1] -
                                                             topology.sector_offsets[crease]));
  const std::int32_t curve0 = sectors[0].curve0, curve1 = sectors[0].curve1;
  const dvec3 direction = unit_or_zero(site.offsets[curve0]);
  const double size = site.heights.size_at(site.vertex);
  if (!(size > 0) || direction == dvec3(0.0)) {
    scale_curve_vertex(site, kHalfOfCurve);
    return;
  }
  double farthest = 1;  // of all control points, for a handle of length 1
  double usable = 1;
  const bool is_decided = is_chosen(lean);
  if (!is_decided) lean = glm::vec2(0.0F);
  std::array<SectorPlane, 2> planes;
  for (std::size_t s = 0; s < sectors.size(); ++s) {
    const FairTopology::Sector& sector = sectors[s];
    const dvec3 along = sector.curve0 == curve0 ? direction : -direction;
    const dvec3 normal = sector_normal(site, sector, along, is_decided, s == 0 ? lean.x : lean.y);
    planes[s] = {along, unit_or_zero(glm::cross(normal, along))};
    usable = std::min(usable, shape_sector(site, sector, planes[s], scratch));
    if (!(usable > 0)) continue;
    for (std::int32_t i = 0; i < sector.count; ++i) {
      farthest = std::max(farthest, glm::length(scratch.points[i]));
    }
  }
  // As far as no chain does, the points of a half circle: its sides cross no edges at right angles,
  // but the limit normal is the plane's.
  const double chain = chain_share(usable);
  const double length = chain * size / farthest, radius = (1 - chain) * size;
  for (std::size_t s = 0; s < sectors.size(); ++s) {
    const FairTopology::Sector& sector = sectors[s];
    const SectorPlane& plane = planes[s];
    const auto corners = topology.ring(sector).corners;
    if (chain > 0) (void)shape_sector(site, sector, plane, scratch);
    for (std::int32_t i = 0; i < sector.count; ++i) {
      const double angle = std::numbers::pi * (2 * i + 1) / (2.0 * sector.count);
      dvec2 point = radius * dvec2(portable::cos(angle), portable::sin(angle));
      if (chain > 0) point += length * scratch.points[i];
      site.offsets[corners[i]] = point.x * plane.along + point.y * plane.across;
    }
  }
  site.offsets[curve0] = (length + radius) * direction;
  site.offsets[curve1] = -site.offsets[curve0];
}

double least_sector_cosine(const FairTopology& topology, std::span<const dvec3> face_normals,
                           std::span<const dvec3> offsets, std::int32_t vertex) {
  const std::int32_t crease = topology.crease_of_vertex[vertex];
  double least = 1;
  for (std::int32_t s = topology.sector_offsets[crease]; s < topology.sector_offsets[crease + 1];
       ++s) {
    const FairTopology::Sector& sector = topology.sectors[s];
    const auto corners = topology.ring(sector).corners;
    dvec3 across(0.0);
    for (std::int32_t i = 0; i < sector.count; ++i) {
      across += portable::sin(std::numbers::pi * (2 * i + 1) / (2.0 * sector.count)) *
                offsets[corners[i]];
    }
    const dvec3 normal =
        unit_or_zero(glm::cross(offsets[sector.curve0] - offsets[sector.curve1], across));
    for (const std::int32_t corner : corners) {
      least = std::min(least, glm::dot(normal, face_normals[topology.corner_faces[corner]]));
    }
  }
  return least;
}

// What perpendicular_polygon.h has of corners.

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
// From here on a corner's sector is reflex, as doosabin/subdivision.cpp has it.
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
    const double own =
        sign * portable::atan2(glm::dot(direction, side), glm::dot(direction, middle));
    const double angle = std::max(own, least);
    const double share =
        reflex_share * std::clamp((kWideGap - angle) / (kWideGap - least), 0.0, 1.0);
    dvec3& offset = site.offsets[curve];
    offset += share * (glm::length(offset) *
                           (portable::cos(angle) * middle + sign * portable::sin(angle) * side) -
                       offset);
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
      const dvec3 fan = std::numbers::sqrt2 * (portable::cos(t) * offsets[sector.curve0] +
                                               portable::sin(t) * offsets[sector.curve1]);
      const dvec3 point = (fan + offsets[ring.corners[i]]) / 4.0;
      const dvec3 next = given[ring.next[i]] - given[vertex];
      const dvec3 previous = given[ring.previous[i]] - given[vertex];
      farthest = std::max(farthest, part_of_wedge(point, next, previous));
    }
  });
  return farthest;
}

}  // namespace planish
