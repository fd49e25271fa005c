#include "planish/analytic/find_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>

#include "planish/analytic/cut_regions.h"
#include "planish/analytic/face_patches.h"
#include "planish/analytic/facet_clusters.h"
#include "planish/analytic/spread_order.h"
#include "planish/core/callbacks.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"

namespace planish {
namespace {

struct Candidate {
  AnalyticSurface surface;
  bool is_inward = false;
  std::vector<std::int32_t> faces;
  std::size_t clusters = 0;
};

class RegionFinder {
 public:
  RegionFinder(std::span<const glm::dvec3> positions, const MeshTopology& topology,
               std::span<const char> is_sharp, const FacetClusters& made, double tolerance,
               bool keeps_smooth)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        tolerance_(tolerance),
        keeps_smooth_(keeps_smooth),
        parts_(face_components(topology)),
        made_(made),
        facets_(made.facets),
        doubt_(made.doubt),
        cluster_of_(made.cluster_of),
        clusters_(made.clusters),
        seen_(facets_.size(), 0),
        patches_(positions, topology, is_sharp) {
    find_directions();
    given_back_.assign(clusters_.size(), 0);
    result_.region_of.assign(facets_.size(), kNoRegion);
  }

  AnalyticRegions find() && {
    // Exact ones first.
    const double most = tolerance_;
    for (const double tolerance : {1e-7, 4e-7, most}) {
      tolerance_ = std::min(tolerance, most);
      widen();
      const bool is_last = tolerance_ == most;
      take_all(is_last);
      if (rob()) take_all(is_last);
    }
    is_cut_ =
        find_cut_regions(positions_, topology_, is_sharp_, made_, parts_, tolerance_, result_);
    take_known();
    take_slivers();
    take_planes();
    join_across();
    while (drop_doubtful()) take_planes();
    remove_empty(result_);
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool is_free(std::int32_t cluster) const {
    return result_.region_of[clusters_[cluster].faces.front()] == kNoRegion;
  }

  [[nodiscard]] std::vector<std::int32_t> faces_of(std::span<const std::int32_t> clusters) const {
    std::vector<std::int32_t> faces;
    for (const std::int32_t c : clusters)
      faces.insert(faces.end(), clusters_[c].faces.begin(), clusters_[c].faces.end());
    return faces;
  }

  [[nodiscard]] bool lies_on(std::int32_t face, const AnalyticSurface& surface, double sign) const {
    glm::dvec3 mean(0.0);
    const auto vertices = topology_.face(face);
    // A cone's apex has no normal.
    const auto is_apex = [&](const glm::dvec3& p) {
      return surface.kind == AnalyticKind::Cone &&
             glm::length(p - surface.origin) < 10 * tolerance_;
    };
    for (const std::int32_t v : vertices) {
      const glm::dvec3& p = positions_[v];
      if (!(std::abs(signed_distance(surface, p)) <= tolerance_)) return false;
      if (!is_apex(p)) mean += normal_at(surface, p);
    }
    constexpr double kSlack = 0.5 * kDegree, kMostTurn = 45 * kDegree;
    const double length = glm::length(mean);
    if (!(length > 0.5)) return false;
    mean /= length;
    double spread = 0;
    for (const std::int32_t v : vertices)
      if (!is_apex(positions_[v]))
        spread = std::max(spread, angle_between(normal_at(surface, positions_[v]), mean));
    if (spread > kMostFacetTurn) return false;
    // Between the vertices, too: a disc whose border lies on a torus, which touches it there, does
    // not.
    double longest = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const glm::dvec3 &from = positions_[vertices[i]],
                       &to = positions_[vertices[(i + 1) % vertices.size()]];
      longest = std::max(longest, glm::length(to - from));
      const double sag = 0.75 * glm::length(to - from) * spread;
      if (std::abs(signed_distance(surface, 0.5 * (from + to))) > sag + 2 * tolerance_)
        return false;
    }
    const Facet& facet = facets_[face];
    if (!(facet.area > 0)) return true;
    // The plane through three points of a surface turns from it by its curvature times the radius
    // of their circle, which is as many times the longest edge as that is the height.
    const double slender = longest * longest / (2 * facet.area);
    return angle_between(sign * facet.normal, mean) <=
           std::min(spread * slender, kMostTurn) + kSlack + doubt_[face];
  }

