#include "planish/analytic/noisy_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "planish/analytic/face_patches.h"
#include "planish/analytic/settle_surfaces.h"
#include "planish/analytic/spread_order.h"
#include "planish/core/callbacks.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr std::int32_t kElsewhere = -2;  // of other faces than those that are looked at

// What a quadric over their plane leaves of points.
struct QuadricRest {
  double rms = 0;
  double size = 0;  // the rms of the points along their longest axis
};
// None where points do not tell one.
std::optional<QuadricRest> left_by_quadric(std::span<const glm::dvec3> points) {
  constexpr std::size_t kUnknowns = 6;
  if (points.size() < 2 * kUnknowns) return std::nullopt;
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
  glm::dmat3 spread(0.0);
  for (const glm::dvec3& p : points)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) spread[i][j] += (p - mean)[i] * (p - mean)[j];
  const glm::dmat3 axes = eigenvectors(spread);
  int least = 0, most = 0;
  for (int i = 1; i < 3; ++i) {
    if (spread[i][i] < spread[least][least]) least = i;
    if (spread[i][i] >= spread[most][most]) most = i;
  }
  if (least == most) return std::nullopt;
  const glm::dvec3 x = axes[most], y = axes[3 - least - most], z = axes[least];
  const double size = std::sqrt(spread[most][most] / static_cast<double>(points.size()));
  if (!(size > 0)) return std::nullopt;
  std::vector<double> a(kUnknowns * kUnknowns), b(kUnknowns);
  const auto row = [&](const glm::dvec3& p) {
    const double u = glm::dot(p - mean, x) / size, v = glm::dot(p - mean, y) / size;
    return std::array<double, kUnknowns>{1, u, v, u * u, u * v, v * v};
  };
  for (const glm::dvec3& p : points) {
    const auto r = row(p);
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      for (std::size_t j = 0; j < kUnknowns; ++j) a[kUnknowns * i + j] += r[i] * r[j];
      b[i] += r[i] * glm::dot(p - mean, z);
    }
  }
  // Points on two lines do not tell all.
  constexpr double kRidge = 1e-10;
  for (std::size_t i = 0; i < kUnknowns; ++i)
    a[kUnknowns * i + i] += kRidge * static_cast<double>(points.size());
  if (!solve_cholesky(a, b)) return std::nullopt;
  double squares = 0;
  for (const glm::dvec3& p : points) {
    const auto r = row(p);
    double h = glm::dot(p - mean, z);
    for (std::size_t i = 0; i < kUnknowns; ++i) h -= b[i] * r[i];
    squares += h * h;
  }
  return QuadricRest{std::sqrt(squares / static_cast<double>(points.size() - kUnknowns)), size};
}

// Five deviations of the noise are the tolerance: of 10,000 vertices none is farther off.
constexpr double kDeviations = 5;

// Of faces that are all free at first.
class NoisyFinder {
 public:
  NoisyFinder(std::span<const glm::dvec3> positions, const MeshTopology& topology,
              std::span<const char> is_sharp, std::span<const std::int32_t> faces, double tolerance,
              VertexPlaces places)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        faces_(faces),
        tolerance_(tolerance),
        are_samples_(places == VertexPlaces::Samples),
        patches_(positions, topology, is_sharp),
        region_of_(topology.face_count(), kElsewhere),
        facets_(topology.face_count()),
        seen_(topology.face_count(), 0) {
    for (const std::int32_t f : faces) {
      region_of_[f] = kNoRegion;
      const glm::dvec3 area = area_vector(positions, topology.face(f));
      facets_[f] = {unit_or_zero(area), glm::length(area), patches_.centre(f)};
    }
    whole_ = area_of(faces);
  }

  // Puts its regions in place of those that the faces have, if they take more than `least` of the
  // area; whether it did.
  bool find(double least, AnalyticRegions& regions) && {
    constexpr double kHopeless = 0.1;  // of the area
    take_all(true);
    if (taken() < kHopeless * whole_) return false;
    if (are_samples_) {
      take_samples();
    } else {
      take_more();
      give_back();
      // Slivers that sharp edges cut off from the surface that they lie on.
      flood(faces_, kReach * tolerance_);
    }
    if (!(taken() > least)) return false;
    for (AnalyticRegion& region : regions.regions)
      if (!region.faces.empty() && region_of_[region.faces.front()] != kElsewhere)
        region.faces.clear();
    for (const std::int32_t f : faces_) regions.region_of[f] = kNoRegion;
    const auto members = members_by_region();
    find_nearest();
    for (std::int32_t r = 0; r < std::ssize(found_); ++r) {
      if (members[r].empty()) continue;
      // Few vertices may lie on a surface by chance.
      constexpr double kChance = 0.7;
      double error = kChance * tolerance_;
      // Few samples are out of order: across an edge, or what is left of an outlier.
      for (const std::int32_t v : own_vertices(members[r], r))
        if (!are_samples_ || off(v, r) <= tolerance_) error = std::max(error, off(v, r));
      for (const std::int32_t f : members[r])
        regions.region_of[f] = static_cast<std::int32_t>(regions.regions.size());
      regions.regions.push_back({found_[r].surface, found_[r].sign < 0, members[r], error});
    }
    remove_empty(regions);
    return true;
  }

