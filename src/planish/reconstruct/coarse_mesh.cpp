#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/reconstruct_steps.h"

namespace planish {
namespace {

constexpr std::size_t kPointsPerLook = 1 << 14;  // at the host

// Samples by cells that are as wide as the radius, in a hash table.
class SampleGrid {
 public:
  explicit SampleGrid(double radius) : radius_(radius), slots_(1 << 12) {}

  // Samples that are near are in the cell or beside it. Points of one cell often follow each
  // other: what is near is looked up for the first.
  [[nodiscard]] bool has_near(const glm::dvec3& place) {
    const Cell cell = cell_of(place);
    if (!knows_cell_ || !(cell == cell_)) {
      knows_cell_ = true;
      cell_ = cell;
      list_nearby();
    }
    for (const glm::dvec3& sample : nearby_) {
      const glm::dvec3 offset = sample - place;
      if (glm::dot(offset, offset) < radius_ * radius_) return true;
    }
    return false;
  }
  void add(const glm::dvec3& place) {
    const Cell cell = cell_of(place);
    Slot& slot = slot_of(cell);
    if (slot.head < 0) {
      slot.cell = cell;
      ++used_;
    }
    next_.push_back(slot.head);
    slot.head = static_cast<std::int32_t>(places_.size());
    places_.push_back(place);
    if (knows_cell_ && cell == cell_) nearby_.push_back(place);
    if (4 * used_ > 3 * slots_.size()) grow();
  }

 private:
  // Whole numbers as doubles: clouds far larger than the radius have no cells beyond reach.
  using Cell = glm::dvec3;
  struct Slot {
    Cell cell{0.0};
    std::int32_t head = -1;
  };

  [[nodiscard]] Cell cell_of(const glm::dvec3& place) const { return glm::floor(place / radius_); }
  [[nodiscard]] Slot& slot_of(const Cell& cell) {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(std::fmod(cell[axis], 0x1p62)));
      hash *= 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    std::size_t at = hash & (slots_.size() - 1);
    while (slots_[at].head >= 0 && !(slots_[at].cell == cell)) at = (at + 1) & (slots_.size() - 1);
    return slots_[at];
  }
  void grow() {
    std::vector<Slot> before(2 * slots_.size());
    std::swap(before, slots_);
    for (const Slot& slot : before)
      if (slot.head >= 0) slot_of(slot.cell) = slot;
  }
  void list_nearby() {
    nearby_.clear();
    for (int i = 0; i < 27; ++i) {
      const Cell beside = cell_ + glm::dvec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      for (std::int32_t s = slot_of(beside).head; s >= 0; s = next_[s])
        nearby_.push_back(places_[s]);
    }
  }

  double radius_;
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
  std::vector<glm::dvec3> places_;
  std::vector<std::int32_t> next_;  // sample of the same cell
  bool knows_cell_ = false;
  Cell cell_{0.0};
  std::vector<glm::dvec3> nearby_;  // samples in and beside cell_
};

}  // namespace

std::vector<std::int32_t> thin_points(const OrderedPoints& points,
                                      std::optional<std::span<const std::int32_t>> asked,
                                      double radius, std::span<const std::int32_t> samples) {
  SampleGrid grid(radius);
  for (const std::int32_t sample : samples) grid.add(points[sample]);
  std::vector<std::int32_t> chosen;
  const std::size_t count = asked ? asked->size() : points.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kPointsPerLook == 0) check_stop();
    const std::int32_t point = asked ? (*asked)[i] : static_cast<std::int32_t>(i);
    const glm::dvec3 place = points[point];
    if (grid.has_near(place)) continue;
    grid.add(place);
    chosen.push_back(point);
  }
  return chosen;
}