  // As far as the surface goes from these faces on, fitted on the way; none where they do not lie
  // on it.
  [[nodiscard]] std::optional<Candidate> grown(AnalyticSurface surface,
                                               std::vector<std::int32_t> seeds) {
    if (!(fit_surface(surface, patches_.points_of(seeds), tolerance_) <= tolerance_))
      return std::nullopt;
    double turn = 0;
    for (const std::int32_t f : seeds)
      turn += facets_[f].area *
              glm::dot(facets_[f].normal, normal_at(surface, positions_[topology_.face(f)[0]]));
    const double sign = turn < 0 ? -1 : 1;
    for (const std::int32_t f : seeds)
      if (!lies_on(f, surface, sign)) return std::nullopt;
    std::vector<std::int32_t> faces = seeds;
    constexpr int kMostRounds = 60;
    for (int round = 0; round < kMostRounds; ++round) {
      ++round_;
      std::vector<std::int32_t> next;
      for (const std::int32_t f : faces) {
        if (!lies_on(f, surface, sign)) continue;
        seen_[f] = round_;
        next.push_back(f);
      }
      if (next.empty()) return std::nullopt;
      // Until the faces are half as many again, then what they tell is fitted.
      const std::size_t enough = next.size() + next.size() / 2 + 2;
      bool is_whole = true;
      for (std::size_t i = 0; i < next.size(); ++i) {
        patches_.each_neighbour(next[i], [&](std::int32_t other) {
          if (seen_[other] == round_ || result_.region_of[other] != kNoRegion) return;
          if (next.size() >= enough) {
            is_whole = false;
            return;
          }
          if (!lies_on(other, surface, sign)) return;
          seen_[other] = round_;
          next.push_back(other);
        });
      }
      const bool is_same = next.size() == faces.size();
      faces = std::move(next);
      AnalyticSurface fitted = surface;
      if (!(fit_surface(fitted, patches_.points_of(faces), tolerance_) <= tolerance_)) break;
      surface = fitted;
      if (is_same && is_whole) break;
    }
    Candidate candidate{surface, sign < 0, {}, 0};
    for (const std::int32_t f : faces)
      if (lies_on(f, surface, sign)) candidate.faces.push_back(f);
    candidate.clusters = clusters_of(candidate.faces).size();
    return candidate;
  }

  // Whether it is no larger than parts have it: what is nearly flat is told by nothing.
  [[nodiscard]] static bool is_sensible(const AnalyticSurface& surface) {
    constexpr double kMostRadius = 5, kMostTube = 0.5;  // of the diagonal
    return surface.radius <= kMostRadius && surface.minor <= kMostTube;
  }

  // How far the middles of a facet's edges are from a surface that its vertices lie on: at most.
  [[nodiscard]] double sag_of(std::int32_t face, const AnalyticSurface& surface) const {
    const auto vertices = topology_.face(face);
    double largest = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      largest =
          std::max(largest, std::abs(signed_distance(
                                surface, 0.5 * (positions_[vertices[i]] +
                                                positions_[vertices[(i + 1) % vertices.size()]]))));
    return largest;
  }
  // Whether its facets stay away from it alike: a flat disc whose border lies on a sphere does not
  // as the facets beside it.
  [[nodiscard]] bool is_even(const Candidate& candidate) const {
    constexpr double kMost = 12;
    std::vector<double> sags;
    for (const std::int32_t f : candidate.faces) sags.push_back(sag_of(f, candidate.surface));
    const auto middle = sags.begin() + std::ssize(sags) / 2;
    std::ranges::nth_element(sags, middle);
    return *std::ranges::max_element(sags) <= std::max(kMost * *middle, 20 * tolerance_);
  }

