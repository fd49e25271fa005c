#include "planish/analytic/cut_regions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

// What the facets of a surface are away from it: at most.
struct FacetGap {
  double depth = 0;  // inside it
  double turn = 0;   // of their normals
};

constexpr double kLarger = 4;  // times a facet's area: no facet of the same surface

// Edges between facets lie on these from end to end.
bool has_rulings(AnalyticKind kind) {
  return kind == AnalyticKind::Cylinder || kind == AnalyticKind::Cone;
}

struct Growth {
  AnalyticSurface surface;
  double sign = 1;
  FacetGap gap;
  std::vector<std::int32_t> clusters;
};

class CutFinder {
 public:
  CutFinder(std::span<const glm::dvec3> positions, const MeshTopology& topology,
            std::span<const char> is_sharp, const FacetClusters& made, const FaceComponents& parts,
            double tolerance, AnalyticRegions& regions)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        made_(made),
        tolerance_(tolerance),
        regions_(regions),
        parts_(parts),
        seen_(made.clusters.size(), 0) {}

  std::vector<char> find() && {
    is_cut_.assign(regions_.regions.size(), 0);
    for (std::size_t r = 0; r < regions_.regions.size(); ++r) widen(r);
    // Of what has no names not everything is looked at.
    constexpr std::size_t kMostMisses = 1000;
    std::vector<std::size_t> misses(static_cast<std::size_t>(parts_.count), 0),
        hits(misses.size(), 0);
    for (std::int32_t c = 0; c < std::ssize(made_.clusters); ++c) {
      if (c % 64 == 0) check_stop();
      const std::int32_t part = parts_.of_face[made_.clusters[c].faces.front()];
      if (!is_free(c) || misses[part] > kMostMisses + hits[part]) continue;
      if (auto best = best_through(c)) {
        hits[part] += best->clusters.size();
        take(std::move(*best));
      } else {
        ++misses[part];
      }
    }
    return std::move(is_cut_);
  }

