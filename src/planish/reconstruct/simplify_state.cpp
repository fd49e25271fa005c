#include "planish/reconstruct/simplify_state.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"

namespace planish {

// Based on: H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, "Mesh Optimization", 1993
// (when a collapse keeps the topology).

CollapseMesh::CollapseMesh(std::span<const Triangle> triangles, std::size_t vertex_count)
    : twins_(twins_of(triangles, vertex_count)),
      outgoing_(vertex_count, -1),
      valences_(vertex_count, 0),
      marks_(vertex_count, 0) {
  corners_.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    corners_.insert(corners_.end(), triangle.begin(), triangle.end());
  for (std::size_t h = 0; h < corners_.size(); ++h) {
    const std::int32_t vertex = corners_[h];
    if (outgoing_[vertex] < 0 || twins_[h] < 0) outgoing_[vertex] = static_cast<std::int32_t>(h);
    ++valences_[vertex];
    // An inner edge is counted by the half-edge out of the vertex, a boundary edge also here.
    if (twins_[h] < 0) ++valences_[end(static_cast<std::int32_t>(h))];
  }
}

void CollapseMesh::get_fan(std::int32_t vertex, Fan& fan) const {
  fan.spokes.clear();
  fan.ring.clear();
  const std::int32_t first = outgoing_[vertex];
  fan.closed = twins_[first] >= 0;
  std::int32_t h = first;
  do {
    fan.spokes.push_back(h);
    fan.ring.push_back(end(h));
    const std::int32_t before = previous_half_edge(h);
    h = twins_[before];
    if (h < 0) fan.ring.push_back(start(before));
  } while (h >= 0 && h != first);
}

bool CollapseMesh::are_neighbours(std::int32_t a, std::int32_t b) const {
  bool found = false;
  for_each_neighbour(a, [&](std::int32_t neighbour) { found |= neighbour == b; });
  return found;
}

bool CollapseMesh::can_collapse(std::int32_t vertex, const Fan& fan, std::size_t target) {
  const std::int32_t other = fan.ring[target];
  // A boundary vertex may only run along the boundary, or the loops would change.
  if (!fan.closed && target != 0 && target + 1 != fan.ring.size()) return false;
  if (fan.closed && fan.ring.size() < 3) return false;
  if (!fan.closed && fan.spokes.size() < 2) return false;
  ++mark_;
  for (const std::int32_t neighbour : fan.ring) marks_[neighbour] = mark_;
  std::int32_t shared = 0;
  for_each_neighbour(other, [&](std::int32_t n) { shared += marks_[n] == mark_; });
  if (shared != (fan.closed ? 2 : 1)) return false;
  // Three neighbours: the triangle that is left must not exist on the other side.
  const std::size_t count = fan.ring.size();
  const auto keeps_valence = [&](std::size_t at) {
    const std::int32_t v = fan.ring[at % count];
    return valences_[v] - 1 >= (is_boundary(v) ? 2 : 3);
  };
  if (fan.closed)
    return keeps_valence(target + 1) && keeps_valence(target + count - 1) &&
           valences_[vertex] + valences_[other] - 4 >= (is_boundary(other) ? 2 : 3);
  return keeps_valence(target == 0 ? 1 : count - 2) &&
         valences_[vertex] + valences_[other] - 3 >= 2;
}

void CollapseMesh::glue(std::int32_t a, std::int32_t b) {
  if (a >= 0) twins_[a] = b;
  if (b >= 0) twins_[b] = a;
}

// The first half-edge of an open fan is the one without a twin.
void CollapseMesh::set_outgoing(std::int32_t vertex, std::int32_t half_edge) {
  std::int32_t h = half_edge;
  while (twins_[h] >= 0) {
    h = next_half_edge(twins_[h]);
    if (h == half_edge) break;
  }
  outgoing_[vertex] = h;
}

void CollapseMesh::collapse(std::int32_t vertex, const Fan& fan, std::size_t target) {
  const std::int32_t other = fan.ring[target];
  const std::size_t count = fan.ring.size();
  // Spoke i is the triangle (vertex, ring[i], ring[i + 1]); those with the target go.
  std::vector<std::int32_t> dropped;
  if (target < fan.spokes.size()) dropped.push_back(fan.spokes[target]);
  if (target > 0 || fan.closed) dropped.push_back(fan.spokes[(target + count - 1) % count]);
  std::int32_t kept = -1;  // a half-edge out of the target that stays
  std::vector<std::pair<std::int32_t, std::int32_t>> outgoing;
  for (const std::int32_t spoke : fan.spokes) corners_[spoke] = other;
  for (const std::int32_t spoke : dropped) {
    const std::int32_t across = next_half_edge(spoke), back = previous_half_edge(spoke);
    // The side with the target and the side with the vertex become one edge.
    const bool target_first = fan.ring[target] == corners_[across];
    const std::int32_t third = target_first ? corners_[back] : corners_[across];
    const std::int32_t target_side = twins_[across];
    const std::int32_t vertex_side = target_first ? twins_[back] : twins_[spoke];
    if (target_side >= 0) twins_[target_side] = vertex_side;
    if (vertex_side >= 0) twins_[vertex_side] = target_side;
    for (const std::int32_t side : {target_side, vertex_side}) {
      if (side < 0) continue;
      const bool from_third = corners_[side] == third;
      outgoing.emplace_back(third, from_third ? side : next_half_edge(side));
      kept = from_third ? next_half_edge(side) : side;
    }
    --valences_[third];
  }
  for (const std::int32_t spoke : dropped)
    for (int i = 0; i < 3; ++i) corners_[spoke - spoke % 3 + i] = -1;
  for (const auto& [third, half_edge] : outgoing) set_outgoing(third, half_edge);
  set_outgoing(other, kept);
  valences_[other] += valences_[vertex] - 2 - static_cast<std::int32_t>(dropped.size());
  outgoing_[vertex] = -1;
  valences_[vertex] = 0;
}

bool CollapseMesh::can_flip(std::int32_t half_edge) {
  const std::int32_t other = twins_[half_edge];
  if (other < 0) return false;
  const std::int32_t c = end(next_half_edge(half_edge)), d = end(next_half_edge(other));
  const auto loses_one = [&](std::int32_t v) { return valences_[v] > (is_boundary(v) ? 2 : 3); };
  return c != d && loses_one(start(half_edge)) && loses_one(end(half_edge)) &&
         !are_neighbours(c, d);
}

void CollapseMesh::flip(std::int32_t half_edge) {
  const std::int32_t h = half_edge, g = twins_[h];
  const std::int32_t h1 = next_half_edge(h), h2 = previous_half_edge(h);
  const std::int32_t g1 = next_half_edge(g), g2 = previous_half_edge(g);
  const std::int32_t a = corners_[h], b = corners_[g], c = corners_[h2], d = corners_[g2];
  const std::int32_t bc = twins_[h1], ca = twins_[h2], ad = twins_[g1], db = twins_[g2];
  corners_[h] = c, corners_[h1] = d, corners_[h2] = b;
  corners_[g] = d, corners_[g1] = c, corners_[g2] = a;
  glue(h, g);
  glue(h1, db);
  glue(h2, bc);
  glue(g1, ca);
  glue(g2, ad);
  // glue() leaves a stale twin where the far side is the boundary.
  twins_[h1] = db, twins_[h2] = bc, twins_[g1] = ca, twins_[g2] = ad;
  --valences_[a], --valences_[b], ++valences_[c], ++valences_[d];
  set_outgoing(a, g2);
  set_outgoing(b, h2);
  set_outgoing(c, h);
  set_outgoing(d, g);
}

namespace {

// Squared lengths of the edges at a vertex, the shortest and the longest.
struct EdgeRange {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;