  // The surface of a kind through whole clusters, grown.
  [[nodiscard]] std::optional<Candidate> through(AnalyticKind kind,
                                                 std::span<const std::int32_t> clusters,
                                                 const AnalyticSurface* around = nullptr) {
    std::vector<Facet> facets;
    for (const std::int32_t c : clusters) facets.push_back(clusters_[c].facet);
    // Flat pieces of such a surface in a grid tell it at once.
    constexpr double kNear = 5e-3;  // of their size
    return through(kind, facets, faces_of(clusters), around, kNear);
  }
  [[nodiscard]] std::optional<Candidate> through_faces(AnalyticKind kind,
                                                       std::span<const std::int32_t> clusters,
                                                       const AnalyticSurface* around = nullptr) {
    std::vector<std::int32_t> faces = faces_of(clusters);
    std::vector<Facet> facets;
    for (const std::int32_t f : faces)
      if (facets_[f].area > 0) facets.push_back(facets_[f]);
    return through(kind, facets, std::move(faces), around);
  }
  [[nodiscard]] std::optional<Candidate> through(AnalyticKind kind, std::span<const Facet> facets,
                                                 std::vector<std::int32_t> faces,
                                                 const AnalyticSurface* around = nullptr,
                                                 double near = 1) {
    const std::vector<glm::dvec3> points = patches_.points_of(faces);
    // One place more than tells the surface, so that something speaks against it.
    if (points.size() <= changes_of(kind).size()) return std::nullopt;
    const auto guess = guess_surface(kind, points, facets, around);
    if (!guess) return std::nullopt;
    double size = 0, off = 0;
    for (const glm::dvec3& p : points) {
      size = std::max(size, glm::length(p - points.front()));
      off = std::max(off, std::abs(signed_distance(*guess, p)));
    }
    if (!(off <= near * size + tolerance_)) return std::nullopt;
    auto candidate = grown(*guess, std::move(faces));
    if (candidate && !(is_sensible(candidate->surface) && is_even(*candidate))) candidate.reset();
    return candidate;
  }

  // Takes surfaces through free clusters until there are none: large ones at once, the others by
  // their size, as long as all their faces are free.
  void take_all(bool is_last) {
    while (take_some(is_last)) {
    }
  }
  // Whether any was taken and others are to be looked for again.
  bool take_some(bool is_last) {
    const std::size_t before = result_.regions.size();
    constexpr std::size_t kLarge = 24;  // clusters
    std::vector<Candidate> small;
    std::vector<char> is_covered(clusters_.size(), 0);
    std::vector<std::size_t> misses(static_cast<std::size_t>(parts_.count), 0),
        hits(misses.size(), 0);
    const SpreadOrder order(clusters_.size());
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      if (i % 64 == 0) check_stop();
      const auto c = static_cast<std::int32_t>(order[i]);
      if (is_covered[c] != 0 || !is_free(c)) continue;
      // Of what has no names not everything is looked at.
      constexpr std::size_t kMostMisses = 100;
      const std::int32_t part = parts_.of_face[clusters_[c].faces.front()];
      if (misses[part] > (is_last ? kMostMisses : kMostMisses / 3) + hits[part]) continue;
      auto best = best_through(c);
      if (!best) {
        ++misses[part];
        continue;
      }
      hits[part] += best->clusters;
      if (best->clusters >= kLarge) {
        take(std::move(*best));
        continue;
      }
      for (const std::int32_t f : best->faces) is_covered[cluster_of_[f]] = 1;
      small.push_back(std::move(*best));
    }
    std::ranges::stable_sort(small, std::greater<>(), &Candidate::clusters);
    bool is_left = false;
    for (Candidate& candidate : small) {
      const auto is_taken = [&](std::int32_t f) { return result_.region_of[f] != kNoRegion; };
      if (std::ranges::any_of(candidate.faces, is_taken)) {
        is_left = true;
      } else {
        take(std::move(candidate));
      }
    }
    return is_left && result_.regions.size() > before;
  }

  // Clusters that lie on a surface that is known from elsewhere: arcs too short to tell their own.
  void take_known() {
    for (std::int32_t c = 0; c < std::ssize(clusters_); ++c) {
      if (!is_free(c)) continue;
      const auto& neighbours = clusters_[c].neighbours;
      if (std::ranges::none_of(neighbours, [&](std::int32_t other) { return is_free(other); }))
        continue;
      for (std::size_t r = 0; r < result_.regions.size(); ++r) {
        const AnalyticRegion known = result_.regions[r];
        if (known.faces.empty() || known.surface.kind == AnalyticKind::Plane) continue;
        const double sign = known.side();
        const auto lies = [&](double side) {
          return std::ranges::all_of(
              clusters_[c].faces, [&](std::int32_t f) { return lies_on(f, known.surface, side); });
        };
        const bool is_same = lies(sign);
        if (!is_same && !lies(-sign)) continue;
        Candidate candidate{known.surface, is_same == known.is_inward, clusters_[c].faces, 0};
        ++round_;
        for (const std::int32_t f : candidate.faces) seen_[f] = round_;
        for (std::size_t i = 0; i < candidate.faces.size(); ++i)
          patches_.each_neighbour(candidate.faces[i], [&](std::int32_t other) {
            if (seen_[other] == round_ || result_.region_of[other] != kNoRegion ||
                !lies_on(other, known.surface, is_same ? sign : -sign))
              return;
            seen_[other] = round_;
            candidate.faces.push_back(other);
          });
        if (clusters_of(candidate.faces).size() < 2) continue;
        take(std::move(candidate));
        break;
      }
    }
  }