 private:
  struct Found {
    AnalyticSurface surface;
    double sign = 1;
    std::vector<std::int32_t> faces{};  // until they are taken
    double area = 0;
  };

  [[nodiscard]] double taken() const {
    double area = 0;
    for (const std::int32_t f : faces_) area += region_of_[f] >= 0 ? facets_[f].area : 0;
    return area;
  }
  [[nodiscard]] std::vector<std::vector<std::int32_t>> members_by_region() const {
    std::vector<std::vector<std::int32_t>> members(found_.size());
    for (const std::int32_t f : faces_)
      if (region_of_[f] >= 0) members[region_of_[f]].push_back(f);
    return members;
  }

  [[nodiscard]] bool lies_on(std::int32_t face, const AnalyticSurface& surface, double sign,
                             double tolerance) const {
    glm::dvec3 mean(0.0);
    double longest = 0;
    const auto vertices = topology_.face(face);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const glm::dvec3& p = positions_[vertices[i]];
      if (!(std::abs(signed_distance(surface, p)) <= tolerance)) return false;
      mean += normal_at(surface, p);
      longest = std::max(longest, glm::length(positions_[vertices[(i + 1) % vertices.size()]] - p));
    }
    constexpr double kMostSpread = 28 * kDegree, kSlack = 5 * kDegree;
    mean /= static_cast<double>(vertices.size());
    if (!(glm::length(mean) > 0.5)) return false;
    double spread = 0;
    for (const std::int32_t v : vertices)
      spread = std::max(spread, angle_between(normal_at(surface, positions_[v]), mean));
    if (spread > kMostSpread) return false;
    // Between the vertices, too: a disc whose border lies on a torus does not.
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const glm::dvec3 &from = positions_[vertices[i]],
                       &to = positions_[vertices[(i + 1) % vertices.size()]];
      if (std::abs(signed_distance(surface, 0.5 * (from + to))) >
          0.75 * glm::length(to - from) * spread + 2 * tolerance)
        return false;
    }
    const Facet& facet = facets_[face];
    if (!(facet.area > 0)) return true;
    const double height = 2 * facet.area / longest;
    constexpr double kMostTurn = 60 * kDegree;
    return angle_between(sign * facet.normal, mean) <=
           std::min(kSlack + spread + tolerance / height, kMostTurn);
  }

  // Facets whose normals are means of those around.
  [[nodiscard]] std::vector<Facet> smoothed(std::span<const std::int32_t> faces) const {
    std::vector<Facet> result;
    for (const std::int32_t f : faces) {
      glm::dvec3 sum = facets_[f].area * facets_[f].normal;
      patches_.each_neighbour(f, [&](std::int32_t a) {
        sum += facets_[a].area * facets_[a].normal;
        patches_.each_neighbour(a, [&](std::int32_t b) {
          if (b != f) sum += 0.5 * facets_[b].area * facets_[b].normal;
        });
      });
      if (glm::length(sum) > 0)
        result.push_back({glm::normalize(sum), facets_[f].area, facets_[f].centre});
    }
    return result;
  }

  [[nodiscard]] double area_of(std::span<const std::int32_t> faces) const {
    double area = 0;
    for (const std::int32_t f : faces) area += facets_[f].area;
    return area;
  }

  // A surface with the side that faces look to.
  [[nodiscard]] Found oriented(const AnalyticSurface& surface,
                               std::span<const std::int32_t> faces) const {
    double turn = 0;
    for (const std::int32_t f : faces)
      turn += facets_[f].area * glm::dot(facets_[f].normal, normal_at(surface, facets_[f].centre));
    return {surface, turn < 0 ? -1.0 : 1.0};
  }
  [[nodiscard]] std::optional<Found> grown(AnalyticSurface surface,
                                           std::vector<std::int32_t> seeds) {
    const double sign = oriented(surface, seeds).sign;
    std::vector<std::int32_t> faces = std::move(seeds);
    constexpr int kMostRounds = 40;
    for (int round = 0; round < kMostRounds; ++round) {
      ++round_;
      std::vector<std::int32_t> next;
      for (const std::int32_t f : faces) {
        if (!lies_on(f, surface, sign, tolerance_)) continue;
        seen_[f] = round_;
        next.push_back(f);
      }
      if (next.empty()) return std::nullopt;
      const std::size_t enough = next.size() + next.size() / 2 + 2;
      bool is_whole = true;
      for (std::size_t i = 0; i < next.size(); ++i) {
        patches_.each_neighbour(next[i], [&](std::int32_t other) {
          if (seen_[other] == round_ || region_of_[other] != kNoRegion) return;
          if (next.size() >= enough) {
            is_whole = false;
            return;
          }
          if (!lies_on(other, surface, sign, tolerance_)) return;
          seen_[other] = round_;
          next.push_back(other);
        });
      }
      const bool is_same = next.size() == faces.size();
      faces = std::move(next);
      AnalyticSurface fitted = surface;
      const double off = fit_surface(fitted, sample(patches_.points_of(faces)));
      if (!(off <= 2 * tolerance_)) break;
      surface = fitted;
      if (is_same && is_whole) break;
    }
    Found found{surface, sign};
    for (const std::int32_t f : faces)
      if (lies_on(f, surface, sign, tolerance_)) found.faces.push_back(f);
    found.area = area_of(found.faces);
    return found;
  }

  // Enough of them to tell a surface.
  [[nodiscard]] static std::vector<glm::dvec3> sample(std::vector<glm::dvec3> points) {
    constexpr std::size_t kEnough = 2000;
    if (points.size() <= kEnough) return points;
    const SpreadOrder order(points.size());
    std::vector<glm::dvec3> result;
    for (std::size_t i = 0; i < kEnough; ++i) result.push_back(points[order[i]]);
    return result;
  }

  [[nodiscard]] std::optional<Found> best_at(std::int32_t seed) {
    for (const std::size_t size : {600u, 200u, 70u, 25u}) {
      const std::vector<std::int32_t> patch =
          patches_.around(seed, size, [&](std::int32_t f) { return is_open(f); });
      const std::vector<glm::dvec3> points = sample(patches_.points_of(patch));
      const std::vector<Facet> facets = smoothed(patch);
      std::optional<Found> best;
      // A row of facets lies on a cone and on a sphere.
      for (const AnalyticKind kind :
           {AnalyticKind::Plane, AnalyticKind::Cylinder, AnalyticKind::Cone, AnalyticKind::Sphere,
            AnalyticKind::Torus}) {
        if (points.size() <= changes_of(kind).size()) continue;
        auto surface = guess_surface(kind, points, facets);
        if (!surface || !(fit_surface(*surface, points, tolerance_) <= tolerance_)) continue;
        constexpr double kMostRadius = 5, kMostTube = 0.5;  // of the diagonal
        if (surface->radius > kMostRadius || surface->minor > kMostTube) continue;
        auto found = grown(*surface, patch);
        if (!found) continue;
        // What is simpler is true unless it goes much less far.
        constexpr double kFarther = 1.25;
        if (!best || found->area > kFarther * best->area) best = std::move(found);
      }
      if (best) return best;
    }
    // A plane of a few large facets among the small ones of fillets.
    constexpr double kLarge = 0.01;  // of the area
    if (facets_[seed].area < kLarge * whole_) return std::nullopt;
    const std::array<std::int32_t, 1> alone{seed};
    const auto plane =
        guess_surface(AnalyticKind::Plane, patches_.points_of(alone), std::span(&facets_[seed], 1));
    return plane ? grown(*plane, {seed}) : std::nullopt;
  }

  // Whether it is large beside the noise: a plane by its width, others by how far they leave one.
  [[nodiscard]] bool is_told(const Found& found) {
    constexpr double kWide = 50, kBent = 3;  // tolerances
    constexpr std::size_t kLeast = 8;        // faces of what is bent
    if (found.surface.kind == AnalyticKind::Plane)
      return found.area > kWide * kWide * tolerance_ * tolerance_;
    if (found.faces.size() < kLeast) return false;
    const std::vector<glm::dvec3> points = sample(patches_.points_of(found.faces));
    std::vector<Facet> facets;
    for (const std::int32_t f : found.faces) facets.push_back(facets_[f]);
    auto plane = guess_surface(AnalyticKind::Plane, points, facets);
    return plane && fit_surface(*plane, points) > kBent * tolerance_;
  }

  // Free faces from which surfaces are told: of samples none that has a vertex on a region, since
  // it reaches across an edge.
  [[nodiscard]] bool is_open(std::int32_t face) const {
    return region_of_[face] == kNoRegion &&
           std::ranges::none_of(topology_.face(face), [&](std::int32_t v) {
             return nearest_[v] >= 0 && off(v, nearest_[v]) <= tolerance_;
           });
  }
  // Whether the faces around one that is open are smooth: a patch across an edge of samples tells
  // nothing.
  [[nodiscard]] bool is_smooth_at(std::int32_t seed) {
    constexpr std::size_t kFaces = 25;
    constexpr double kMost = 2, kBend = 0.01;  // of the noise, of the size
    const auto left = left_by_quadric(patches_.points_of(
        patches_.around(seed, kFaces, [&](std::int32_t f) { return is_open(f); })));
    return !left || left->rms <= kMost * tolerance_ / kDeviations + kBend * left->size;
  }

  // Large ones first, then all.
  void take_all(bool is_first) {
    find_nearest();
    const SpreadOrder order(faces_.size());
    const double least = is_first ? 0.02 * whole_ : 0;
    constexpr std::size_t kMostMisses = 100;
    std::vector<char> is_small(region_of_.size(), 0);
    std::size_t misses = 0;
    for (std::size_t i = 0; i < faces_.size() && misses < kMostMisses; ++i) {
      if (i % 16 == 0) check_stop();
      const std::int32_t seed = faces_[order[i]];
      if (!is_open(seed) || is_small[seed] != 0) continue;
      if (are_samples_ && !is_smooth_at(seed)) continue;
      auto best = best_at(seed);
      if (!best || !is_told(*best)) {
        ++misses;
        continue;
      }
      if (best->area < least) {
        for (const std::int32_t f : best->faces) is_small[f] = 1;
        continue;
      }
      for (const std::int32_t f : best->faces)
        region_of_[f] = static_cast<std::int32_t>(found_.size());
      best->faces.clear();
      found_.push_back(std::move(*best));
    }
  }

  void take_more() {
    take_all(false);
    compete();
    absorb();
    compete();
  }

  // What is left between regions is looked at again and again, then made a partition: each region
  // in one piece, and each vertex a place where the surfaces around it can meet.
  void take_samples() {
    constexpr int kTimes = 2, kTidied = 3;
    constexpr double kHopeful = 0.7;  // of the area
    for (int i = 0; i < kTimes; ++i) {
      for (std::size_t before = 0; before < found_.size();) {
        before = found_.size();
        take_more();
      }
      measure();
      share_surfaces();
      give_back();
      if (taken() < kHopeful * whole_) return;
    }
    free_bridges();
    fill_gaps();
    for (int i = 0; i < kTidied; ++i) {
      flood_islands();
      for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) tidy_around(v);
    }
    flood_islands();
  }
  // The noise again, by what all regions leave: patches of few faces tell somewhat too little.
  void measure() {
    find_nearest();
    std::vector<double> left;
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v)
      if (nearest_[v] >= 0) left.push_back(off(v, nearest_[v]));
    if (left.empty()) return;
    const auto middle = left.begin() + std::ssize(left) / 2;
    std::ranges::nth_element(left, middle);
    constexpr double kMost = 1.5, kNormalQuartile = 0.6745;
    tolerance_ =
        std::clamp(kDeviations * *middle / kNormalQuartile, tolerance_, kMost * tolerance_);
  }
  // Regions that lie on the surface of a larger one elsewhere get that one.
  void share_surfaces() {
    const auto members = members_by_region();
    std::vector<std::int32_t> order;
    for (std::int32_t r = 0; r < std::ssize(found_); ++r)
      if (!members[r].empty() && found_[r].surface.kind != AnalyticKind::Plane) order.push_back(r);
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::int32_t r) { return members[r].size(); });
    for (std::size_t i = 1; i < order.size(); ++i) {
      const std::int32_t r = order[i];
      const std::vector<std::int32_t> own = own_vertices(members[r], r);
      for (std::size_t j = 0; j < i && !own.empty(); ++j) {
        double squares = 0;
        const std::int32_t known = order[j];
        for (const std::int32_t v : own) squares += off(v, known) * off(v, known);
        constexpr double kMost = 1.3;  // of the noise
        if (!(std::sqrt(squares / static_cast<double>(own.size())) <=
              kMost * tolerance_ / kDeviations))
          continue;
        found_[r] = oriented(found_[known].surface, members[r]);
        break;
      }
    }
  }
  // Regions all but few of whose vertices lie on others beside them: triangles across an edge.
  void free_bridges() {
    const auto members = members_by_region();
    std::vector<std::int32_t> order(found_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::less<>(),
                             [&](std::int32_t r) { return members[r].size(); });
    for (const std::int32_t r : order) {
      const std::vector<std::int32_t> beside = regions_beside(members[r]);
      if (!beside.empty() && lie_on(members[r], beside)) free(members[r]);
    }
  }
  void free(std::span<const std::int32_t> faces) {
    for (const std::int32_t f : faces) region_of_[f] = kNoRegion;
  }
  // Whether all but few vertices of faces are on one of these regions' surfaces.
  [[nodiscard]] bool lie_on(std::span<const std::int32_t> faces,
                            std::span<const std::int32_t> regions) {
    constexpr std::ptrdiff_t kFew = 3;
    const std::vector<glm::dvec3> points = patches_.points_of(faces);
    return std::ranges::count_if(points, [&](const glm::dvec3& p) {
             return std::ranges::none_of(regions, [&](std::int32_t r) {
               return std::abs(signed_distance(found_[r].surface, p)) <= tolerance_;
             });
           }) <= kFew;
  }
  // Calls use(faces) for each piece of faces of one region, or of none, that edges join.
  template <class Use>
  void each_piece(const Use& use) const {
    std::vector<char> is_seen(region_of_.size(), 0);
    for (const std::int32_t first : faces_) {
      if (is_seen[first] != 0) continue;
      std::vector<std::int32_t> piece{first};
      is_seen[first] = 1;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const std::int32_t f = piece[i];
        each_beside(f, [&](std::int32_t other) {
          if (is_seen[other] != 0 || region_of_[other] != region_of_[f]) return;
          is_seen[other] = 1;
          piece.push_back(other);
        });
      }
      use(piece);
    }
  }
  // Free faces for which no surface is missing go to those around.
  void fill_gaps() {
    std::vector<std::vector<std::int32_t>> gaps;
    each_piece([&](const std::vector<std::int32_t>& piece) {
      if (region_of_[piece.front()] == kNoRegion) gaps.push_back(piece);
    });
    for (const std::vector<std::int32_t>& gap : gaps)
      if (lie_on(gap, regions_beside(gap))) flood(gap);
  }
  // Free faces go to the region beside them that they are nearest to, if they are nearer than
  // `reach`, from the border on.
  void flood(std::span<const std::int32_t> faces,
             double reach = std::numeric_limits<double>::max()) {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const std::int32_t f : faces) {
        if (region_of_[f] != kNoRegion) continue;
        double least = reach;
        each_beside(f, [&](std::int32_t other) {
          const std::int32_t there = region_of_[other];
          if (there < 0 || farthest(f, there) >= least) return;
          least = farthest(f, there);
          region_of_[f] = there;
          is_changed = true;
        });
      }
    }
  }
  // Small pieces of regions beside their largest one: a few samples behind an edge.
  void flood_islands() {
    constexpr std::size_t kSmall = 20;
    std::vector<std::size_t> largest(found_.size(), 0);
    std::vector<std::vector<std::int32_t>> small;
    each_piece([&](const std::vector<std::int32_t>& piece) {
      const std::int32_t r = region_of_[piece.front()];
      if (r < 0) return;
      largest[r] = std::max(largest[r], piece.size());
      if (piece.size() <= kSmall) small.push_back(piece);
    });
    for (const std::vector<std::int32_t>& piece : small) {
      if (piece.size() == largest[region_of_[piece.front()]]) continue;
      free(piece);
      flood(piece);
    }
  }
  [[nodiscard]] double longest_edge(std::int32_t face) const {
    double longest = 0;
    const auto v = topology_.face(face);
    for (std::size_t i = 0; i < v.size(); ++i)
      longest =
          std::max(longest, glm::length(positions_[v[(i + 1) % v.size()]] - positions_[v[i]]));
    return longest;
  }
  // Faces of one region that stand side by side around a vertex.
  struct Run {
    std::int32_t region = kNoRegion;
    std::vector<std::int32_t> faces{};
  };
  [[nodiscard]] std::vector<Run> runs_around(std::int32_t vertex) const {
    std::vector<Run> runs;
    for (const std::int32_t corner : topology_.corners_at(vertex)) {
      const std::int32_t f = topology_.face_of(corner);
      if (runs.empty() || runs.back().region != region_of_[f]) runs.push_back({region_of_[f]});
      runs.back().faces.push_back(f);
    }
    if (runs.size() > 1 && runs.back().region == runs.front().region) {
      runs.front().faces.insert(runs.front().faces.end(), runs.back().faces.begin(),
                                runs.back().faces.end());
      runs.pop_back();
    }
    return runs;
  }
  // Where a region has two runs around a vertex, or surfaces have no point in common near it, the
  // run goes to the one beside it that takes its faces least far from their surface.
  void tidy_around(std::int32_t vertex) {
    const std::vector<Run> runs = runs_around(vertex);
    if (runs.size() < 3 || std::ranges::any_of(runs, [](const Run& run) { return run.region < 0; }))
      return;
    const bool is_apart = !meet_near(vertex, runs);
    const Run* changed = nullptr;
    std::int32_t to = kNoRegion;
    double least = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const Run &run = runs[k], &before = runs[(k + runs.size() - 1) % runs.size()],
                &after = runs[(k + 1) % runs.size()];
      if (!is_apart && before.region != after.region &&
          std::ranges::count(runs, run.region, &Run::region) == 1)
        continue;
      for (const Run* target : {&before, &after}) {
        double costs = 0;
        for (const std::int32_t f : run.faces) costs = std::max(costs, farthest(f, target->region));
        if (costs >= least) continue;
        least = costs;
        changed = &run;
        to = target->region;
      }
    }
    if (changed == nullptr) return;
    for (const std::int32_t f : changed->faces) region_of_[f] = to;
  }
  [[nodiscard]] bool meet_near(std::int32_t vertex, std::span<const Run> runs) const {
    std::vector<SidedSurface> surfaces;
    double longest = 0;
    for (const Run& run : runs) {
      surfaces.push_back({&found_[run.region].surface, found_[run.region].sign});
      for (const std::int32_t f : run.faces) longest = std::max(longest, longest_edge(f));
    }
    double reach = 0;
    const glm::dvec3& near = positions_[vertex];
    const glm::dvec3 point = common_point(near, surfaces, {}, reach);
    return reach <= tolerance_ && glm::length(point - near) <= 2 * longest;
  }

  // Regions whose vertices are off by more than the noise, or along edges alike: pieces of what has
  // no name.
  void give_back() {
    const auto members = members_by_region();
    find_nearest();
    for (std::int32_t r = 0; r < std::ssize(members); ++r) {
      const std::size_t told = changes_of(found_[r].surface.kind).size();
      const std::vector<std::int32_t> own = own_vertices(members[r], r);
      if (own.size() <= told) continue;
      double squares = 0, products = 0, edges = 0;
      for (const std::int32_t v : own) squares += signed_off(v, r) * signed_off(v, r);
      for (const std::int32_t f : members[r]) {
        const auto v = topology_.face(f);
        for (std::size_t i = 0; i < v.size(); ++i) {
          const std::int32_t from = v[i], to = v[(i + 1) % v.size()];
          if (!is_of(from, r) || !is_of(to, r)) continue;
          products += signed_off(from, r) * signed_off(to, r);
          ++edges;
        }
      }
      if (!(edges > 0)) continue;
      const auto freedom = static_cast<double>(own.size() - told);
      // In deviations; three of its own more than chance leaves of so many.
      constexpr double kMost = 1.3, kMostAlike = 0.3, kExact = 0.1;
      const double rms = std::sqrt(squares / freedom) * kDeviations / tolerance_;
      const double alike =
          squares > 0 ? products / edges * static_cast<double>(own.size()) / squares : 0;
      // Residuals much smaller than the noise are rounding.
      const bool is_exact = rms < kExact;
      if (is_exact || (rms <= kMost + 3 / std::sqrt(2 * freedom) &&
                       alike <= kMostAlike + 1 / std::sqrt(freedom)))
        continue;
      free(members[r]);
    }
  }

  // Of samples by vertex: of the regions around it the one whose surface is nearest. A sample says
  // nothing of the others, while a vertex of an edge lies on all.
  void find_nearest() {
    nearest_.assign(positions_.size(), kNoRegion);
    for (const std::int32_t f : are_samples_ ? faces_ : std::span<const std::int32_t>()) {
      const std::int32_t r = region_of_[f];
      if (r < 0) continue;
      for (const std::int32_t v : topology_.face(f))
        if (nearest_[v] < 0 || off(v, r) < off(v, nearest_[v])) nearest_[v] = r;
    }
  }
  [[nodiscard]] bool is_of(std::int32_t vertex, std::int32_t region) const {
    return !are_samples_ || nearest_[vertex] == region;
  }
  [[nodiscard]] std::vector<std::int32_t> own_vertices(std::span<const std::int32_t> faces,
                                                       std::int32_t region) const {
    std::vector<std::int32_t> own;
    for (const std::int32_t f : faces)
      for (const std::int32_t v : topology_.face(f))
        if (is_of(v, region)) own.push_back(v);
    std::ranges::sort(own);
    own.erase(std::ranges::unique(own).begin(), own.end());
    return own;
  }
  [[nodiscard]] double signed_off(std::int32_t vertex, std::int32_t region) const {
    return signed_distance(found_[region].surface, positions_[vertex]);
  }
  [[nodiscard]] double off(std::int32_t vertex, std::int32_t region) const {
    return std::abs(signed_off(vertex, region));
  }

  // Faces at borders go to the surface beside them that they are nearest to, where that makes the
  // border no longer by more than it is worth.
  void compete() {
    constexpr int kRounds = 10;
    for (int round = 0; round < kRounds; ++round) {
      bool is_changed = false;
      for (const std::int32_t f : faces_) {
        std::int32_t best = region_of_[f];
        double least = cost(f, best);
        patches_.each_neighbour(f, [&](std::int32_t other) {
          const std::int32_t there = region_of_[other];
          if (there < 0 || there == best) return;
          if (are_samples_ && region_of_[f] < 0 && !is_explained(f, there)) return;
          const Found& to = found_[there];
          if (region_of_[f] >= 0 && !lies_on(f, to.surface, to.sign, kReach * tolerance_)) return;
          const double costs = cost(f, there);
          if (costs >= least) return;
          least = costs;
          best = there;
        });
        if (best == region_of_[f]) continue;
        region_of_[f] = best;
        is_changed = true;
      }
      if (!is_changed) break;
      const auto members = members_by_region();
      for (std::size_t r = 0; r < found_.size(); ++r) {
        if (members[r].empty()) continue;
        AnalyticSurface fitted = found_[r].surface;
        if (fit_surface(fitted, sample(patches_.points_of(members[r]))) <= kReach * tolerance_)
          found_[r].surface = fitted;
      }
    }
  }
  static constexpr double kReach = 3;  // tolerances

  // Whether each vertex of a face lies on a region's surface, or on that of one around it.
  [[nodiscard]] bool is_explained(std::int32_t face, std::int32_t region) const {
    return std::ranges::all_of(topology_.face(face), [&](std::int32_t v) {
      const auto is_on = [&](std::int32_t r) { return r >= 0 && off(v, r) <= tolerance_; };
      return is_on(region) ||
             std::ranges::any_of(topology_.corners_at(v), [&](std::int32_t corner) {
               return is_on(region_of_[topology_.face_of(corner)]);
             });
    });
  }

  // Calls use(face) for each face across an edge that is no group's border, sharp or not.
  template <class Use>
  void each_beside(std::int32_t face, const Use& use) const {
    for (std::int32_t i = 0; i < topology_.face_size(face); ++i) {
      const std::int32_t corner = topology_.first_corner(face) + i, twin = topology_.twin(corner);
      if (twin >= 0 && is_sharp_[topology_.edge_of(corner)] != kGroupBorder)
        use(topology_.face_of(twin));
    }
  }
  // Those that faces of one region, or of none, meet; ascending.
  [[nodiscard]] std::vector<std::int32_t> regions_beside(
      std::span<const std::int32_t> faces) const {
    std::vector<std::int32_t> beside;
    for (const std::int32_t f : faces)
      each_beside(f, [&](std::int32_t other) {
        const std::int32_t there = region_of_[other];
        if (there >= 0 && there != region_of_[f]) beside.push_back(there);
      });
    std::ranges::sort(beside);
    beside.erase(std::ranges::unique(beside).begin(), beside.end());
    return beside;
  }

  // Smaller regions that lie on the surface of a larger one beside them become its, whatever is
  // sharp between: then nothing is.
  void absorb() {
    auto members = members_by_region();
    std::vector<std::int32_t> order(found_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::less<>(),
                             [&](std::int32_t r) { return area_of(members[r]); });
    for (const std::int32_t r : order) {
      const std::vector<std::int32_t> beside = regions_beside(members[r]);
      for (const std::int32_t to : beside) {
        if (area_of(members[to]) < area_of(members[r])) continue;
        const Found& other = found_[to];
        double on = 0;
        for (const std::int32_t f : members[r])
          if (lies_on(f, other.surface, other.sign, 1.5 * tolerance_)) on += facets_[f].area;
        constexpr double kMost = 0.9;
        if (on < kMost * area_of(members[r])) continue;
        for (const std::int32_t f : members[r]) region_of_[f] = to;
        members[to].insert(members[to].end(), members[r].begin(), members[r].end());
        members[r].clear();
        break;
      }
    }
  }
  // Of a face that is a region's: its vertices' distances, and its border with others.
  [[nodiscard]] double cost(std::int32_t face, std::int32_t region) const {
    constexpr double kBorder = 1;  // what an edge of the border counts for
    double distance = 10 * kReach;
    if (region >= 0) distance = farthest(face, region) / tolerance_;
    double border = 0, around = 0;
    for (std::int32_t i = 0; i < topology_.face_size(face); ++i) {
      const std::int32_t corner = topology_.first_corner(face) + i, twin = topology_.twin(corner);
      const double length = glm::length(positions_[topology_.vertex_of(topology_.next(corner))] -
                                        positions_[topology_.vertex_of(corner)]);
      around += length;
      if (twin >= 0 && is_sharp_[topology_.edge_of(corner)] == 0 &&
          region_of_[topology_.face_of(twin)] != region)
        border += length;
    }
    return distance * distance + kBorder * (around > 0 ? border / around : 0);
  }
  [[nodiscard]] double farthest(std::int32_t face, std::int32_t region) const {
    double largest = 0;
    for (const std::int32_t v : topology_.face(face)) largest = std::max(largest, off(v, region));
    return largest;
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  std::span<const std::int32_t> faces_;
  double tolerance_;
  bool are_samples_;
  FacePatches patches_;
  std::vector<std::int32_t> region_of_;
  std::vector<Facet> facets_;
  double whole_ = 0;  // area
  std::vector<std::int32_t> seen_;
  std::int32_t round_ = 0;
  std::vector<Found> found_;
  std::vector<std::int32_t> nearest_;  // by vertex
};

}  // namespace