  void add(const glm::dvec3& edge) {
    const double squared = glm::dot(edge, edge);
    shortest = std::min(shortest, squared);
    longest = std::max(longest, squared);
  }
};

}  // namespace

double EdgeGradation::squared_ratio(std::int32_t vertex, const EdgeChange& change) const {
  EdgeRange range;
  mesh_.for_each_neighbour(vertex, [&](std::int32_t other) {
    if (other != change.without) range.add(positions_[vertex] - positions_[other]);
  });
  if (change.with != nullptr) range.add(positions_[vertex] - *change.with);
  return range.longest / range.shortest;
}

bool EdgeGradation::keeps(std::int32_t vertex, const EdgeChange& change) const {
  const double after = squared_ratio(vertex, change);
  return after <= largest_squared_ratio_ || after <= squared_ratio(vertex, {});
}

bool EdgeGradation::keeps_all(std::int32_t vertex, const Fan& fan, std::size_t target) const {
  const std::int32_t other = fan.ring[target];
  EdgeRange range;
  double worst = 0;
  const std::size_t count = fan.ring.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t rim = fan.ring[i];
    if (rim == other) continue;
    // Those beside the target only lose an edge, which makes no ratio worse.
    const std::size_t apart = i < target ? target - i : i - target;
    const bool is_beside = apart == 1 || (fan.closed && apart + 1 == count);
    if (!is_beside)
      worst = std::max(worst, squared_ratio(rim, {.without = vertex, .with = &positions_[other]}));
    range.add(positions_[other] - positions_[rim]);
  }
  mesh_.for_each_neighbour(other, [&](std::int32_t n) {
    if (n != vertex) range.add(positions_[other] - positions_[n]);
  });
  const auto fits = [&](double limit) {
    return worst <= limit && range.longest <= limit * range.shortest;
  };
  if (fits(largest_squared_ratio_)) return true;
  // Where a vertex is beyond the limit all around it only need to become no worse than the worst:
  // points in lines far apart would keep every one of them else.
  const auto was_as_bad = [&](std::int32_t v) { return fits(squared_ratio(v, {})); };
  return was_as_bad(vertex) || std::ranges::any_of(fan.ring, was_as_bad);
}