  // Regions as far as the tolerance of now lets them, and those that are one then.
  void widen() {
    for (std::size_t r = 0; r < result_.regions.size(); ++r) {
      AnalyticRegion& region = result_.regions[r];
      if (region.faces.empty()) continue;
      for (const std::int32_t f : region.faces) result_.region_of[f] = kNoRegion;
      auto candidate = grown(region.surface, region.faces);
      if (candidate && candidate->faces.size() >= region.faces.size()) {
        region.surface = candidate->surface;
        region.faces = std::move(candidate->faces);
      }
      for (const std::int32_t f : region.faces) result_.region_of[f] = static_cast<std::int32_t>(r);
    }
    join_across();
  }
  // Neighbours that are one surface, whatever is sharp between them: then nothing is.
  void join_across() {
    for (std::size_t r = 0; r < result_.regions.size(); ++r) {
      for (bool is_changed = true; is_changed;) {
        is_changed = false;
        const std::vector<std::int32_t> others = beside(r);
        is_changed =
            std::ranges::any_of(others, [&](std::int32_t other) { return join(r, other); });
      }
    }
  }
  // Faces of smaller regions that lie on a larger one, too, become its: pieces of it that were seen
  // before it was whole. What is left of those is free. Whether there were any.
  bool rob() {
    bool is_any = false;
    std::vector<std::size_t> order(result_.regions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto size = [&](std::size_t r) { return result_.regions[r].faces.size(); };
    std::ranges::stable_sort(order, std::greater<>(), size);
    for (const std::size_t r : order) {
      AnalyticRegion& region = result_.regions[r];
      if (region.faces.empty()) continue;
      std::vector<std::int32_t> robbed;
      const std::size_t before = region.faces.size();
      const auto own = static_cast<std::int32_t>(r);
      for (std::size_t i = 0; i < region.faces.size(); ++i)
        patches_.each_neighbour(region.faces[i], [&](std::int32_t other) {
          const std::int32_t there = result_.region_of[other];
          if (there == own || there == kNoRegion || size(there) >= before ||
              !lies_on(other, region.surface, region.side()))
            return;
          robbed.push_back(there);
          result_.region_of[other] = own;
          region.faces.push_back(other);
        });
      std::ranges::sort(robbed);
      robbed.erase(std::ranges::unique(robbed).begin(), robbed.end());
      is_any = is_any || !robbed.empty();
      for (const std::int32_t other : robbed) {
        for (const std::int32_t f : result_.regions[other].faces)
          if (result_.region_of[f] == other) result_.region_of[f] = kNoRegion;
        result_.regions[other].faces.clear();
      }
    }
    return is_any;
  }

  [[nodiscard]] std::vector<std::int32_t> beside(std::size_t region) const {
    std::vector<std::int32_t> result;
    for (const std::int32_t f : result_.regions[region].faces) {
      for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
        const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
        if (twin < 0 || is_sharp_[topology_.edge_of(corner)] == kGroupBorder) continue;
        const std::int32_t there = result_.region_of[topology_.face_of(twin)];
        if (there != kNoRegion && there != static_cast<std::int32_t>(region))
          result.push_back(there);
      }
    }
    std::ranges::sort(result);
    result.erase(std::ranges::unique(result).begin(), result.end());
    return result;
  }
  bool join(std::size_t to, std::int32_t from) {
    AnalyticRegion &first = result_.regions[to], &second = result_.regions[from];
    if (first.surface.kind != second.surface.kind || first.is_inward != second.is_inward)
      return false;
    // What is one has the other's numbers, nearly.
    if (first.surface.kind == AnalyticKind::Plane
            ? glm::dot(first.surface.axis, second.surface.axis) < 0.999
            : std::abs(signed_distance(first.surface,
                                       positions_[topology_.face(second.faces.front())[0]])) > 1e-3)
      return false;
    std::vector<std::int32_t> faces = first.faces;
    faces.insert(faces.end(), second.faces.begin(), second.faces.end());
    AnalyticSurface both = first.surface;
    if (!(fit_surface(both, patches_.points_of(faces), tolerance_) <= tolerance_)) return false;
    for (const std::int32_t f : second.faces) result_.region_of[f] = static_cast<std::int32_t>(to);
    second.faces.clear();
    first.faces = std::move(faces);
    first.surface = both;
    return true;
  }

