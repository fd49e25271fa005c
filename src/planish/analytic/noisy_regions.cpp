#include "planish/analytic/noisy_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "planish/analytic/face_patches.h"
#include "planish/analytic/spread_order.h"
#include "planish/core/callbacks.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr std::int32_t kElsewhere = -2;  // of other faces than those that are looked at

// The rms of what a quadric over their plane leaves of points; none where they do not tell one.
std::optional<double> left_by_quadric(std::span<const glm::dvec3> points) {
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
  return std::sqrt(squares / static_cast<double>(points.size() - kUnknowns));
}

// Five deviations of the noise are the tolerance: of 10,000 vertices none is farther off.
constexpr double kDeviations = 5;

// Of faces that are all free at first.
class NoisyFinder {
 public:
  NoisyFinder(std::span<const glm::dvec3> positions, const MeshTopology& topology,
              std::span<const char> is_sharp, std::span<const std::int32_t> faces, double tolerance)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        faces_(faces),
        tolerance_(tolerance),
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
    take_all(false);
    compete();
    absorb();
    compete();
    give_back();
    fill();
    if (!(taken() > least)) return false;
    for (AnalyticRegion& region : regions.regions)
      if (!region.faces.empty() && region_of_[region.faces.front()] != kElsewhere)
        region.faces.clear();
    for (const std::int32_t f : faces_) regions.region_of[f] = kNoRegion;
    const auto members = members_by_region();
    for (std::size_t r = 0; r < found_.size(); ++r) {
      if (members[r].empty()) continue;
      // Few vertices may lie on a surface by chance.
      constexpr double kChance = 0.7;
      double error = kChance * tolerance_;
      for (const glm::dvec3& p : patches_.points_of(members[r]))
        error = std::max(error, std::abs(signed_distance(found_[r].surface, p)));
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

  [[nodiscard]] std::optional<Found> grown(AnalyticSurface surface,
                                           std::vector<std::int32_t> seeds) {
    double turn = 0;
    for (const std::int32_t f : seeds)
      turn += facets_[f].area * glm::dot(facets_[f].normal, normal_at(surface, facets_[f].centre));
    const double sign = turn < 0 ? -1 : 1;
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
          patches_.around(seed, size, [&](std::int32_t f) { return region_of_[f] == kNoRegion; });
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

  // Large ones first, then all.
  void take_all(bool is_first) {
    const SpreadOrder order(faces_.size());
    const double least = is_first ? 0.02 * whole_ : 0;
    constexpr std::size_t kMostMisses = 100;
    std::vector<char> is_small(region_of_.size(), 0);
    std::size_t misses = 0;
    for (std::size_t i = 0; i < faces_.size() && misses < kMostMisses; ++i) {
      if (i % 16 == 0) check_stop();
      const std::int32_t seed = faces_[order[i]];
      if (region_of_[seed] != kNoRegion || is_small[seed] != 0) continue;
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

  // Regions whose vertices are off by more than the noise, or along edges alike: pieces of what has
  // no name.
  void give_back() {
    const auto members = members_by_region();
    for (std::size_t r = 0; r < members.size(); ++r) {
      const std::size_t told = changes_of(found_[r].surface.kind).size();
      const std::vector<glm::dvec3> points = patches_.points_of(members[r]);
      if (points.size() <= told) continue;
      const auto off_at = [&](const glm::dvec3& p) {
        return signed_distance(found_[r].surface, p);
      };
      double squares = 0, products = 0, edges = 0;
      for (const glm::dvec3& p : points) squares += off_at(p) * off_at(p);
      for (const std::int32_t f : members[r]) {
        const auto v = topology_.face(f);
        for (std::size_t i = 0; i < v.size(); ++i, ++edges)
          products += off_at(positions_[v[i]]) * off_at(positions_[v[(i + 1) % v.size()]]);
      }
      const auto freedom = static_cast<double>(points.size() - told);
      // In deviations; three of its own more than chance leaves of so many.
      constexpr double kMost = 1.3, kMostAlike = 0.3;
      const double rms = std::sqrt(squares / freedom) * kDeviations / tolerance_;
      const double alike =
          squares > 0 ? products / edges * static_cast<double>(points.size()) / squares : 0;
      if (rms <= kMost + 3 / std::sqrt(2 * freedom) && alike <= kMostAlike + 1 / std::sqrt(freedom))
        continue;
      for (const std::int32_t f : members[r]) region_of_[f] = kNoRegion;
    }
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

  // Faces that sharp edges cut off from the surface that they lie on: slivers.
  void fill() {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const std::int32_t f : faces_) {
        if (region_of_[f] != kNoRegion) continue;
        double least = kReach * tolerance_;
        for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
          const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
          if (twin < 0 || is_sharp_[topology_.edge_of(corner)] == kGroupBorder) continue;
          const std::int32_t there = region_of_[topology_.face_of(twin)];
          if (there < 0 || off(f, found_[there]) >= least) continue;
          least = off(f, found_[there]);
          region_of_[f] = there;
          is_changed = true;
        }
      }
    }
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
      std::vector<std::int32_t> beside;
      for (const std::int32_t f : members[r]) {
        for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
          const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
          if (twin < 0 || is_sharp_[topology_.edge_of(corner)] == kGroupBorder) continue;
          const std::int32_t there = region_of_[topology_.face_of(twin)];
          if (there >= 0 && there != r) beside.push_back(there);
        }
      }
      std::ranges::sort(beside);
      beside.erase(std::ranges::unique(beside).begin(), beside.end());
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
    if (region >= 0) distance = off(face, found_[region]) / tolerance_;
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
  [[nodiscard]] double off(std::int32_t face, const Found& found) const {
    double largest = 0;
    for (const std::int32_t v : topology_.face(face))
      largest = std::max(largest, std::abs(signed_distance(found.surface, positions_[v])));
    return largest;
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  std::span<const std::int32_t> faces_;
  double tolerance_;
  FacePatches patches_;
  std::vector<std::int32_t> region_of_;
  std::vector<Facet> facets_;
  double whole_ = 0;  // area
  std::vector<std::int32_t> seen_;
  std::int32_t round_ = 0;
  std::vector<Found> found_;
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
    if (const auto rms = left_by_quadric(patches.points_of(patch))) left.push_back(*rms);
  }
  if (left.empty()) return 0;
  const auto quartile = left.begin() + std::ssize(left) / 4;
  std::ranges::nth_element(left, quartile);
  return *quartile;
}

std::vector<double> find_noisy_regions(std::span<const glm::dvec3> positions,
                                       const MeshTopology& topology, std::span<const char> is_sharp,
                                       const FaceComponents& parts, std::optional<double> tolerance,
                                       double exact, AnalyticRegions& regions) {
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
    if (taken[part] >= (tolerance ? kAll : kHalf) * whole[part]) continue;
    const double own =
        tolerance.value_or(kDeviations * noise_of(positions, topology, is_sharp, faces_of[part]));
    if (!(own > exact) || (!tolerance && own > kMostTolerance)) continue;
    if (NoisyFinder(positions, topology, is_sharp, faces_of[part], own)
            .find(tolerance ? taken[part] : kHalf * whole[part], regions))
      tolerances[part] = own;
  }
  return tolerances;
}

}  // namespace planish
