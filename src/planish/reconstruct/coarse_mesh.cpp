// Based on: the witnesses of V. de Silva, G. Carlsson, "Topological Estimation Using Witness
// Complexes", 2004 (few points carry the shape, all judge it), and M. Garland, P. Heckbert, "Fast
// Polygonal Approximation of Terrains and Height Fields", 1995 (insertion where the error is).
#include "planish/reconstruct/coarse_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/thin_points.h"
#include "planish/reconstruct/turn_by_normals.h"
#include "planish/reconstruct/witnesses.h"

namespace planish {
namespace {

using Indices = std::vector<std::int32_t>;

// A mesh that is just within the tolerance leaves collapses no room: so near all are to be to the
// first. What the second is too far from is little, and needs but be within the tolerance.
constexpr double kObjectingTolerances = 0.5;
constexpr int kMostMeshings = 10;
// Times the samples that were too few where a point objects; after some insertions those that still
// do are few, and all of them become samples.
constexpr int kThinnedInsertions = 2;
constexpr double kFinerRadius = 0.5, kFinestSpacings = 1.0 / 16;
constexpr int kMostThinnings = 6, kLooksForStrays = 3;
// Cosine of the angle to a normal below which something is across from a sample or along it; the
// share of samples that may have another across; and what the radius is multiplied by otherwise.
constexpr double kAcross = 0.8, kMostJoined = 1e-3, kSheetRadius = 0.6;
constexpr std::size_t kSheetNeighbours = 24, kSheetGrain = 512;
// Of the time of a meshing and what follows it, and of what is left of all when one begins.
constexpr double kMeshedShare = 0.7, kShareOfMeshing = 0.6;
// Samples may be so many times more than asked for.
constexpr double kMostSamples = 1.3;

Indices merged(const Indices& a, const Indices& b) {
  Indices all;
  all.reserve(a.size() + b.size());
  std::ranges::merge(a, b, std::back_inserter(all));
  return all;
}

class CoarseMesher {
 public:
  CoarseMesher(OrderedPoints& points, PointCritic& critic, const Mesher& mesher,
               const CoarseOptions& options)
      : points_(points), critic_(critic), mesher_(mesher), options_(options) {}

  CoarseMesh run() {
    choose_samples();
    RoundParts parts(options_.callbacks, kShareOfMeshing);
    while (mesh_and_ask(parts.next())) {
    }
    turn_over();
    for (const std::int32_t carrier : result_.mesh.carriers) result_.strayed_count += carrier < 0;
    result_.strayed_count -= std::ssize(result_.mesh.vertex_points);
    options_.callbacks.report("mesh", 1);
    return std::move(result_);
  }

 private:
  // As many as asked for, as even as the points allow; or more, where these would not tell the two
  // sides of a sheet apart: a front then joins them, and a tunnel between them has no witness.
  void choose_samples() {
    thin_to_count();
    remove_strays();
    while (joins_sheets() && radius_ > critic_.spacing()) {
      radius_ *= kSheetRadius;
      samples_ = thin_points(points_, std::nullopt, radius_, {});
      remove_strays();
    }
    result_.sample_count = std::ssize(samples_);
  }

  void thin_to_count() {
    const double wanted = static_cast<double>(options_.least_samples);
    // A square of the spacing's side has about a point.
    radius_ = critic_.spacing() *
              std::sqrt(0.7 * static_cast<double>(points_.size()) / std::max(wanted, 1.0));
    for (int attempt = 0; attempt < kMostThinnings; ++attempt) {
      samples_ = thin_points(points_, std::nullopt, radius_, {});
      const double ratio = static_cast<double>(samples_.size()) / wanted;
      if (ratio <= kMostSamples && ratio >= 1 / kMostSamples) break;
      radius_ *= std::sqrt(std::clamp(ratio, 0.1, 10.0));
    }
  }

  // Where one was taken out others may stand.
  void remove_strays() {
    Indices fresh = std::exchange(samples_, {});
    for (int look = 0; look < kLooksForStrays && !fresh.empty(); ++look) {
      const std::size_t before = points_.size();
      critic_.remove_strays(fresh, samples_);
      samples_ = merged(samples_, fresh);
      if (points_.size() == before) break;
      fresh = thin_points(points_, std::nullopt, radius_, samples_);
    }
  }

  // Whether more than a few samples have one across from them, on a surface along their own, that
  // is no farther than those beside them are.
  [[nodiscard]] bool joins_sheets() const {
    std::vector<glm::dvec3> places;
    places.reserve(samples_.size());
    for (const std::int32_t sample : samples_) places.push_back(points_[sample]);
    const std::vector<glm::dvec3> normals = critic_.normals_at(samples_);
    const PointTree tree(places);
    std::vector<std::uint8_t> joined(places.size());
    parallel_each(places.size(), kSheetGrain, [&](std::size_t s) {
      std::array<Neighbour, kSheetNeighbours> nearest;
      const std::size_t count = tree.find_nearest(places[s], nearest);
      for (const Neighbour& n : std::span(nearest).first(count)) {
        const double across = std::abs(glm::dot(normals[s], places[n.index] - places[s]));
        joined[s] |= n.squared_distance > 0 && n.squared_distance < 4 * radius_ * radius_ &&
                     across > kAcross * std::sqrt(n.squared_distance) &&
                     std::abs(glm::dot(normals[s], normals[n.index])) > kAcross;
      }
    });
    return static_cast<double>(std::ranges::count(joined, 1)) >
           kMostJoined * static_cast<double>(joined.size());
  }