  std::optional<Candidate> best_through(std::int32_t cluster) {
    constexpr std::size_t least = 3;
    std::vector<std::int32_t> beside;
    for (const std::int32_t c : clusters_[cluster].neighbours)
      if (is_free(c)) beside.push_back(c);
    if (beside.size() < 2 || beside.size() > kMostNeighbours) return std::nullopt;
    std::optional<Candidate> best;
    std::vector<std::vector<std::int32_t>> known;  // clusters of what was grown
    const auto consider = [&](std::optional<Candidate> candidate,
                              const AnalyticSurface* ring = nullptr) {
      if (!candidate || candidate->clusters < least) return false;
      if (!is_told(candidate->surface, candidate->faces, ring)) return false;
      known.push_back(clusters_of(candidate->faces));
      if (!best || candidate->clusters > best->clusters) best = std::move(candidate);
      return true;
    };
    const auto is_known = [&](std::int32_t a, std::int32_t b) {
      return std::ranges::any_of(known, [&](const auto& clusters) {
        return std::ranges::binary_search(clusters, a) && std::ranges::binary_search(clusters, b);
      });
    };
    for (std::size_t i = 0; i < beside.size(); ++i) {
      for (std::size_t j = i + 1; j < beside.size(); ++j) {
        const std::array<std::int32_t, 3> three{beside[i], cluster, beside[j]};
        if (is_known(beside[i], beside[j])) continue;
        std::optional<AnalyticSurface> ring;
        for (const AnalyticKind kind : {AnalyticKind::Cylinder, AnalyticKind::Cone}) {
          auto candidate = through(kind, three);
          if (!candidate) continue;
          ring = candidate->surface;
          consider(std::move(candidate));
          break;
        }
        for (std::size_t k = 0; k < beside.size(); ++k) {
          if (k == i || k == j) continue;
          const std::array<std::int32_t, 4> four{beside[i], cluster, beside[j], beside[k]};
          if (is_known(beside[i], beside[k]) && is_known(beside[j], beside[k])) continue;
          if (consider(through(AnalyticKind::Sphere, four), ring ? &*ring : nullptr)) continue;
          if (ring) consider(through(AnalyticKind::Torus, four, &*ring));
        }
      }
    }
    for (const std::size_t size : {12u, 30u}) {
      const std::vector<std::int32_t> patch = patch_around(cluster, size);
      for (const AnalyticKind kind : {AnalyticKind::Cylinder, AnalyticKind::Cone,
                                      AnalyticKind::Sphere, AnalyticKind::Torus}) {
        if (is_known(patch.front(), patch.back())) break;
        consider(through_faces(kind, patch));
      }
    }
    if (best) return best;
    // A cone's axis is told badly by few facets, and is that of other surfaces as a rule.
    const std::vector<std::int32_t> patch = patch_around(cluster, 30);
    for (const glm::dvec3& direction : directions_) {
      const AnalyticSurface about{.axis = direction};
      consider(through_faces(AnalyticKind::Cone, patch, &about));
    }
    return best;
  }

  // Normals of the largest clusters, distinct ones.
  void find_directions() {
    constexpr std::size_t kMost = 8;
    std::vector<std::size_t> order(clusters_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::size_t c) { return clusters_[c].facet.area; });
    for (const std::size_t c : order) {
      if (directions_.size() == kMost) return;
      const glm::dvec3& normal = clusters_[c].facet.normal;
      const auto is_same = [&](const glm::dvec3& other) {
        return glm::length(glm::cross(normal, other)) < 1e-4;
      };
      if (std::ranges::none_of(directions_, is_same)) directions_.push_back(normal);
    }
  }

  // Free clusters around one, none of which is much larger than it.
  [[nodiscard]] std::vector<std::int32_t> patch_around(std::int32_t cluster,
                                                       std::size_t size) const {
    constexpr double kMostTimes = 30;
    std::vector<std::int32_t> patch{cluster};
    for (std::size_t i = 0; i < patch.size() && patch.size() < size; ++i) {
      for (const std::int32_t c : clusters_[patch[i]].neighbours) {
        if (!is_free(c) || std::ranges::find(patch, c) != patch.end()) continue;
        if (clusters_[c].facet.area > kMostTimes * clusters_[cluster].facet.area) continue;
        patch.push_back(c);
      }
    }
    return patch;
  }