bool EdgeGradation::keeps_moved(std::int32_t vertex, const glm::dvec3& place,
                                const Fan& fan) const {
  EdgeRange range;
  for (const std::int32_t rim : fan.ring) {
    if (!keeps(rim, {.without = vertex, .with = &place})) return false;
    range.add(place - positions_[rim]);
  }
  return range.longest <=
         std::max(largest_squared_ratio_, squared_ratio(vertex, {})) * range.shortest;
}

void TriangleQuality::take_worst(const TriangleQuality& other) {
  largest_cosine = std::max(largest_cosine, other.largest_cosine);
  facing = std::min(facing, other.facing);
  longest_squared = std::max(longest_squared, other.longest_squared);
  shortest_squared = std::min(shortest_squared, other.shortest_squared);
}

ShapeJudge::ShapeJudge(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles)
    : positions_(positions), normals_(positions.size(), glm::vec3(0.0f)) {
  std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0.0));
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 b = positions[t[(i + 1) % 3]] - positions[t[i]];
      const glm::dvec3 c = positions[t[(i + 2) % 3]] - positions[t[i]];
      const glm::dvec3 cross = glm::cross(b, c);
      const double length = glm::length(cross);
      if (length > 0) sums[t[i]] += portable::atan2(length, glm::dot(b, c)) / length * cross;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const double length = glm::length(sums[v]);
    if (length > 0) normals_[v] = glm::vec3(sums[v] / length);
  }
}

TriangleQuality ShapeJudge::quality(const JudgedCorner& a, const JudgedCorner& b,
                                    const JudgedCorner& c) const {
  const glm::dvec3 ab = b.place - a.place, bc = c.place - b.place, ca = a.place - c.place;
  const double ab2 = glm::dot(ab, ab), bc2 = glm::dot(bc, bc), ca2 = glm::dot(ca, ca);
  const glm::dvec3 cross = glm::cross(ab, -ca);
  const double doubled_area = glm::length(cross);
  TriangleQuality quality{.largest_cosine = 1, .facing = -1};
  quality.longest_squared = std::max({ab2, bc2, ca2});
  quality.shortest_squared = std::min({ab2, bc2, ca2});
  if (!(doubled_area > 0)) return quality;
  // The smallest angle lies opposite the shortest edge, between the two others.
  const double dot = 0.5 * (ab2 + bc2 + ca2 - 2 * quality.shortest_squared);
  quality.largest_cosine = dot / std::sqrt(dot * dot + doubled_area * doubled_area);
  quality.facing = 1;
  for (const glm::vec3& corner_normal : {a.normal, b.normal, c.normal}) {
    const glm::dvec3 normal(corner_normal);
    if (normal != glm::dvec3(0.0))
      quality.facing = std::min(quality.facing, glm::dot(cross, normal) / doubled_area);
  }
  return quality;
}

