// Names: t the curve's direction towards the curve point w0 that a sector begins with, n across it
// in the sector's plane, e_0..e_k the edges, s_i > 0 with sum s_i e_i along n, x_i the control
// points: x_1 = w0 + s_0 turned(e_0), x_(i+1) = x_i + s_i turned(e_i), and w1 = -w0 in the end.
#include "planish/fair/perpendicular_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/unit_vector.h"
#include "planish/fair/balanced_weights.h"
#include "planish/fair/best_view.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

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
               : static_cast<float>(std::atan2(glm::dot(tilted, left), glm::dot(tilted, own)));
  }
  if (lean == 0) return own;
  return std::cos(double{lean}) * own + std::sin(double{lean}) * left;
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
      dvec2 point = radius * dvec2(std::cos(angle), std::sin(angle));
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
      across +=
          std::sin(std::numbers::pi * (2 * i + 1) / (2.0 * sector.count)) * offsets[corners[i]];
    }
    const dvec3 normal =
        unit_or_zero(glm::cross(offsets[sector.curve0] - offsets[sector.curve1], across));
    for (const std::int32_t corner : corners) {
      least = std::min(least, glm::dot(normal, face_normals[topology.corner_faces[corner]]));
    }
  }
  return least;
}

}  // namespace planish