  void take(Candidate candidate) {
    const auto index = static_cast<std::int32_t>(result_.regions.size());
    AnalyticRegion region{candidate.surface, candidate.is_inward, std::move(candidate.faces), 0};
    for (const std::int32_t f : region.faces) {
      result_.region_of[f] = index;
      for (const std::int32_t v : topology_.face(f))
        region.error =
            std::max(region.error, std::abs(signed_distance(region.surface, positions_[v])));
    }
    result_.regions.push_back(std::move(region));
  }

  // Faces that no surface took since sharp edges were found along them, or normals of no width
  // were looked at: where a surface beside passes through all of their vertices.
  void take_slivers() {
    constexpr std::size_t kMostSliver = 2;  // more in a plane are one
    std::vector<std::int32_t> free;
    for (std::int32_t f = 0; f < std::ssize(facets_); ++f)
      if (result_.region_of[f] == kNoRegion &&
          clusters_[cluster_of_[f]].faces.size() <= kMostSliver)
        free.push_back(f);
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const std::int32_t f : free) {
        if (result_.region_of[f] != kNoRegion) continue;
        for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
          const std::int32_t twin = topology_.twin(topology_.first_corner(f) + i);
          const std::int32_t region =
              twin < 0 ? kNoRegion : result_.region_of[topology_.face_of(twin)];
          if (region == kNoRegion) continue;
          AnalyticRegion& to = result_.regions[region];
          if (is_sharp_[topology_.edge_of(topology_.first_corner(f) + i)] == kGroupBorder) continue;
          if (!lies_on(f, to.surface, to.side()) && !fills_notch(f, region)) continue;
          result_.region_of[f] = region;
          to.faces.push_back(f);
          is_changed = true;
          break;
        }
      }
    }
  }

  // Whether all but one of a triangle's edges are those of a region on whose surface its vertices
  // lie, and which it looks like: not the end of a prism.
  [[nodiscard]] bool fills_notch(std::int32_t face, std::int32_t region) const {
    constexpr double kMostTurn = 60 * kDegree;
    if (topology_.face_size(face) != 3) return false;
    const AnalyticRegion& to = result_.regions[region];
    std::int32_t shared = 0;
    glm::dvec3 mean(0.0);
    for (std::int32_t i = 0; i < 3; ++i) {
      const std::int32_t corner = topology_.first_corner(face) + i, twin = topology_.twin(corner);
      if (twin >= 0 && result_.region_of[topology_.face_of(twin)] == region) ++shared;
      const glm::dvec3& p = positions_[topology_.vertex_of(corner)];
      if (std::abs(signed_distance(to.surface, p)) > tolerance_) return false;
      mean += normal_at(to.surface, p) * to.side();
    }
    return shared >= 2 && angle_between(facets_[face].normal, mean) < kMostTurn;
  }

  // What no other surface took, and meets nothing of its size that none took smoothly. Facets that
  // turn by more than samples of a smooth surface do are none, unless all of it is to be smooth.
  [[nodiscard]] bool is_plane(std::int32_t cluster) const {
    constexpr double kSmall = 0.05, kMostTurn = 29 * kDegree;
    const Facet& facet = clusters_[cluster].facet;
    return std::ranges::none_of(clusters_[cluster].neighbours, [&](std::int32_t c) {
      return is_free(c) && clusters_[c].facet.area > kSmall * facet.area &&
             (keeps_smooth_ || angle_between(clusters_[c].facet.normal, facet.normal) < kMostTurn);
    });
  }
  void take_planes() {
    constexpr std::int32_t kMostGivenBack = 3;  // else two that doubt each other never end
    std::vector<std::int32_t> planes;
    for (std::int32_t c = 0; c < std::ssize(clusters_); ++c)
      if (is_free(c) && given_back_[c] < kMostGivenBack && is_plane(c)) planes.push_back(c);
    for (const std::int32_t c : planes) take_plane(c);
  }

  // Small curved regions that meet smoothly what no surface took, or another surface at an angle:
  // pieces of a surface that has no name. So are rows of facets around an axis, however long, which
  // lie on cones whatever they are rows of, and single facets. Whether there were any.
  bool drop_doubtful() {
    // Where they differ by more they meet in an edge, unless they do so on both sides.
    constexpr double kMeets = 1 * kDegree, kEdge = 12 * kDegree, kBothEdges = 24 * kDegree;
    constexpr double kRowsMeet = 0.1 * kDegree;  // which tell their cones well
    constexpr std::size_t kSmall = 24;           // clusters
    constexpr std::size_t kFacet = 4;            // points
    std::vector<std::int32_t> doubtful;
    for (std::size_t r = 0; r < result_.regions.size(); ++r) {
      const AnalyticRegion& region = result_.regions[r];
      if (region.faces.empty()) continue;
      if (r < is_cut_.size() && is_cut_[r] != 0) continue;
      const bool is_plane = region.surface.kind == AnalyticKind::Plane;
      if (is_plane && patches_.points_of(region.faces).size() > kFacet) continue;
      const bool is_small = clusters_of(region.faces).size() < kSmall;
      const bool is_one_row = !is_plane && has_no_inside(region);
      if (!is_small && !is_one_row) continue;
      double around = 0, odd = 0, on_both = 0;  // lengths of its border
      for (const std::int32_t f : region.faces) {
        for (std::int32_t i = 0; i < topology_.face_size(f); ++i) {
          const std::int32_t corner = topology_.first_corner(f) + i, twin = topology_.twin(corner);
          const std::int32_t there =
              twin < 0 ? kNoRegion : result_.region_of[topology_.face_of(twin)];
          if (twin >= 0 && there == static_cast<std::int32_t>(r)) continue;
          const double length =
              glm::length(positions_[topology_.vertex_of(topology_.next(corner))] -
                          positions_[topology_.vertex_of(corner)]);
          around += length;
          if (twin < 0 || is_sharp_[topology_.edge_of(corner)] != 0) continue;
          if (there == kNoRegion) {
            odd += is_small ? length : 0;
            continue;
          }
          const double turn = turn_at(f, topology_.face_of(twin), region, result_.regions[there]);
          if (!(turn > (is_small ? kMeets : kRowsMeet))) continue;
          if (turn < kEdge) odd += length;
          if (is_one_row && turn < kBothEdges) on_both += length;
        }
      }
      constexpr double kPart = 0.1;
      if (odd > kPart * around || on_both > (1 - kPart) * around)
        doubtful.push_back(static_cast<std::int32_t>(r));
    }
    for (const std::int32_t r : doubtful) {
      for (const std::int32_t c : clusters_of(result_.regions[r].faces)) ++given_back_[c];
      for (const std::int32_t f : result_.regions[r].faces) result_.region_of[f] = kNoRegion;
      result_.regions[r].faces.clear();
    }
    return !doubtful.empty();
  }
  // Whether it has no vertex inside.
  [[nodiscard]] bool has_no_inside(const AnalyticRegion& region) const {
    const std::int32_t own = result_.region_of[region.faces.front()];
    return std::ranges::all_of(region.faces, [&](std::int32_t f) {
      return std::ranges::all_of(topology_.face(f), [&](std::int32_t v) {
        return topology_.is_boundary_vertex(v) ||
               std::ranges::any_of(topology_.corners_at(v), [&](std::int32_t corner) {
                 return result_.region_of[topology_.face_of(corner)] != own;
               });
      });
    });
  }
  // What two regions' normals differ by where their faces meet: at most.
  [[nodiscard]] double turn_at(std::int32_t face, std::int32_t other, const AnalyticRegion& region,
                               const AnalyticRegion& beside) const {
    double largest = 0;
    for (const std::int32_t v : topology_.face(face)) {
      if (std::ranges::find(topology_.face(other), v) == topology_.face(other).end()) continue;
      const glm::dvec3& p = positions_[v];
      largest = std::max(largest, angle_between(region.normal_at(p), beside.normal_at(p)));
    }
    return largest;
  }

  // Ascending.
  [[nodiscard]] std::vector<std::int32_t> clusters_of(std::span<const std::int32_t> faces) const {
    std::vector<std::int32_t> clusters;
    for (const std::int32_t f : faces) clusters.push_back(cluster_of_[f]);
    std::ranges::sort(clusters);
    clusters.erase(std::ranges::unique(clusters).begin(), clusters.end());
    return clusters;
  }

  // Whether a cone or cylinder passes through them, too: a row of facets between two circles.
  [[nodiscard]] bool is_row(std::span<const std::int32_t> faces,
                            std::span<const glm::dvec3> points) const {
    std::vector<Facet> facets;
    for (const std::int32_t f : faces) facets.push_back(facets_[f]);
    for (const AnalyticKind kind : {AnalyticKind::Cylinder, AnalyticKind::Cone}) {
      auto row = guess_surface(kind, points, facets);
      if (row && fit_surface(*row, points, tolerance_) <= tolerance_) return true;
    }
    return false;
  }

  // Whether points speak for a surface that has been fitted to them, beyond those that tell it: a
  // circle passes through any three.
  [[nodiscard]] bool is_told(const AnalyticSurface& surface, std::span<const std::int32_t> faces,
                             const AnalyticSurface* ring) {
    std::size_t least = 4;
    std::vector<double> places;
    double size = surface.radius;
    const std::vector<glm::dvec3> points = patches_.points_of(faces);
    glm::dvec3 axis = surface.axis, mean(0.0);
    if (surface.kind == AnalyticKind::Sphere) {
      if (is_row(faces, points)) return false;
      least = 3;
      for (const std::int32_t f : faces) mean += facets_[f].area * facets_[f].normal;
      axis = ring != nullptr ? ring->axis : mean / std::max(glm::length(mean), 1e-300);
    }
    const AxisFrame frame(axis);
    // Angles from that of the first point, so that none is at the border of a turn.
    std::optional<double> first;
    const auto beside_first = [&](double angle) {
      if (!first) first = angle;
      return std::remainder(angle - *first, 2 * std::numbers::pi);
    };
    for (const glm::dvec3& p : points) {
      const glm::dvec3 from = p - surface.origin;
      const double x = glm::dot(from, frame.x), y = glm::dot(from, frame.y),
                   h = glm::dot(from, axis);
      switch (surface.kind) {
        case AnalyticKind::Cylinder:
          places.push_back(size * beside_first(portable::atan2(y, x)));
          break;
        case AnalyticKind::Sphere:
          places.push_back(h);
          break;
        case AnalyticKind::Torus:
          size = surface.minor;
          places.push_back(
              size * beside_first(portable::atan2(h, portable::hypot(x, y) - surface.radius)));
          break;
        default:
          return true;
      }
    }
    std::ranges::sort(places);
    std::size_t count = places.empty() ? 0 : 1;
    double widest = 0, narrowest = std::numeric_limits<double>::max();
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double step = places[i] - places[i - 1];
      if (step <= 10 * tolerance_) continue;
      ++count;
      widest = std::max(widest, step);
      narrowest = std::min(narrowest, step);
    }
    // Four may lie on a circle by symmetry, as a plane with a strip of the fillet on either side.
    constexpr std::size_t kFew = 6;
    constexpr double kEven = 3;
    const bool is_even =
        surface.kind == AnalyticKind::Sphere || count > kFew || widest <= kEven * narrowest;
    return count >= least && is_even;
  }

  void take_plane(std::int32_t cluster) {
    const std::vector<std::int32_t>& faces = clusters_[cluster].faces;
    const std::vector<glm::dvec3> points = patches_.points_of(faces);
    auto plane =
        guess_surface(AnalyticKind::Plane, points, std::span(&clusters_[cluster].facet, 1));
    if (!plane) return;
    const glm::dvec3 outside = plane->axis;
    (void)fit_surface(*plane, points);
    if (glm::dot(plane->axis, outside) < 0) plane->axis = -plane->axis;
    take(Candidate{*plane, false, faces, 1});
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  double tolerance_;
  bool keeps_smooth_;
  FaceComponents parts_;
  const FacetClusters& made_;
  const std::vector<Facet>& facets_;
  const std::vector<double>& doubt_;
  const std::vector<std::int32_t>& cluster_of_;
  const std::vector<FacetCluster>& clusters_;
  std::vector<std::int32_t> given_back_;  // by cluster: how often
  std::vector<glm::dvec3> directions_;
  std::vector<std::int32_t> seen_;
  FacePatches patches_;
  std::int32_t round_ = 0;
  std::vector<char> is_cut_;  // by region, of those until then
  AnalyticRegions result_;
};

}  // namespace

void remove_empty(AnalyticRegions& regions) {
  std::vector<std::int32_t> number;
  std::int32_t count = 0;
  for (const AnalyticRegion& region : regions.regions)
    number.push_back(region.faces.empty() ? kNoRegion : count++);
  std::erase_if(regions.regions, [](const AnalyticRegion& r) { return r.faces.empty(); });
  for (std::int32_t& r : regions.region_of)
    if (r != kNoRegion) r = number[r];
}

AnalyticRegions find_regions(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                             std::span<const char> is_sharp, double tolerance, bool keeps_smooth) {
  const FacetClusters made = make_facet_clusters(positions, topology, is_sharp, tolerance);
  return RegionFinder(positions, topology, is_sharp, made, tolerance, keeps_smooth).find();
}

}  // namespace planish
