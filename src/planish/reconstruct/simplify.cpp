// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997
// (the order of collapses); L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh
// Decimation", 1998 (half-edge collapses under a bound on the distance of the removed points).
#include "planish/reconstruct/simplify.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <queue>
#include <string>

#include "planish/core/error.h"
#include "planish/reconstruct/collapse_mesh.h"
#include "planish/reconstruct/point_carrier.h"
#include "planish/reconstruct/quadric.h"
#include "planish/reconstruct/shape_limits.h"
#include "planish/reconstruct/triangle_tree.h"

namespace planish {
namespace {

// A new triangle may lean this far from the samples' normals: 60 degrees. Two that share a corner
// then never face each other.
constexpr double kLeastFacing = 0.5;
// A quadric's mean distance beyond this many tolerances cannot be mended by a nearer triangle
// often enough to be worth the look at the points.
constexpr double kHopelessTolerances = 2.0;
// Longest to shortest edge at a vertex, for even spacing. A Poisson-disk sampling has 2, but no
// collapse leads from one such sampling to a coarser one past vertices of a greater ratio.
constexpr double kEvenRatio = 2.6;
constexpr std::int32_t kLeastInnerValence = 4;
// An edge is flipped when the smallest of six angles grows by this factor; less is not worth it.
constexpr double kFlipGain = 1.05;
constexpr int kMaxRounds = 4;
constexpr std::int64_t kStepsPerReport = 1 << 12;

double squared_length(const glm::dvec3& v) { return glm::dot(v, v); }

class Simplifier {
 public:
  Simplifier(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
             const SimplifyOptions& options)
      : positions_(positions),
        options_(options),
        squared_tolerance_(options.tolerance * options.tolerance),
        mesh_(triangles, positions.size()),
        judge_(positions, triangles),
        carrier_(positions.size(), triangles.size()),
        quadrics_(positions.size()),
        versions_(positions.size(), 0),
        worst_points_(positions.size(), -1) {
    const double degrees =
        options.least_angle < 0 ? default_least_angle(options.spacing) : options.least_angle;
    largest_cosine_ = std::cos(degrees * std::numbers::pi / 180);
    max_valence_ =
        options.max_valence < 0 ? default_max_valence(options.spacing) : options.max_valence;
    carry_loose_points(triangles);
    for (const Triangle& t : triangles) add_plane(t);
    for (std::size_t v = 0; v < positions.size(); ++v)
      result_.vertex_count += mesh_.is_used(static_cast<std::int32_t>(v));
    initial_count_ = result_.vertex_count;
  }

  SimplifiedMesh run() {
    options_.callbacks.report("simplify", 0.0);
    for (int round = 0; round < kMaxRounds && !is_done(); ++round) {
      const std::int64_t before = result_.collapse_count;
      collapse_all();
      if (result_.collapse_count == before) break;
      flip_all();
    }
    for (std::size_t t = 0; t < mesh_.triangle_count(); ++t)
      if (mesh_.is_alive(static_cast<std::int32_t>(t)))
        result_.triangles.push_back(mesh_.triangle(static_cast<std::int32_t>(t)));
    options_.callbacks.report("simplify", 1.0);
    return std::move(result_);
  }

 private:
  // The next best target of a vertex; stale when the vertex has a newer version.
  struct Entry {
    double cost;
    std::int32_t vertex;
    std::uint32_t version;
    std::uint32_t rank;
    [[nodiscard]] bool operator<(const Entry& other) const {
      return cost > other.cost || (cost == other.cost && vertex > other.vertex);
    }
  };
  struct Candidate {
    double cost;
    std::size_t target;  // of the fan's ring
  };

  void carry_loose_points(std::span<const Triangle> triangles);
  void add_plane(const Triangle& t);
  void collapse_all();
  void flip_all();
  void list_candidates(std::int32_t vertex);
  void push(std::int32_t vertex);
  bool try_collapse(std::int32_t vertex, std::size_t target);
  bool keeps_valences(std::int32_t vertex, std::size_t target) const;
  bool keeps_shape(std::size_t target);
  double edge_ratio(std::int32_t vertex, std::int32_t without, std::int32_t with) const;
  bool keeps_ratio(std::int32_t vertex, std::int32_t without, std::int32_t with) const;
  bool keeps_gradation(std::int32_t vertex, std::size_t target) const;
  bool keeps_points(std::int32_t vertex);
  void apply(std::int32_t vertex, std::size_t target);
  bool try_flip(std::int32_t half_edge);
  void count_step();
  [[nodiscard]] bool is_done() const {
    return options_.target_vertices > 0 && result_.vertex_count <= options_.target_vertices;
  }