double noise_of(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                std::span<const char> is_sharp, std::span<const std::int32_t> faces) {
  constexpr std::size_t kPatches = 200, kPatchFaces = 32;
  FacePatches patches(positions, topology, is_sharp);
  const SpreadOrder order(faces.size());
  std::vector<double> left;
  for (std::size_t i = 0; i < std::min(kPatches, faces.size()); ++i) {
    const auto patch =
        patches.around(faces[order[i]], kPatchFaces, [](std::int32_t) { return true; });
    if (const auto rest = left_by_quadric(patches.points_of(patch))) left.push_back(rest->rms);
  }
  if (left.empty()) return 0;
  const auto quartile = left.begin() + std::ssize(left) / 4;
  std::ranges::nth_element(left, quartile);
  return *quartile;
}

std::vector<double> find_noisy_regions(std::span<const glm::dvec3> positions,
                                       const MeshTopology& topology, std::span<const char> is_sharp,
                                       const FaceComponents& parts, std::optional<double> tolerance,
                                       double exact, VertexPlaces places,
                                       AnalyticRegions& regions) {
  // A single triangle is flat whatever the noise, and a larger face may not be.
  FacePatches patches(positions, topology, is_sharp);
  std::vector<char> is_told;
  for (const AnalyticRegion& region : regions.regions)
    is_told.push_back(region.error <= exact && patches.points_of(region.faces).size() >
                                                   changes_of(region.surface.kind).size());
  const auto count = static_cast<std::size_t>(parts.count);
  std::vector<std::vector<std::int32_t>> faces_of(count);
  std::vector<double> whole(count), taken(count);
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const std::int32_t part = parts.of_face[f], region = regions.region_of[f];
    const double area = glm::length(area_vector(positions, topology.face(f)));
    faces_of[part].push_back(f);
    whole[part] += area;
    if (region >= 0 && is_told[region] != 0) taken[part] += area;
  }
  std::vector<double> tolerances(count, exact);
  for (std::size_t part = 0; part < count; ++part) {
    constexpr double kHalf = 0.5, kMostTolerance = 5e-3;
    constexpr double kAll = 1 - 1e-9;
    const bool are_samples = places == VertexPlaces::Samples;
    if (!are_samples && taken[part] >= (tolerance ? kAll : kHalf) * whole[part]) continue;
    double own =
        tolerance.value_or(kDeviations * noise_of(positions, topology, is_sharp, faces_of[part]));
    if (are_samples) own = std::max(own, exact);
    if (!(own > exact) && !are_samples) continue;
    if (!tolerance && own > kMostTolerance) continue;
    const double least = are_samples ? kAll * whole[part]
                         : tolerance ? taken[part]
                                     : kHalf * whole[part];
    if (NoisyFinder(positions, topology, is_sharp, faces_of[part], own, places)
            .find(least, regions))
      tolerances[part] = own;
  }
  return tolerances;
}

