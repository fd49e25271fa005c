// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997
// (the order of collapses); L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh
// Decimation", 1998 (half-edge collapses under a bound on the distance of the removed points).
#include "planish/reconstruct/simplify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <queue>
#include <string>

#include "planish/core/error.h"
#include "planish/reconstruct/carried_points.h"
#include "planish/reconstruct/collapse_mesh.h"
#include "planish/reconstruct/edge_gradation.h"
#include "planish/reconstruct/quadric.h"
#include "planish/reconstruct/shape_limits.h"

namespace planish {
namespace {

// A new triangle may lean this far from the samples' normals: 60 degrees. Two that share a corner
// then never face each other.
constexpr double kLeastFacing = 0.5;
// A quadric's mean distance beyond this many tolerances cannot be mended by a nearer triangle
// often enough to be worth the look at the points.
constexpr double kHopelessTolerances = 4.0;
// Longest to shortest edge at a vertex. Even: a Poisson-disk sampling has 2, but no collapse leads
// from one such sampling to a coarser one past vertices of a greater ratio. Adaptive: folds of the
// interpolating surface sit where edges of very different length meet; without this limit there
// were twice as many, for 5 % fewer vertices.
constexpr double kEvenRatio = 2.6;
constexpr double kAdaptiveRatio = 6.5;
// Among collapses that cost next to nothing the shorter goes first: an edge of a hundred tolerances
// counts as an error of one.
constexpr double kLengthWeight = 1e-4;
constexpr std::int32_t kLeastInnerValence = 4;
// An edge is flipped when the smallest of six angles grows by this factor; less is not worth it.
constexpr double kFlipGain = 1.05;
constexpr int kMaxRounds = 4;
constexpr std::int64_t kStepsPerReport = 1 << 12;

double squared_length(const glm::dvec3& v) { return glm::dot(v, v); }

// An edge a b with the opposite corners c and d of its two triangles.
using Diamond = std::array<std::int32_t, 4>;

class Simplifier {
 public:
  Simplifier(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
             const SimplifyOptions& options)
      : positions_(positions),
        options_(options),
        mesh_(triangles, positions.size()),
        judge_(positions, triangles),
        gradation_(positions, mesh_,
                   options.spacing == Spacing::Even ? kEvenRatio : kAdaptiveRatio),
        carried_(positions, triangles.size(), options.tolerance),
        quadrics_(positions.size()),
        versions_(positions.size(), 0) {
    const double degrees =
        options.least_angle < 0 ? default_least_angle(options.spacing) : options.least_angle;
    largest_cosine_ = std::cos(degrees * std::numbers::pi / 180);
    max_valence_ =
        options.max_valence < 0 ? default_max_valence(options.spacing) : options.max_valence;
    for (const Triangle& t : triangles) add_plane(t);
    std::vector<std::int32_t> loose;
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v)
      if (!mesh_.is_used(v)) loose.push_back(v);
    result_.strayed_count = carried_.adopt(loose, triangles);
    result_.vertex_count = static_cast<std::int64_t>(positions.size() - loose.size());
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

  void add_plane(const Triangle& t);
  void collapse_all();
  void flip_all();
  void list_candidates(std::int32_t vertex);
  void push(std::int32_t vertex);
  bool try_collapse(std::int32_t vertex, std::size_t target);
  bool keeps_valences(std::int32_t vertex, std::size_t target) const;
  bool keeps_shape(std::int32_t vertex, std::size_t target);
  void apply(std::int32_t vertex, std::size_t target);
  bool try_flip(std::int32_t half_edge);
  bool flip_keeps_shape(const Diamond& diamond) const;
  void count_step();
  [[nodiscard]] bool is_done() const {
    return options_.target_vertices > 0 && result_.vertex_count <= options_.target_vertices;
  }

  std::span<const glm::dvec3> positions_;
  const SimplifyOptions& options_;
  CollapseMesh mesh_;
  ShapeJudge judge_;
  EdgeGradation gradation_;
  CarriedPoints carried_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> versions_;
  double largest_cosine_ = 1;
  std::int32_t max_valence_ = 0;
  std::priority_queue<Entry> queue_;
  SimplifiedMesh result_;
  std::int64_t initial_count_ = 0, steps_ = 0;
  // Used again from step to step.
  Fan fan_;
  std::vector<Candidate> candidates_;
  TriangleChange change_;
};

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
  const double hopeless = quadric.weight * std::pow(options_.tolerance * kHopelessTolerances, 2);
  const auto add = [&](std::size_t target) {
    const glm::dvec3& place = positions_[fan_.ring[target]];
    const double error = quadric.at(place);
    if (error > hopeless) return;
    const double length = squared_length(place - positions_[vertex]);
    const double cost = options_.spacing == Spacing::Even
                            ? length
                            : error + kLengthWeight * quadric.weight * length;
    candidates_.push_back({cost, target});
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

// Fills change_.
bool Simplifier::keeps_shape(std::int32_t vertex, std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  const std::size_t count = fan_.ring.size();
  change_.clear();
  change_.removed_vertex = vertex;
  TriangleQuality after;
  after.shortest_squared = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
    const std::int32_t a = fan_.ring[i], b = fan_.ring[(i + 1) % count];
    change_.old_slots.push_back(fan_.spokes[i] / 3);
    if (a == other || b == other) continue;
    after.take_worst(judge_.quality(other, a, b));
    change_.triangles.push_back({other, a, b});
    change_.slots.push_back(fan_.spokes[i] / 3);
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

bool Simplifier::try_collapse(std::int32_t vertex, std::size_t target) {
  return mesh_.can_collapse(vertex, fan_, target) && keeps_valences(vertex, target) &&
         keeps_shape(vertex, target) && gradation_.keeps_all(vertex, fan_, target) &&
         carried_.can_move(change_);
}

void Simplifier::apply(std::int32_t vertex, std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  mesh_.collapse(vertex, fan_, target);
  carried_.move(change_);
  quadrics_[other].add(quadrics_[vertex]);
  --result_.vertex_count;
  ++result_.collapse_count;
  // A suspect that another triangle carries now proves nothing.
  std::vector<std::int32_t> touched = fan_.ring;
  mesh_.for_each_neighbour(other, [&](std::int32_t n) { touched.push_back(n); });
  std::ranges::sort(touched);
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const std::int32_t v : touched) {
    carried_.forget_failure(v);
    push(v);
  }
}

bool Simplifier::flip_keeps_shape(const Diamond& diamond) const {
  const auto [a, b, c, d] = diamond;
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
  // a and b lose an edge, which makes no ratio worse.
  return gradation_.keeps(c, {.with = d}) && gradation_.keeps(d, {.with = c});
}

bool Simplifier::try_flip(std::int32_t half_edge) {
  if (!mesh_.can_flip(half_edge)) return false;
  const std::int32_t twin = mesh_.twin(half_edge);
  const Diamond diamond{mesh_.start(half_edge), mesh_.end(half_edge),
                        mesh_.end(next_half_edge(half_edge)), mesh_.end(next_half_edge(twin))};
  if (!flip_keeps_shape(diamond)) return false;
  const auto [a, b, c, d] = diamond;
  change_.clear();
  change_.old_slots = change_.slots = {half_edge / 3, twin / 3};
  change_.triangles = {{c, d, b}, {d, c, a}};
  if (!carried_.can_move(change_)) return false;
  mesh_.flip(half_edge);
  carried_.move(change_);
  for (const std::int32_t v : diamond) carried_.forget_failure(v);
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