  std::span<const glm::dvec3> positions_;
  const SimplifyOptions& options_;
  double squared_tolerance_;
  CollapseMesh mesh_;
  ShapeJudge judge_;
  PointCarrier carrier_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> versions_;
  std::vector<std::int32_t> worst_points_;  // by vertex: the point that failed there last
  double largest_cosine_ = 1;
  std::int32_t max_valence_ = 0;
  std::priority_queue<Entry> queue_;
  SimplifiedMesh result_;
  std::int64_t initial_count_ = 0, steps_ = 0;
  // Used again from step to step.
  Fan fan_;
  std::vector<Candidate> candidates_;
  std::vector<Triangle> new_triangles_;
  std::vector<std::int32_t> new_slots_;  // triangle indices that the new ones take
  std::vector<TriangleShape> shapes_;
  std::vector<std::int32_t> points_, nearest_;
};

void Simplifier::carry_loose_points(std::span<const Triangle> triangles) {
  std::vector<std::int32_t> loose;
  for (std::size_t v = 0; v < positions_.size(); ++v)
    if (!mesh_.is_used(static_cast<std::int32_t>(v))) loose.push_back(static_cast<std::int32_t>(v));
  if (loose.empty() || triangles.empty()) return;
  const TriangleTree tree(positions_, triangles);
  for (const std::int32_t point : loose) {
    const TriangleTree::Hit hit = tree.nearest(positions_[point]);
    if (hit.squared_distance <= squared_tolerance_) {
      carrier_.put(point, hit.triangle);
    } else {
      ++result_.strayed_count;
    }
  }
}

void Simplifier::add_plane(const Triangle& t) {
  const glm::dvec3 cross =
      glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
  const double length = glm::length(cross);
  if (!(length > 0)) return;
  for (const std::int32_t corner : t)
    quadrics_[corner].add_plane(cross / length, positions_[t[0]], length);
}

void Simplifier::count_step() {
  if (++steps_ % kStepsPerReport != 0) return;
  options_.callbacks.check_cancelled();
  options_.callbacks.report("simplify",
                            1 - static_cast<double>(result_.vertex_count) /
                                    static_cast<double>(std::max<std::int64_t>(initial_count_, 1)));
}

// Fills fan_ and candidates_, the cheapest first.
void Simplifier::list_candidates(std::int32_t vertex) {
  mesh_.get_fan(vertex, fan_);
  candidates_.clear();
  const Quadric& quadric = quadrics_[vertex];
  const double hopeless =
      quadric.weight * squared_tolerance_ * kHopelessTolerances * kHopelessTolerances;
  const auto add = [&](std::size_t target) {
    const glm::dvec3& place = positions_[fan_.ring[target]];
    const double error = quadric.at(place);
    if (error > hopeless) return;
    const double length = squared_length(place - positions_[vertex]);
    candidates_.push_back({options_.spacing == Spacing::Even ? length : error, target});
  };
  if (fan_.closed) {
    for (std::size_t target = 0; target < fan_.ring.size(); ++target) add(target);
  } else {
    add(0);
    add(fan_.ring.size() - 1);
  }
  std::ranges::sort(candidates_, [](const Candidate& a, const Candidate& b) {
    return a.cost < b.cost || (a.cost == b.cost && a.target < b.target);
  });
}

void Simplifier::push(std::int32_t vertex) {
  list_candidates(vertex);
  const std::uint32_t version = ++versions_[vertex];
  if (!candidates_.empty()) queue_.push({candidates_.front().cost, vertex, version, 0});
}

void Simplifier::collapse_all() {
  queue_ = {};
  for (std::size_t v = 0; v < positions_.size(); ++v)
    if (mesh_.is_used(static_cast<std::int32_t>(v))) push(static_cast<std::int32_t>(v));
  while (!queue_.empty() && !is_done()) {
    const Entry entry = queue_.top();
    queue_.pop();
    if (entry.version != versions_[entry.vertex] || !mesh_.is_used(entry.vertex)) continue;
    count_step();
    list_candidates(entry.vertex);
    for (std::uint32_t rank = entry.rank; rank < candidates_.size(); ++rank) {
      // A dearer target waits for its turn.
      if (!queue_.empty() && candidates_[rank].cost > queue_.top().cost) {
        queue_.push({candidates_[rank].cost, entry.vertex, entry.version, rank});
        break;
      }
      if (!try_collapse(entry.vertex, candidates_[rank].target)) continue;
      apply(entry.vertex, candidates_[rank].target);
      break;
    }
  }
}

bool Simplifier::keeps_valences(std::int32_t vertex, std::size_t target) const {
  const std::size_t count = fan_.ring.size();
  const std::int32_t lost = fan_.closed ? 4 : 3;
  const std::int32_t valence = mesh_.valence(vertex) + mesh_.valence(fan_.ring[target]) - lost;
  if (valence > max_valence_) return false;
  const auto stays = [&](std::size_t at) {
    const std::int32_t v = fan_.ring[at % count];
    return mesh_.is_boundary(v) || mesh_.valence(v) > kLeastInnerValence;
  };
  if (!mesh_.is_boundary(fan_.ring[target]) && valence < kLeastInnerValence) return false;
  if (fan_.closed) return stays(target + 1) && stays(target + count - 1);
  return stays(target == 0 ? 1 : count - 2);
}

// Fills new_triangles_ and new_slots_.
bool Simplifier::keeps_shape(std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  const std::size_t count = fan_.ring.size();
  new_triangles_.clear();
  new_slots_.clear();
  TriangleQuality after;
  after.shortest_squared = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
    const std::int32_t a = fan_.ring[i], b = fan_.ring[(i + 1) % count];
    if (a == other || b == other) continue;
    after.take_worst(judge_.quality(other, a, b));
    new_triangles_.push_back({other, a, b});
    new_slots_.push_back(fan_.spokes[i] / 3);
  }
  if (after.largest_cosine <= largest_cosine_ && after.facing >= kLeastFacing) return true;
  // Worse than asked for is good enough where it was no better before.
  TriangleQuality before;
  for (const std::int32_t spoke : fan_.spokes) {
    const Triangle t = mesh_.triangle(spoke / 3);
    before.take_worst(judge_.quality(t[0], t[1], t[2]));
  }
  return after.largest_cosine <= std::max(largest_cosine_, before.largest_cosine) &&
         after.facing >= std::min(kLeastFacing, before.facing);
}

// Squared ratio of the longest to the shortest edge at a vertex, with an edge less (to `without`)
// and an edge more (to `with`); -1 for none.
double Simplifier::edge_ratio(std::int32_t vertex, std::int32_t without, std::int32_t with) const {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  const auto add = [&](std::int32_t other) {
    const double squared = squared_length(positions_[vertex] - positions_[other]);
    shortest = std::min(shortest, squared);
    longest = std::max(longest, squared);
  };
  mesh_.for_each_neighbour(vertex, [&](std::int32_t other) {
    if (other != without) add(other);
  });
  if (with >= 0) add(with);
  return longest / shortest;
}

// Whether a vertex stays within the ratio, or becomes no worse.
bool Simplifier::keeps_ratio(std::int32_t vertex, std::int32_t without, std::int32_t with) const {
  const double after = edge_ratio(vertex, without, with);
  return after <= kEvenRatio * kEvenRatio || after <= edge_ratio(vertex, -1, -1);
}

bool Simplifier::keeps_gradation(std::int32_t vertex, std::size_t target) const {
  const std::int32_t other = fan_.ring[target];
  double longest = 0, shortest = std::numeric_limits<double>::infinity();
  const auto add = [&](std::int32_t n) {
    const double squared = squared_length(positions_[other] - positions_[n]);
    shortest = std::min(shortest, squared);
    longest = std::max(longest, squared);
  };
  for (const std::int32_t rim : fan_.ring) {
    if (rim == other) continue;
    if (!keeps_ratio(rim, vertex, other)) return false;
    add(rim);
  }
  mesh_.for_each_neighbour(other, [&](std::int32_t n) {
    if (n != vertex) add(n);
  });
  return longest <= std::max(kEvenRatio * kEvenRatio, edge_ratio(other, -1, -1)) * shortest;
}

// Whether all points that the fan carries, and its vertex (if not -1), stay near new_triangles_.
bool Simplifier::keeps_points(std::int32_t vertex) {
  shapes_.clear();
  for (const Triangle& t : new_triangles_)
    shapes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  points_.clear();
  if (vertex >= 0) {
    // The point that stood in the way last time is likely to do so again.
    const std::int32_t suspect = worst_points_[vertex];
    if (suspect >= 0) {
      double best = std::numeric_limits<double>::infinity();
      for (const TriangleShape& shape : shapes_)
        best = std::min(best, shape.squared_distance(positions_[suspect]));
      if (!(best <= squared_tolerance_)) return false;
    }
    points_.push_back(vertex);
    for (const std::int32_t spoke : fan_.spokes) carrier_.list(spoke / 3, points_);
  } else {
    for (const std::int32_t slot : new_slots_) carrier_.list(slot, points_);
  }
  const std::int64_t failed =
      find_nearest_shapes(positions_, points_, shapes_, squared_tolerance_, nearest_);
  if (failed >= 0 && vertex >= 0) worst_points_[vertex] = points_[failed];
  return failed < 0;
}

bool Simplifier::try_collapse(std::int32_t vertex, std::size_t target) {
  return mesh_.can_collapse(vertex, fan_, target) && keeps_valences(vertex, target) &&
         keeps_shape(target) &&
         (options_.spacing != Spacing::Even || keeps_gradation(vertex, target)) &&
         keeps_points(vertex);
}

void Simplifier::apply(std::int32_t vertex, std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  mesh_.collapse(vertex, fan_, target);
  for (const std::int32_t spoke : fan_.spokes) carrier_.clear(spoke / 3);
  for (std::size_t i = 0; i < points_.size(); ++i)
    carrier_.put(points_[i], new_slots_[nearest_[i]]);
  quadrics_[other].add(quadrics_[vertex]);
  --result_.vertex_count;
  ++result_.collapse_count;
  // A suspect that another triangle carries now proves nothing.
  std::vector<std::int32_t> touched = fan_.ring;
  mesh_.for_each_neighbour(other, [&](std::int32_t n) { touched.push_back(n); });
  std::ranges::sort(touched);
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const std::int32_t v : touched) {
    worst_points_[v] = -1;
    push(v);
  }
}