void move_samples(const MeshTopology& topology, const FaceComponents& parts,
                  std::span<const double> tolerances, const AnalyticRegions& regions,
                  std::vector<glm::dvec3>& positions) {
  constexpr double kMost = 3;  // longest edges
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    const auto corners = topology.corners_at(v);
    if (corners.empty()) continue;
    std::vector<std::int32_t> around;
    double longest = 0;
    for (const std::int32_t corner : corners) {
      const std::int32_t r = regions.region_of[topology.face_of(corner)];
      if (r >= 0 && std::ranges::find(around, r) == around.end()) around.push_back(r);
      longest = std::max(longest, glm::length(positions[topology.vertex_of(topology.next(corner))] -
                                              positions[v]));
    }
    const double tolerance = tolerances[parts.of_face[topology.face_of(corners[0])]];
    std::vector<SidedSurface> surfaces;
    double off = 0;
    for (const std::int32_t r : around) {
      const AnalyticRegion& region = regions.regions[r];
      surfaces.push_back({&region.surface, region.side()});
      off = std::max(off, std::abs(signed_distance(region.surface, positions[v])));
    }
    if (off <= tolerance) continue;
    double reach = 0;
    const glm::dvec3 point = common_point(positions[v], surfaces, {}, reach);
    if (reach <= tolerance && glm::length(point - positions[v]) <= kMost * longest)
      positions[v] = point;
  }
}

}  // namespace planish