 private:
  [[nodiscard]] bool is_free(std::int32_t cluster) const {
    return std::ranges::all_of(made_.clusters[cluster].faces,
                               [&](std::int32_t f) { return regions_.region_of[f] == kNoRegion; });
  }
  // Calls use(corner, other) for each smooth edge from a cluster to another one.
  template <class Use>
  void each_border(std::int32_t cluster, const Use& use) const {
    for (const std::int32_t f : made_.clusters[cluster].faces) {
      for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
        const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
        if (twin < 0 || is_sharp_[topology_.edge_of(corner)] != 0) continue;
        const std::int32_t other = made_.cluster_of[topology_.face_of(twin)];
        if (other != cluster) use(corner, other);
      }
    }
  }
  [[nodiscard]] const glm::dvec3& start_of(std::int32_t corner) const {
    return positions_[topology_.vertex_of(corner)];
  }
  [[nodiscard]] const glm::dvec3& end_of(std::int32_t corner) const {
    return positions_[topology_.vertex_of(topology_.next(corner))];
  }

  // Ends of the smooth edges of clusters, where facets meet.
  [[nodiscard]] std::vector<glm::dvec3> telling_points(
      std::span<const std::int32_t> clusters) const {
    std::vector<std::int32_t> vertices;
    for (const std::int32_t c : clusters)
      each_border(c, [&](std::int32_t corner, std::int32_t) {
        vertices.push_back(topology_.vertex_of(corner));
        vertices.push_back(topology_.vertex_of(topology_.next(corner)));
      });
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    std::vector<glm::dvec3> points;
    for (const std::int32_t v : vertices) points.push_back(positions_[v]);
    return points;
  }
  [[nodiscard]] std::vector<glm::dvec3> points_on(const AnalyticSurface& surface,
                                                  std::span<const std::int32_t> clusters) const {
    std::vector<glm::dvec3> points = telling_points(clusters);
    std::erase_if(points, [&](const glm::dvec3& p) {
      return !(std::abs(signed_distance(surface, p)) <= tolerance_);
    });
    return points;
  }

  // The radius of curvature across the rulings of a cylinder or cone.
  [[nodiscard]] static double radius_at(const AnalyticSurface& s, const glm::dvec3& p) {
    if (s.kind == AnalyticKind::Cylinder) return s.radius;
    const glm::dvec3 from = p - s.origin;
    const double away = glm::length(from - glm::dot(from, s.axis) * s.axis);
    return away * std::sqrt(1 + s.slope * s.slope);
  }
  // Of the facets that clusters are, by the turn from one to the next.
  [[nodiscard]] FacetGap gap_of(const AnalyticSurface& surface,
                                std::span<const std::int32_t> clusters) const {
    constexpr double kSlack = 1.02, kAngle = 0.5 * kDegree;
    std::vector<double> turns;
    double radius = 0;
    for (const std::int32_t c : clusters)
      each_border(c, [&](std::int32_t corner, std::int32_t other) {
        if (!std::ranges::binary_search(clusters, other)) return;
        turns.push_back(
            angle_between(made_.clusters[c].facet.normal, made_.clusters[other].facet.normal));
        radius = std::max(
            {radius, radius_at(surface, start_of(corner)), radius_at(surface, end_of(corner))});
      });
    if (turns.empty()) return {};
    const auto middle = turns.begin() + std::ssize(turns) / 2;
    std::ranges::nth_element(turns, middle);
    const double turn = *middle / 2;
    return {kSlack * radius * (1 - portable::cos(turn)) + tolerance_, kSlack * turn + kAngle};
  }

  // Whether a cluster is a facet of a surface, whole or cut.
  [[nodiscard]] bool is_facet(std::int32_t cluster, const Growth& of) const {
    const AnalyticSurface& s = of.surface;
    const auto is_inside = [&](const glm::dvec3& p) {
      const double d = signed_distance(s, p);
      return d >= -of.gap.depth && d <= tolerance_;
    };
    for (const std::int32_t f : made_.clusters[cluster].faces) {
      for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
        const std::int32_t corner = topology_.first_corner(f) + i;
        if (!is_inside(start_of(corner)) || !is_inside(0.5 * (start_of(corner) + end_of(corner))))
          return false;
      }
      const Facet& facet = made_.facets[f];
      if (facet.area > 0 && angle_between(of.sign * facet.normal, normal_at(s, facet.centre)) >
                                of.gap.turn + made_.doubt[f])
        return false;
    }
    return true;
  }

  // Over what its clusters meet, fitted on the way.
  void grow(Growth& growth) {
    constexpr int kMostRounds = 60;
    for (int round = 0; round < kMostRounds; ++round) {
      ++round_;
      for (const std::int32_t c : growth.clusters) seen_[c] = round_;
      const std::size_t before = growth.clusters.size(), enough = before + before / 2 + 2;
      for (std::size_t i = 0; i < growth.clusters.size() && growth.clusters.size() < enough; ++i) {
        for (const std::int32_t other : made_.clusters[growth.clusters[i]].neighbours) {
          if (seen_[other] == round_ || !is_free(other) || !is_facet(other, growth)) continue;
          seen_[other] = round_;
          growth.clusters.push_back(other);
        }
      }
      if (growth.clusters.size() == before) return;
      AnalyticSurface fitted = growth.surface;
      if (!(fit_surface(fitted, points_on(growth.surface, growth.clusters), tolerance_) <=
            tolerance_))
        return;
      growth.surface = fitted;
    }
  }

  void widen(std::size_t r) {
    AnalyticRegion& region = regions_.regions[r];
    if (region.faces.empty() || !has_rulings(region.surface.kind)) return;
    Growth growth{region.surface, region.side(), {}, {}};
    for (const std::int32_t f : region.faces) growth.clusters.push_back(made_.cluster_of[f]);
    std::ranges::sort(growth.clusters);
    growth.clusters.erase(std::ranges::unique(growth.clusters).begin(), growth.clusters.end());
    const std::vector<std::int32_t> own = growth.clusters;
    growth.gap = gap_of(region.surface, growth.clusters);
    grow(growth);
    if (growth.clusters.size() == own.size()) return;
    region.surface = growth.surface;
    region.sag = growth.gap.depth;
    is_cut_[r] = goes_on(growth) ? 0 : 1;
    for (std::size_t i = own.size(); i < growth.clusters.size(); ++i)
      give(growth.clusters[i], static_cast<std::int32_t>(r));
  }

  // A cluster's faces become a region's.
  void give(std::int32_t cluster, std::int32_t to) {
    for (const std::int32_t f : made_.clusters[cluster].faces) {
      regions_.region_of[f] = to;
      regions_.regions[to].faces.push_back(f);
    }
  }
  void take(Growth growth) {
    const auto index = static_cast<std::int32_t>(regions_.regions.size());
    AnalyticRegion region;
    region.surface = growth.surface;
    region.is_inward = growth.sign < 0;
    region.sag = growth.gap.depth;
    for (const glm::dvec3& p : points_on(growth.surface, growth.clusters))
      region.error = std::max(region.error, std::abs(signed_distance(growth.surface, p)));
    regions_.regions.push_back(std::move(region));
    is_cut_.push_back(1);
    for (const std::int32_t c : growth.clusters) give(c, index);
  }

  // Whether rulings speak for a cylinder or cone beyond those that tell it. Four may lie on a
  // circle by symmetry, unless their steps are even as a prism's are; three do, unless the surface
  // goes on as the planes on both sides, as a fillet does.
  [[nodiscard]] bool is_told(const Growth& growth) const {
    constexpr std::size_t kLeast = 4;
    constexpr double kSame = 1e-3, kEven = 1.05;  // radians
    const AxisFrame frame(growth.surface.axis);
    std::vector<double> angles;
    double first = 0;
    for (const glm::dvec3& p : points_on(growth.surface, growth.clusters)) {
      const glm::dvec3 from = p - growth.surface.origin;
      const double angle = portable::atan2(glm::dot(from, frame.y), glm::dot(from, frame.x));
      if (angles.empty()) first = angle;
      angles.push_back(std::remainder(angle - first, 2 * std::numbers::pi));
    }
    std::ranges::sort(angles);
    std::vector<double> steps;
    for (std::size_t i = 1; i < angles.size(); ++i)
      if (angles[i] - angles[i - 1] > kSame) steps.push_back(angles[i] - angles[i - 1]);
    if (steps.size() + 1 < kLeast) return steps.size() == 2 && is_fillet(growth);
    return steps.size() + 1 > kLeast ||
           *std::ranges::max_element(steps) <= kEven * *std::ranges::min_element(steps);
  }

  // Whether it has larger facets beside it on both sides, as whose planes it goes on.
  [[nodiscard]] bool is_fillet(const Growth& growth) const {
    constexpr double kTouch = 1 * kDegree;
    std::vector<std::int32_t> beside;
    for (const std::int32_t c : growth.clusters) {
      bool is_smooth = true;
      each_border(c, [&](std::int32_t corner, std::int32_t other) {
        if (std::ranges::binary_search(growth.clusters, other)) return;
        const double doubt = made_.doubt[made_.clusters[other].faces.front()];
        for (const glm::dvec3& p : {start_of(corner), end_of(corner)})
          if (angle_between(growth.sign * made_.clusters[other].facet.normal,
                            normal_at(growth.surface, p)) > kTouch + doubt)
            is_smooth = false;
        if (made_.clusters[other].facet.area > kLarger * made_.clusters[c].facet.area)
          beside.push_back(other);
      });
      if (!is_smooth) return false;
    }
    std::ranges::sort(beside);
    beside.erase(std::ranges::unique(beside).begin(), beside.end());
    return beside.size() >= 2;
  }
  // Whether vertices lie inside the surface: else whole facets would have told it.
  [[nodiscard]] bool is_cut(const Growth& growth) const {
    return std::ranges::any_of(growth.clusters, [&](std::int32_t c) {
      return std::ranges::any_of(made_.clusters[c].faces, [&](std::int32_t f) {
        return std::ranges::any_of(topology_.face(f), [&](std::int32_t v) {
          return std::abs(signed_distance(growth.surface, positions_[v])) > 2 * tolerance_;
        });
      });
    });
  }
  // Whether facets beside what was grown last go on smoothly without lying on it: a piece of
  // another surface.
  [[nodiscard]] bool goes_on(const Growth& growth) const {
    constexpr double kPart = 0.1;
    double around = 0, smooth = 0;  // lengths of its border
    for (const std::int32_t c : growth.clusters) {
      for (const std::int32_t f : made_.clusters[c].faces) {
        for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
          const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
          const std::int32_t other =
              twin < 0 ? kNoRegion : made_.cluster_of[topology_.face_of(twin)];
          if (other >= 0 && seen_[other] == round_) continue;
          const double length = glm::length(end_of(corner) - start_of(corner));
          around += length;
          if (other >= 0 && is_sharp_[topology_.edge_of(corner)] == 0 &&
              is_small_and_free(other, c))
            smooth += length;
        }
      }
    }
    return smooth > kPart * around;
  }
  [[nodiscard]] bool is_small_and_free(std::int32_t cluster, std::int32_t beside) const {
    return is_free(cluster) &&
           made_.clusters[cluster].facet.area < kLarger * made_.clusters[beside].facet.area;
  }

  // The surface that these clusters tell, grown.
  [[nodiscard]] std::optional<Growth> through(AnalyticKind kind, std::vector<std::int32_t> seeds) {
    std::ranges::sort(seeds);
    std::vector<Facet> facets;
    for (const std::int32_t c : seeds) facets.push_back(made_.clusters[c].facet);
    const std::vector<glm::dvec3> points = telling_points(seeds);
    if (points.size() <= changes_of(kind).size()) return std::nullopt;
    const auto guess = guess_surface(kind, points, facets);
    if (!guess) return std::nullopt;
    Growth growth{*guess, 1, {}, seeds};
    if (!(fit_surface(growth.surface, points, tolerance_) <= tolerance_)) return std::nullopt;
    double turn = 0;
    for (const std::int32_t c : seeds) {
      const Facet& facet = made_.facets[made_.clusters[c].faces.front()];
      turn += glm::dot(facet.normal, normal_at(growth.surface, facet.centre));
    }
    growth.sign = turn < 0 ? -1 : 1;
    growth.gap = gap_of(growth.surface, growth.clusters);
    if (!(growth.gap.turn <= kMostFacetTurn)) return std::nullopt;
    if (!std::ranges::all_of(seeds, [&](std::int32_t c) { return is_facet(c, growth); }))
      return std::nullopt;
    grow(growth);
    std::ranges::sort(growth.clusters);
    if (!is_told(growth)) return std::nullopt;
    const bool is_fillet = growth.clusters.size() == 2;
    if (goes_on(growth) || !(is_fillet || is_cut(growth))) return std::nullopt;
    return growth;
  }

  [[nodiscard]] std::optional<Growth> best_through(std::int32_t cluster) {
    std::vector<std::int32_t> beside;
    for (const std::int32_t c : made_.clusters[cluster].neighbours)
      if (is_free(c)) beside.push_back(c);
    if (beside.empty() || beside.size() > kMostNeighbours) return std::nullopt;
    std::optional<Growth> best;
    for (std::size_t i = 0; i < beside.size(); ++i) {
      for (std::size_t j = i + 1; j < beside.size(); ++j) {
        for (const AnalyticKind kind : {AnalyticKind::Cylinder, AnalyticKind::Cone}) {
          auto growth = through(kind, {beside[i], cluster, beside[j]});
          if (!growth) continue;
          if (!best || growth->clusters.size() > best->clusters.size()) best = std::move(growth);
          break;
        }
      }
    }
    for (std::size_t i = 0; i < beside.size() && !best; ++i)
      best = through(AnalyticKind::Cylinder, {cluster, beside[i]});
    return best;
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  const FacetClusters& made_;
  double tolerance_;
  AnalyticRegions& regions_;
  const FaceComponents& parts_;
  std::vector<char> is_cut_;        // by region
  std::vector<std::int32_t> seen_;  // by cluster: the round that last grew over it
  std::int32_t round_ = 0;
};

}  // namespace

std::vector<char> find_cut_regions(std::span<const glm::dvec3> positions,
                                   const MeshTopology& topology, std::span<const char> is_sharp,
                                   const FacetClusters& made, const FaceComponents& parts,
                                   double tolerance, AnalyticRegions& regions) {
  return CutFinder(positions, topology, is_sharp, made, parts, tolerance, regions).find();
}

}  // namespace planish