bool Simplifier::try_flip(std::int32_t half_edge) {
  if (!mesh_.can_flip(half_edge)) return false;
  const std::int32_t twin = mesh_.twin(half_edge);
  const std::int32_t a = mesh_.start(half_edge), b = mesh_.end(half_edge);
  const std::int32_t c = mesh_.end(next_half_edge(half_edge));
  const std::int32_t d = mesh_.end(next_half_edge(twin));
  const auto at_least = [&](std::int32_t v) {
    return mesh_.is_boundary(v) || mesh_.valence(v) > kLeastInnerValence;
  };
  if (!at_least(a) || !at_least(b) || mesh_.valence(c) >= max_valence_ ||
      mesh_.valence(d) >= max_valence_)
    return false;
  TriangleQuality before = judge_.quality(a, b, c);
  before.take_worst(judge_.quality(b, a, d));
  TriangleQuality after = judge_.quality(c, d, b);
  after.take_worst(judge_.quality(d, c, a));
  const auto angle = [](const TriangleQuality& q) {
    return std::acos(std::min(q.largest_cosine, 1.0));
  };
  if (angle(after) < kFlipGain * angle(before) ||
      after.facing < std::min(kLeastFacing, before.facing))
    return false;
  if (options_.spacing == Spacing::Even && !(keeps_ratio(a, b, -1) && keeps_ratio(b, a, -1) &&
                                             keeps_ratio(c, -1, d) && keeps_ratio(d, -1, c)))
    return false;
  new_triangles_ = {{c, d, b}, {d, c, a}};
  new_slots_ = {half_edge / 3, twin / 3};
  if (!keeps_points(-1)) return false;
  mesh_.flip(half_edge);
  for (const std::int32_t slot : new_slots_) carrier_.clear(slot);
  for (std::size_t i = 0; i < points_.size(); ++i)
    carrier_.put(points_[i], new_slots_[nearest_[i]]);
  for (const std::int32_t v : {a, b, c, d}) worst_points_[v] = -1;
  ++result_.flip_count;
  return true;
}