namespace {

// Searches that start from each other; so many that the first, from the tree's root, does not
// matter.
constexpr std::size_t kSearchesOfPiece = 2048;

using Indices = std::vector<std::int32_t>;

// Calls body(i, hit) for the points of a piece.
template <class PointAt, class Body>
void search_piece(const TriangleTree& tree, std::size_t begin, std::size_t end,
                  const PointAt& point_at, const Body& body) {
  std::int32_t start = -1;
  for (std::size_t i = begin; i < end; ++i) {
    const TriangleTree::Hit hit = tree.nearest(point_at(i), start);
    start = hit.place;
    body(i, hit);
  }
}

TriangleTree tree_of(const OrderedPoints& points, const WitnessedMesh& mesh) {
  std::vector<glm::dvec3> places;
  places.reserve(mesh.vertex_points.size());
  for (const std::int32_t point : mesh.vertex_points) places.push_back(points[point]);
  return {places, mesh.triangles};
}

void append(Indices& all, const Indices& part) { all.insert(all.end(), part.begin(), part.end()); }

}  // namespace

Indices find_carriers(const OrderedPoints& points, WitnessedMesh& mesh, double tolerance,
                      double limit, LoopProgress& progress) {
  mesh.carriers.assign(points.size(), -1);
  if (mesh.triangles.empty() || mesh.vertex_points.size() == points.size()) return {};
  const TriangleTree tree = tree_of(points, mesh);
  const auto beyond_in = [&](std::size_t begin, std::size_t end) {
    Indices beyond;
    auto vertex = std::ranges::lower_bound(mesh.vertex_points, static_cast<std::int32_t>(begin));
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[i]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          const auto point = static_cast<std::int32_t>(i);
          if (vertex != mesh.vertex_points.end() && *vertex == point) {
            ++vertex;
            return;
          }
          if (hit.squared_distance <= tolerance * tolerance) mesh.carriers[i] = hit.triangle;
          if (!(hit.squared_distance <= limit * limit)) beyond.push_back(point);
        });
    progress.add(static_cast<std::int64_t>(end - begin));
    return beyond;
  };
  return ordered_reduce(points.size(), kSearchesOfPiece, Indices(), beyond_in, append);
}

Indices points_beyond(const OrderedPoints& points, std::span<const std::int32_t> asked,
                      const WitnessedMesh& mesh, double limit) {
  if (asked.empty()) return {};
  const TriangleTree tree = tree_of(points, mesh);
  const auto beyond_in = [&](std::size_t begin, std::size_t end) {
    Indices beyond;
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[asked[i]]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          if (!(hit.squared_distance <= limit * limit)) beyond.push_back(asked[i]);
        });
    return beyond;
  };
  return ordered_reduce(asked.size(), kSearchesOfPiece, Indices(), beyond_in, append);
}

PointDistances measure_distances(const OrderedPoints& points, std::span<const Triangle> triangles) {
  if (points.size() == 0) return {};
  PLANISH_ASSERT(!triangles.empty());
  struct Sum {
    double largest = -1, squares = 0;
    std::int64_t farthest = -1;
  };
  const TriangleTree tree(points, triangles);
  const auto sum_of = [&](std::size_t begin, std::size_t end) {
    Sum sum;
    search_piece(
        tree, begin, end, [&](std::size_t i) { return points[i]; },
        [&](std::size_t i, const TriangleTree::Hit& hit) {
          sum.squares += hit.squared_distance;
          if (hit.squared_distance <= sum.largest) return;
          sum.largest = hit.squared_distance;
          sum.farthest = static_cast<std::int64_t>(i);
        });
    return sum;
  };
  const auto join = [](Sum& all, const Sum& part) {
    all.squares += part.squares;
    if (part.largest <= all.largest) return;
    all.largest = part.largest;
    all.farthest = part.farthest;
  };
  const Sum sum = ordered_reduce(points.size(), kSearchesOfPiece, Sum(), sum_of, join);
  return {.max = std::sqrt(sum.largest),
          .rms = std::sqrt(sum.squares / static_cast<double>(points.size())),
          .farthest = sum.farthest};
}

namespace {

// Based on: the witnesses of V. de Silva, G. Carlsson, "Topological Estimation Using Witness
// Complexes", 2004 (few points carry the shape, all judge it), and M. Garland, P. Heckbert, "Fast
// Polygonal Approximation of Terrains and Height Fields", 1995 (insertion where the error is).

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