double ShapeJudge::deviation(std::int32_t a, std::int32_t b, std::int32_t c) const {
  const glm::dvec3 cross = glm::cross(positions_[b] - positions_[a], positions_[c] - positions_[a]);
  const glm::vec3 sum = normals_[a] + normals_[b] + normals_[c];
  return glm::length(cross) - glm::dot(cross, glm::dvec3(sum)) / 3;
}

namespace {

// Takes the points and their nearest shapes.
void look(const OrderedPoints& positions, std::span<const std::int32_t> points,
          std::span<const TriangleShape> shapes, PointBatch& batch) {
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 place = positions[points[i]];
    batch.x[i] = place.x;
    batch.y[i] = place.y;
    batch.z[i] = place.z;
  }
  std::fill_n(batch.squared_distance, count, std::numeric_limits<double>::infinity());
  for (std::size_t s = 0; s < shapes.size(); ++s)
    take_nearer(shapes[s], static_cast<std::int32_t>(s), static_cast<int>(count), batch);
}

}  // namespace

std::int64_t find_nearest_shapes(const OrderedPoints& positions,
                                 std::span<const std::int32_t> points,
                                 std::span<const TriangleShape> shapes, double squared_tolerance,
                                 std::vector<std::int32_t>& nearest) {
  nearest.resize(points.size());
  PointBatch batch;
  for (std::size_t begin = 0; begin < points.size(); begin += kPointLanes) {
    const auto some =
        points.subspan(begin, std::min<std::size_t>(points.size() - begin, kPointLanes));
    look(positions, some, shapes, batch);
    for (std::size_t i = 0; i < some.size(); ++i)
      if (!(batch.squared_distance[i] <= squared_tolerance))
        return static_cast<std::int64_t>(begin + i);
    std::copy_n(batch.nearest, some.size(), nearest.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  return -1;
}

// Based on: L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh Decimation", 1998
// (a bound on the distance of the removed points).

CarriedPoints::CarriedPoints(const OrderedPoints& points, std::span<const glm::dvec3> positions,
                             std::span<const std::int32_t> vertex_points,
                             std::span<const std::int32_t> carriers, std::size_t triangle_count,
                             double tolerance)
    : points_(points),
      positions_(positions),
      vertex_points_(vertex_points),
      squared_tolerance_(tolerance * tolerance),
      carrier_(points.size(), triangle_count),
      failures_(positions.size(), -1) {
  for (std::size_t point = 0; point < carriers.size(); ++point)
    if (carriers[point] >= 0) carrier_.put(static_cast<std::int32_t>(point), carriers[point]);
}

bool CarriedPoints::can_move(const TriangleChange& change) {
  shapes_.clear();
  for (const Triangle& t : change.triangles)
    shapes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  moved_.clear();
  const std::int32_t vertex = change.removed_vertex;
  if (vertex >= 0) {
    // The point that stood in the way last time is likely to do so again.
    if (const std::int32_t suspect = failures_[vertex]; suspect >= 0) {
      const glm::dvec3 place = points_[suspect];
      double best = std::numeric_limits<double>::infinity();
      for (const TriangleShape& shape : shapes_)
        best = std::min(best, shape.squared_distance(place));
      if (!(best <= squared_tolerance_)) return false;
    }
    moved_.push_back(vertex_points_[vertex]);
  }
  for (const std::int32_t slot : change.old_slots) carrier_.list(slot, moved_);
  if (change.added_point >= 0) std::erase(moved_, change.added_point);
  const std::int64_t failed =
      find_nearest_shapes(points_, moved_, shapes_, squared_tolerance_, nearest_);
  if (failed >= 0 && vertex >= 0) failures_[vertex] = moved_[failed];
  return failed < 0;
}

void CarriedPoints::move(const TriangleChange& change) {
  for (const std::int32_t slot : change.old_slots) carrier_.clear(slot);
  for (std::size_t i = 0; i < moved_.size(); ++i)
    carrier_.put(moved_[i], change.slots[nearest_[i]]);
}

namespace {

// Longest to shortest edge at a vertex. Even: a Poisson-disk sampling has 2, but no collapse leads
// from one such sampling to a coarser one past vertices of a greater ratio. Adaptive: folds of the
// interpolating surface sit where edges of very different length meet.
constexpr double kEvenRatio = 2.6;
constexpr double kAdaptiveRatio = 5.2;
constexpr std::int64_t kStepsPerReport = 1 << 12, kStepsPerLook = 1 << 4;

std::vector<glm::dvec3> places_of(const OrderedPoints& points,
                                  std::span<const std::int32_t> chosen) {
  std::vector<glm::dvec3> places;
  places.reserve(chosen.size());
  for (const std::int32_t point : chosen) places.push_back(points[point]);
  return places;
}

}  // namespace

SimplifyState::SimplifyState(const OrderedPoints& given_points, WitnessedMesh witnessed,
                             const SimplifyOptions& given_options)
    : points(given_points),
      options(given_options),
      vertex_points(std::move(witnessed.vertex_points)),
      positions(places_of(points, vertex_points)),
      mesh(witnessed.triangles, positions.size()),
      judge(positions, witnessed.triangles),
      gradation(positions, mesh, options.spacing == Spacing::Even ? kEvenRatio : kAdaptiveRatio),
      point_normals(normals_of_points(witnessed)),
      carried(points, positions, vertex_points, witnessed.carriers, witnessed.triangles.size(),
              options.tolerance),
      quadrics(positions.size()),
      due(positions.size(), 0) {
  const double degrees =
      options.least_angle < 0 ? default_least_angle(options.spacing) : options.least_angle;
  largest_cosine = portable::cos(degrees * std::numbers::pi / 180);
  max_valence =
      options.max_valence < 0 ? default_max_valence(options.spacing) : options.max_valence;
  for (const Triangle& t : witnessed.triangles) add_plane(t);
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v) touch(v);
  result.vertex_count = std::ssize(positions);
}

std::vector<PackedNormal> SimplifyState::normals_of_points(const WitnessedMesh& witnessed) const {
  std::vector<PackedNormal> normals(points.size());
  parallel_each(points.size(), [&](std::size_t point) {
    if (witnessed.carriers[point] < 0) return;
    const Triangle& t = witnessed.triangles[witnessed.carriers[point]];
    const glm::dvec3 share =
        TriangleShape(positions[t[0]], positions[t[1]], positions[t[2]]).shares(points[point]);
    normals[point] = PackedNormal(share[0] * judge.normal(t[0]) + share[1] * judge.normal(t[1]) +
                                  share[2] * judge.normal(t[2]));
  });
  for (std::size_t v = 0; v < vertex_points.size(); ++v)
    normals[vertex_points[v]] = PackedNormal(judge.normal(static_cast<std::int32_t>(v)));
  return normals;
}

void SimplifyState::add_plane(const Triangle& t) {
  const glm::dvec3 cross =
      glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
  const double length = glm::length(cross);
  if (!(length > 0)) return;
  for (const std::int32_t corner : t)
    quadrics[corner].add_plane(cross / length, positions[t[0]], length);
}

bool SimplifyState::take(std::int32_t vertex, Pass pass) {
  if (!waits(vertex, pass) || !mesh.is_used(vertex)) return false;
  due[vertex] = static_cast<std::uint8_t>(due[vertex] & ~static_cast<std::uint8_t>(pass));
  return true;
}

TriangleQuality SimplifyState::worst_of(const Fan& fan) const {
  TriangleQuality worst;
  for (const std::int32_t spoke : fan.spokes) {
    const Triangle t = mesh.triangle(spoke / 3);
    worst.take_worst(judge.quality(t[0], t[1], t[2]));
  }
  return worst;
}

void SimplifyState::begin_round(double begin, double end) {
  round_begin_ = begin;
  round_end_ = end;
  round_count_ = result.vertex_count;
  options.callbacks.report("simplify", begin);
}

void SimplifyState::count_step() {
  // A step looks at the points of all triangles around a vertex: thousands in a dense cloud.
  if (++steps_ % kStepsPerLook == 0) check_stop();
  if (steps_ % kStepsPerReport != 0) return;
  const double left = static_cast<double>(result.vertex_count) /
                      static_cast<double>(std::max<std::int64_t>(round_count_, 1));
  options.callbacks.report("simplify", std::lerp(round_end_, round_begin_, left));
}

}  // namespace planish