void Simplifier::flip_all() {
  constexpr int kSweeps = 5;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const std::int64_t before = result_.flip_count;
    for (std::size_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (!mesh_.is_alive(static_cast<std::int32_t>(t))) continue;
      count_step();
      for (int i = 0; i < 3; ++i) try_flip(static_cast<std::int32_t>(3 * t) + i);
    }
    if (result_.flip_count == before) break;
  }
}

void check_options(const SimplifyOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, what);
  };
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    refuse("the tolerance of the mesh must be a positive length");
  if (options.least_angle > 45)
    refuse("min-angle: " + std::to_string(options.least_angle) + " is not from 0 to 45 degrees");
  if (options.max_valence >= 0 && options.max_valence < 6)
    refuse("max-valence: " + std::to_string(options.max_valence) + " is below 6");
  if (options.target_vertices < 0) refuse("target-vertices: a count from 0 is needed");
}

}  // namespace

double default_least_angle(Spacing spacing) { return spacing == Spacing::Even ? 22.0 : 3.0; }

std::int32_t default_max_valence(Spacing spacing) { return spacing == Spacing::Even ? 8 : 10; }

SimplifiedMesh simplify(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                        const SimplifyOptions& options) {
  check_options(options);
  return Simplifier(positions, triangles, options).run();
}

}  // namespace planish