  // False when no point asks for more samples.
  bool mesh_and_ask(const Callbacks& callbacks) {
    const double limit =
        (result_.meshing_count == 0 ? kObjectingTolerances : 1.0) * options_.tolerance;
    mesh_samples(share_of(callbacks, 0, kMeshedShare));
    // At first only those who objected before; when they are content, everybody.
    Indices beyond = points_beyond(points_, objecting_, result_.mesh, limit);
    const bool asks_all = beyond.empty();
    if (asks_all) beyond = ask_all(limit, callbacks);
    // Samples that the mesh did not take were looked at before.
    objecting_.clear();
    std::ranges::set_difference(beyond, samples_, std::back_inserter(objecting_));
    const std::size_t before = points_.size();
    critic_.remove_strays(objecting_, samples_);
    const bool removed = points_.size() != before;
    if (removed) name_vertices();
    Indices added;
    if (result_.meshing_count < kMostMeshings) added = choose_among(objecting_);
    if (added.empty()) {
      if (drop_components() || removed || !asks_all) (void)ask_all(limit, callbacks);
      return false;
    }
    result_.inserted_count += std::ssize(added);
    samples_ = merged(samples_, added);
    return true;
  }

  // Of points that object; denser than the samples that were not enough.
  Indices choose_among(const Indices& objecting) {
    const double finest = kFinestSpacings * critic_.spacing();
    radius_ = result_.meshing_count > kThinnedInsertions ? finest : kFinerRadius * radius_;
    Indices added = thin_points(points_, objecting, radius_, samples_);
    while (!objecting.empty() && added.empty() && radius_ > finest) {
      radius_ *= kFinerRadius;
      added = thin_points(points_, objecting, radius_, samples_);
    }
    return added;
  }

  void mesh_samples(const Callbacks& callbacks) {
    std::vector<glm::dvec3> places;
    places.reserve(samples_.size());
    for (const std::int32_t sample : samples_) places.push_back(points_[sample]);
    // Points of small components would only object to their being dropped.
    TriangleRepairOptions repair = options_.repair;
    repair.components.keep = ComponentRule::Keep::All;
    repair.callbacks = share_of(callbacks, 0.9, 1);
    RepairedTriangles repaired =
        repair_triangles(places, mesher_(places, share_of(callbacks, 0, 0.9)), repair);
    ++result_.meshing_count;
    result_.filled_loop_count = repaired.filled_loop_count;
    if (repaired.triangles.empty())
      throw Error(ErrorCode::UnusableMesh,
                  "no surface was found in " + counted(std::ssize(points_), "point"));
    take_used(std::move(repaired.triangles));
  }

  void turn_over() {
    if (options_.normals.empty()) return;
    std::vector<glm::vec3> normals;
    for (const std::int32_t point : result_.mesh.vertex_points)
      normals.push_back(options_.normals[points_.given(point)]);
    result_.turned_component_count =
        turn_by_normals(vertex_places(), normals, result_.mesh.triangles);
  }

  [[nodiscard]] std::vector<glm::dvec3> vertex_places() const {
    std::vector<glm::dvec3> places;
    places.reserve(result_.mesh.vertex_points.size());
    for (const std::int32_t point : result_.mesh.vertex_points) places.push_back(points_[point]);
    return places;
  }

  // Those that were not asked for; true if there were any.
  bool drop_components() {
    TriangleRepairOptions rule{.longest_filled_loop = 0, .components = options_.repair.components};
    RepairedTriangles repaired = repair_triangles(vertex_places(), result_.mesh.triangles, rule);
    result_.dropped_component_count = repaired.dropped_component_count;
    if (repaired.dropped_component_count == 0) return false;
    for (Triangle& t : repaired.triangles)
      for (std::int32_t& corner : t) corner = used_[corner];
    take_used(std::move(repaired.triangles));
    return true;
  }

  // Samples that the mesh does not use are no vertices.
  void take_used(std::vector<Triangle> triangles) {
    Indices vertex(samples_.size(), -1);
    for (const Triangle& t : triangles)
      for (const std::int32_t corner : t) vertex[corner] = 0;
    WitnessedMesh& mesh = result_.mesh;
    used_.clear();
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      if (vertex[s] < 0) continue;
      vertex[s] = static_cast<std::int32_t>(used_.size());
      used_.push_back(static_cast<std::int32_t>(s));
    }
    for (Triangle& t : triangles) {
      for (std::int32_t& corner : t) corner = vertex[corner];
      std::ranges::rotate(t, std::ranges::min_element(t));
    }
    std::ranges::sort(triangles);
    mesh.triangles = std::move(triangles);
    mesh.carriers.clear();
    name_vertices();
  }

  void name_vertices() {
    result_.mesh.vertex_points.clear();
    for (const std::int32_t sample : used_) result_.mesh.vertex_points.push_back(samples_[sample]);
  }

  Indices ask_all(double limit, const Callbacks& callbacks) {
    LoopProgress progress(callbacks, "witness", kMeshedShare, 1, std::ssize(points_));
    return find_carriers(points_, result_.mesh, options_.tolerance, limit, progress);
  }

  OrderedPoints& points_;
  PointCritic& critic_;
  const Mesher& mesher_;
  const CoarseOptions& options_;
  double radius_ = 0;
  Indices samples_, objecting_;
  Indices used_;  // samples that are vertices, as indices of samples_
  CoarseMesh result_;
};

}  // namespace

CoarseMesh mesh_coarse_first(OrderedPoints& points, PointCritic& critic, const Mesher& mesher,
                             const CoarseOptions& options) {
  const HostScope host(options.callbacks);
  return CoarseMesher(points, critic, mesher, options).run();
}

}  // namespace planish
