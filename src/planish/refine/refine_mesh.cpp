#include "planish/refine/refine_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>
#include <numeric>
#include <optional>
#include <ranges>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/face_geometry.h"
#include "planish/refine/guess_surface.h"

namespace planish {
namespace {

constexpr double kTooLong = 1.4;  // of the aim
constexpr int kSplitPasses = 10, kLastPasses = 4;
constexpr int kFlipRounds = 6;
constexpr int kMovesAfterSplits = 2, kLastMoves = 4;
constexpr int kMostFaces = 32;  // that a moved place crosses

// Half-edge h = 3 t + i runs from corner i of triangle t to the next.
std::int32_t next_of(std::int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
std::int32_t prev_of(std::int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

// Cosine and sine of the angle between two edges in a metric, times the same length.
struct Angle {
  double cosine, sine;
  Angle(const glm::dvec3& a, const glm::dvec3& b, const glm::dmat3& metric)
      : cosine(glm::dot(a, metric * b)) {
    const double square = glm::dot(a, metric * a) * glm::dot(b, metric * b);
    sine = std::sqrt(std::max(square - cosine * cosine, 0.0));
  }
};

class EvenNet {
 public:
  EvenNet(std::span<const glm::dvec3> given, const MeshTopology& topology,
          std::span<const char> is_line, std::span<const char> is_sharp,
          const EvenTrianglesOptions& options)
      : topology_(topology),
        given_(given),
        is_wall_(topology.edge_count()),
        has_line_(given.size(), 0),
        guess_(given, topology, is_line, is_sharp),
        given_count_(static_cast<std::int32_t>(given.size())),
        positions_(given.begin(), given.end()) {
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      is_wall_[e] = is_line[e] || is_sharp[e] || topology.is_boundary_edge(e);
      if (!is_wall_[e]) continue;
      const auto [a, b] = topology.edge_vertices(e);
      has_line_[a] = has_line_[b] = 1;
    }
    take_triangles();
    metrics_ = spacing_metrics(given, topology, guess_, options);
  }

  EvenTriangles make() {
    for (int pass = 0; pass < kSplitPasses + kLastPasses; ++pass) {
      const bool splits = pass < kSplitPasses;
      if (splits) split_long_edges();
      flip_edges();
      for (int move = 0; move < (splits ? kMovesAfterSplits : kLastMoves); ++move) move_vertices();
      if (!splits) flatten_ridges();
    }
    return result();
  }

 private:
  const MeshTopology& topology_;
  std::span<const glm::dvec3> given_;
  std::vector<char> is_wall_;             // by given edge: nothing goes across
  std::vector<glm::dvec3> face_normals_;  // of given faces, of length 1 or 0
  std::vector<char> has_line_;            // by given vertex
  GuessSurface guess_;
  std::int32_t given_count_;
  std::vector<glm::dvec3> positions_;
  std::vector<glm::dmat3> metrics_;         // see spacing_metrics()
  std::vector<FacePlace> places_;           // of further vertices
  std::vector<char> is_on_line_;            // of further vertices: stay on their fixed edge
  std::vector<std::int32_t> start_, twin_;  // by half-edge
  std::vector<std::int32_t>
      wall_;  // by half-edge: the given corner whose edge it is part of, or -1
  std::vector<std::int32_t> source_;  // by triangle

  [[nodiscard]] std::int32_t triangle_count() const {
    return static_cast<std::int32_t>(source_.size());
  }
  [[nodiscard]] std::int32_t end_of(std::int32_t h) const { return start_[next_of(h)]; }
  [[nodiscard]] std::int32_t opposite(std::int32_t h) const { return start_[prev_of(h)]; }

  void take_triangles() {
    const std::int32_t corners = topology_.corner_count();
    start_.resize(corners);
    twin_.resize(corners);
    wall_.resize(corners);
    source_.resize(topology_.face_count());
    for (std::int32_t c = 0; c < corners; ++c) {
      start_[c] = topology_.vertex_of(c);
      twin_[c] = topology_.twin(c);
      wall_[c] = is_wall_[topology_.edge_of(c)] ? c : -1;
    }
    face_normals_.resize(topology_.face_count());
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      source_[f] = f;
      const glm::dvec3 normal = normal_of(f, given_);
      const double length = glm::length(normal);
      if (length > 0) face_normals_[f] = normal / length;
    }
  }

  // The square of an edge's length in units of what it should have between two vertices.
  [[nodiscard]] double square_of(const glm::dvec3& edge, std::int32_t a, std::int32_t b) const {
    return glm::dot(edge, (metrics_[a] + metrics_[b]) * edge) / 2;
  }

  void split_long_edges() {
    struct Long {
      double ratio;
      std::int32_t half;
    };
    std::vector<Long> all;
    for (std::int32_t h = 0; h < std::ssize(start_); ++h) {
      if (twin_[h] >= 0 && twin_[h] < h) continue;
      const std::int32_t a = start_[h], b = end_of(h);
      const double ratio = square_of(positions_[b] - positions_[a], a, b);
      if (ratio > kTooLong * kTooLong) all.push_back({ratio, h});
    }
    std::ranges::stable_sort(all, std::greater{}, &Long::ratio);
    std::vector<char> is_used(triangle_count(), 0);
    for (const Long& edge : all) {
      const std::int32_t f = edge.half / 3, g = twin_[edge.half] < 0 ? -1 : twin_[edge.half] / 3;
      if (is_used[f] || (g >= 0 && is_used[g])) continue;
      is_used[f] = 1;
      if (g >= 0) is_used[g] = 1;
      split(edge.half);
      is_used.resize(triangle_count(), 1);
    }
  }

  bool split(std::int32_t h) {
    const std::int32_t a = start_[h], b = end_of(h),
                       m = static_cast<std::int32_t>(positions_.size());
    const std::optional<FacePlace> found = middle_place(h);
    if (!found) return false;
    const FacePlace& place = *found;
    const glm::dmat3 between = (metrics_[a] + metrics_[b]) / 2.0;
    metrics_.push_back(between);
    is_on_line_.push_back(wall_[h] >= 0);
    positions_.push_back(turns_over(h, guess_.at(place)) ? (positions_[a] + positions_[b]) / 2.0
                                                         : guess_.at(place));
    places_.push_back(place);
    split_side(h, m);
    const std::int32_t t = twin_[h];
    if (t < 0) return true;
    const std::int32_t n = static_cast<std::int32_t>(start_.size()) - 3;  // m to b, of h's side
    split_side(t, m);
    const std::int32_t k = static_cast<std::int32_t>(start_.size()) - 3;  // m to a
    twin_[h] = k;
    twin_[k] = h;
    twin_[t] = n;
    twin_[n] = t;
    return true;
  }

  // Whether a triangle beside half-edge h would, with its middle put there.
  [[nodiscard]] bool turns_over(std::int32_t h, const glm::dvec3& middle) const {
    for (const std::int32_t side : {h, twin_[h]}) {
      if (side < 0) continue;
      const glm::dvec3 &a = positions_[start_[side]], &b = positions_[end_of(side)],
                       &c = positions_[opposite(side)];
      const glm::dvec3 normal = glm::cross(b - a, c - a);
      if (glm::dot(glm::cross(middle - a, c - a), normal) <= 0 ||
          glm::dot(glm::cross(b - middle, c - middle), normal) <= 0)
        return true;
    }
    return false;
  }

  // Triangle (a, b, c) of half-edge a to b becomes (a, m, c), and a further one is (m, b, c).
  void split_side(std::int32_t h, std::int32_t m) {
    const std::int32_t next = next_of(h), base = static_cast<std::int32_t>(start_.size());
    const std::int32_t b = start_[next], c = opposite(h), beyond = twin_[next];
    for (const std::int32_t v : {m, b, c}) start_.push_back(v);
    twin_.insert(twin_.end(), {-1, beyond, next});
    wall_.insert(wall_.end(), {wall_[h], wall_[next], -1});
    source_.push_back(source_[h / 3]);
    if (beyond >= 0) twin_[beyond] = base + 1;
    start_[next] = m;
    twin_[next] = base + 2;
    wall_[next] = -1;
  }

  [[nodiscard]] std::optional<FacePlace> middle_place(std::int32_t h) const {
    const std::int32_t a = start_[h], b = end_of(h);
    if (wall_[h] >= 0) {
      const std::int32_t face = topology_.face_of(wall_[h]);
      return FacePlace{face, (weights_on(face, a) + weights_on(face, b)) / 2.0};
    }
    return moved(place_at(h), (positions_[a] + positions_[b]) / 2.0);
  }

  // Of the vertex that half-edge h starts at, on its side of the lines there.
  [[nodiscard]] FacePlace place_at(std::int32_t h) const {
    const std::int32_t v = start_[h];
    if (v >= given_count_ && !is_on_line_[v - given_count_]) return places_[v - given_count_];
    if (v < given_count_ && !has_line_[v]) return corner_place(topology_.corners_at(v).front());
    while (wall_[h] < 0) h = next_of(twin_[h]);
    const std::int32_t face = topology_.face_of(wall_[h]);
    return {face, weights_on(face, v)};
  }

  [[nodiscard]] FacePlace corner_place(std::int32_t corner) const {
    FacePlace place{topology_.face_of(corner), glm::dvec3(0)};
    place.weights[topology_.place_of(corner)] = 1;
    return place;
  }

  // Of a vertex of the given face or of one of its edges.
  [[nodiscard]] glm::dvec3 weights_on(std::int32_t face, std::int32_t vertex) const {
    const std::span<const std::int32_t> corners = topology_.face(face);
    glm::dvec3 weights(0);
    if (vertex < given_count_) {
      for (int i = 0; i < 3; ++i)
        if (corners[i] == vertex) weights[i] = 1;
      return weights;
    }
    const FacePlace& place = places_[vertex - given_count_];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (topology_.face(place.face)[i] == corners[j]) weights[j] = place.weights[i];
    return weights;
  }

  void flip_edges() {
    for (int round = 0; round < kFlipRounds; ++round) {
      std::vector<char> is_used(triangle_count(), 0);
      std::int64_t count = 0;
      for (std::int32_t h = 0; h < std::ssize(start_); ++h) {
        const std::int32_t t = twin_[h];
        if (t < h || wall_[h] >= 0 || is_used[h / 3] || is_used[t / 3] || !is_better_flipped(h))
          continue;
        is_used[h / 3] = is_used[t / 3] = 1;
        flip(h);
        ++count;
      }
      if (count == 0) break;
    }
  }

  [[nodiscard]] bool is_better_flipped(std::int32_t h) const {
    const glm::dvec3 &a = positions_[start_[h]], &b = positions_[end_of(h)];
    const std::int32_t under = opposite(twin_[h]);
    const glm::dvec3 &o = positions_[opposite(h)], &p = positions_[under];
    const glm::dvec3 up = glm::cross(a - o, b - o), down = glm::cross(b - p, a - p);
    const glm::dmat3 metric = metrics_[start_[h]] + metrics_[end_of(h)];
    const Angle upper(a - o, b - o, metric), lower(a - p, b - p, metric);
    // cot + cot < 0: opposite angles of more than 180 degrees.
    if (upper.cosine * lower.sine + lower.cosine * upper.sine >= -1e-3 * upper.sine * lower.sine)
      return false;
    const glm::dvec3 left = glm::cross(a - o, p - o), right = glm::cross(b - p, o - p);
    const auto turns = [](const glm::dvec3& m, const glm::dvec3& n) {
      return !(glm::dot(m, n) >= kLeastSmoothCosine * glm::length(m) * glm::length(n));
    };
    // Neither across a ridge nor into one.
    if (turns(up, down) || turns(left, right) || turns(up + down, left + right)) return false;
    return !are_joined(prev_of(h), under);
  }

  // Whether an edge runs from the vertex that half-edge h starts at to `other`.
  [[nodiscard]] bool are_joined(std::int32_t h, std::int32_t other) const {
    std::int32_t at = h;
    do {
      if (end_of(at) == other || opposite(at) == other) return true;
      at = twin_[prev_of(at)];
    } while (at >= 0 && at != h);
    if (at >= 0) return false;
    for (at = twin_[h]; at >= 0; at = twin_[at]) {
      at = next_of(at);
      if (end_of(at) == other || opposite(at) == other) return true;
    }
    return false;
  }

  // (a, b, o) and (b, a, p) become (o, a, p) and (p, b, o).
  void flip(std::int32_t h) {
    const std::int32_t t = twin_[h];
    const std::int32_t h1 = next_of(h), h2 = prev_of(h), t1 = next_of(t), t2 = prev_of(t);
    const std::int32_t o = start_[h2], p = start_[t2];
    // h becomes p to o in the triangle (p, o, a); t becomes o to p in (o, p, b).
    const std::int32_t beyond_bo = twin_[h1], beyond_ap = twin_[t1];
    const std::int32_t wall_bo = wall_[h1], wall_ap = wall_[t1];
    const std::int32_t a = start_[h], b = start_[t];
    // Triangle of h: h: p->o, h1: o->a (was h2), h2: a->p (was t1).
    const std::int32_t beyond_oa = twin_[h2], beyond_pb = twin_[t2];
    const std::int32_t wall_oa = wall_[h2], wall_pb = wall_[t2];
    start_[h] = p;
    start_[h1] = o;
    start_[h2] = a;
    set_twin(h1, beyond_oa, wall_oa);
    set_twin(h2, beyond_ap, wall_ap);
    // Triangle of t: t: o->p, t1: p->b (was t2), t2: b->o (was h1).
    start_[t] = o;
    start_[t1] = p;
    start_[t2] = b;
    set_twin(t1, beyond_pb, wall_pb);
    set_twin(t2, beyond_bo, wall_bo);
  }

  void set_twin(std::int32_t h, std::int32_t twin, std::int32_t wall) {
    twin_[h] = twin;
    wall_[h] = wall;
    if (twin >= 0) twin_[twin] = h;
  }

  void move_vertices() {
    const std::size_t count = positions_.size();
    std::vector<glm::dvec3> sums(count, glm::dvec3(0));
    std::vector<double> areas(count, 0);
    for (std::int32_t t = 0; t < triangle_count(); ++t) {
      const glm::dvec3 &a = positions_[start_[3 * t]], &b = positions_[start_[3 * t + 1]],
                       &c = positions_[start_[3 * t + 2]];
      const double area = glm::length(glm::cross(b - a, c - a));
      const glm::dvec3 part = area / 3 * (a + b + c);
      for (int i = 0; i < 3; ++i) {
        sums[start_[3 * t + i]] += part;
        areas[start_[3 * t + i]] += area;
      }
    }
    const std::vector<FacePlace> places_before = places_;
    const std::vector<glm::dvec3> before = positions_;
    parallel_each(places_.size(), 256, [&](std::size_t i) {
      const std::size_t v = given_count_ + i;
      if (is_on_line_[i] || !(areas[v] > 0)) return;
      const std::optional<FacePlace> place = moved(places_[i], sums[v] / areas[v]);
      if (!place) return;
      places_[i] = *place;
      positions_[v] = guess_.at(*place);
    });
    take_back(places_before, before);
  }

  // The given faces on which triangles beside an edge lie, if that edge then turns less. False, and
  // nothing is done, else.
  bool lay_flat_around(std::int32_t h) {
    const std::int32_t t = twin_[h];
    const std::array<std::int32_t, 4> vertices{start_[h], start_[t], opposite(h), opposite(t)};
    const auto cosine = [&](const std::array<glm::dvec3, 4>& at) {
      const glm::dvec3 m = glm::cross(at[1] - at[0], at[2] - at[0]),
                       n = glm::cross(at[0] - at[1], at[3] - at[1]);
      const double lengths = glm::length(m) * glm::length(n);
      return lengths > 0 ? glm::dot(m, n) / lengths : -1;
    };
    std::array<glm::dvec3, 4> before, after;
    for (std::size_t i = 0; i < 4; ++i) before[i] = positions_[vertices[i]];
    std::vector<std::int32_t> laid;
    for (const std::int32_t v : vertices) {
      if (v < given_count_) continue;
      const std::int32_t face = places_[v - given_count_].face;
      if (guess_.is_flat(face) || guess_.is_told(face)) continue;
      guess_.flatten(face);
      laid.push_back(face);
    }
    if (laid.empty()) return false;
    for (std::size_t i = 0; i < 4; ++i)
      after[i] =
          vertices[i] < given_count_ ? before[i] : guess_.at(places_[vertices[i] - given_count_]);
    if (cosine(after) > cosine(before)) return true;
    for (const std::int32_t face : laid) guess_.flatten(face, false);
    return false;
  }

  // Where triangles turn by more than the given faces do, the guess is not believed.
  void flatten_ridges() {
    for (bool is_any = true; is_any;) {
      is_any = false;
      for (std::int32_t h = 0; h < std::ssize(start_); ++h) {
        const std::int32_t t = twin_[h];
        if (t < h || wall_[h] >= 0) continue;
        const glm::dvec3 m = normal_of(h / 3, positions_), n = normal_of(t / 3, positions_);
        if (glm::dot(m, n) >= kLeastSmoothCosine * glm::length(m) * glm::length(n)) continue;
        is_any |= lay_flat_around(h);
      }
      for (std::size_t i = 0; is_any && i < places_.size(); ++i)
        if (guess_.is_flat(places_[i].face)) positions_[given_count_ + i] = guess_.at(places_[i]);
    }
  }

  // Vertices whose triangles turn over, or farther from the faces below, stay where they were.
  void take_back(std::span<const FacePlace> places, std::span<const glm::dvec3> before) {
    for (bool is_any = true; is_any;) {
      is_any = false;
      std::vector<char> stays(places_.size(), 0);
      for (std::int32_t t = 0; t < triangle_count(); ++t) {
        const glm::dvec3 now = normal_of(t, positions_), then = normal_of(t, before);
        if (glm::dot(now, then) > 0) {
          const double lean = lean_of(t, now, places_);
          if (lean >= kLeastSmoothCosine || lean >= lean_of(t, then, places)) continue;
        }
        for (int i = 0; i < 3; ++i) {
          const std::int32_t v = start_[3 * t + i];
          if (v < given_count_ || positions_[v] == before[v]) continue;
          stays[v - given_count_] = 1;
          is_any = true;
        }
      }
      for (std::size_t i = 0; i < stays.size(); ++i) {
        if (!stays[i]) continue;
        places_[i] = places[i];
        positions_[given_count_ + i] = before[given_count_ + i];
      }
    }
  }

  // Cosine of the angle from a triangle's normal to that of the given faces its vertices are on.
  [[nodiscard]] double lean_of(std::int32_t t, const glm::dvec3& normal,
                               std::span<const FacePlace> places) const {
    glm::dvec3 below(0);
    for (int i = 0; i < 3; ++i) {
      const std::int32_t v = start_[3 * t + i];
      if (v >= given_count_) below += face_normals_[places[v - given_count_].face];
    }
    const double length = glm::length(below) * glm::length(normal);
    return length > 0 ? glm::dot(below, normal) / length : 1;
  }

  [[nodiscard]] glm::dvec3 normal_of(std::int32_t t, std::span<const glm::dvec3> at) const {
    const glm::dvec3& a = at[start_[3 * t]];
    return glm::cross(at[start_[3 * t + 1]] - a, at[start_[3 * t + 2]] - a);
  }

  // The place nearest to a point, walking from face to face; where a line is in the way, none.
  [[nodiscard]] std::optional<FacePlace> moved(FacePlace place, const glm::dvec3& target) const {
    std::int32_t before = -1;
    for (int step = 0; step < kMostFaces; ++step) {
      place.weights = weights_of(place.face, target);
      const glm::dvec3& w = place.weights;
      const int out = w.x < w.y ? (w.x < w.z ? 0 : 2) : (w.y < w.z ? 1 : 2);
      if (w[out] >= 0) return place;
      const std::int32_t corner = topology_.first_corner(place.face) + (out + 1) % 3;
      if (is_wall_[topology_.edge_of(corner)]) return std::nullopt;
      const std::int32_t other = topology_.face_of(topology_.twin(corner));
      if (other == before) break;  // above a ridge, which is nearest
      before = place.face;
      place.face = other;
    }
    place.weights = glm::max(place.weights, glm::dvec3(0));
    place.weights /= place.weights.x + place.weights.y + place.weights.z;
    return place;
  }

  // Of the point's foot on the face's plane.
  [[nodiscard]] glm::dvec3 weights_of(std::int32_t face, const glm::dvec3& point) const {
    const std::span<const std::int32_t> v = topology_.face(face);
    const glm::dvec3 a = given_[v[0]], u = given_[v[1]] - a, w = given_[v[2]] - a, to = point - a;
    const glm::dvec3 normal = glm::cross(u, w);
    const double square = glm::dot(normal, normal);
    if (!(square > 0)) return glm::dvec3(1.0 / 3);
    const double y = glm::dot(glm::cross(to, w), normal) / square;
    const double z = glm::dot(glm::cross(u, to), normal) / square;
    return {1 - y - z, y, z};
  }

  // A given vertex or one on a line is at several places, one a side of the lines there.
  [[nodiscard]] std::vector<FacePlace> corner_places() const {
    std::vector<FacePlace> places(start_.size());
    for (std::size_t h = 0; h < places.size(); ++h) {
      const std::int32_t v = start_[h];
      places[h] = v < given_count_ ? corner_place(topology_.corners_at(v).front())
                                   : places_[v - given_count_];
    }
    for (std::int32_t h = 0; h < std::ssize(start_); ++h) {
      if (wall_[h] < 0) continue;
      const std::int32_t face = topology_.face_of(wall_[h]);
      const FacePlace place{face, weights_on(face, start_[h])};
      for (std::int32_t at = h;;) {
        places[at] = place;
        const std::int32_t before = prev_of(at);
        if (wall_[before] >= 0) break;
        at = twin_[before];
      }
    }
    return places;
  }

  EvenTriangles result() {
    EvenTriangles made;
    made.corner_places = corner_places();
    made.positions = std::move(positions_);
    made.places = std::move(places_);
    made.doubts.reserve(topology_.corner_count());
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c)
      made.doubts.push_back(guess_.doubt(c));
    made.source_faces = std::move(source_);
    made.triangles.resize(made.source_faces.size());
    for (std::size_t t = 0; t < made.triangles.size(); ++t)
      made.triangles[t] = {start_[3 * t], start_[3 * t + 1], start_[3 * t + 2]};
    for (std::int32_t h = 0; h < std::ssize(start_); ++h)
      if (wall_[h] >= 0 && twin_[h] < h)
        made.lines.push_back({start_[h], end_of(h), topology_.edge_of(wall_[h])});
    return made;
  }
};

}  // namespace

EvenTriangles make_even_triangles(std::span<const glm::dvec3> positions,
                                  const MeshTopology& topology, std::span<const char> is_line,
                                  std::span<const char> is_sharp,
                                  const EvenTrianglesOptions& options) {
  return EvenNet(positions, topology, is_line, is_sharp, options).make();
}

namespace {

constexpr std::size_t kSumPiece = 4096;

bool is_hole(std::span<const std::int32_t> holes, std::int32_t face) {
  return std::ranges::binary_search(holes, face);
}

// What rides on a mesh, asked of places on its faces.
class Riders {
 public:
  Riders(const PolygonMesh& mesh, const PreparedMesh& prepared)
      : mesh_(mesh), topology_(*prepared.topology), vertices_(prepared.vertices) {
    holes_ = mesh.hole_faces;
    std::ranges::sort(holes_);
    sharpness_.assign(topology_.edge_count(), 0.0f);
    std::vector<std::int32_t> number(mesh.positions.size(), -1);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      number[vertices_[i]] = static_cast<std::int32_t>(i);
    for (const CreaseEdge& crease : mesh.creases) {
      const std::int32_t a = number[crease.v0], b = number[crease.v1];
      const std::int32_t edge = a < 0 || b < 0 ? -1 : topology_.find_edge(a, b);
      if (edge >= 0) sharpness_[edge] = std::max(sharpness_[edge], crease.sharpness);
    }
  }

  [[nodiscard]] bool is_crease(std::int32_t edge) const {
    return sharpness_[edge] >= kInfiniteSharpness;
  }
  [[nodiscard]] std::vector<char> creases() const {
    std::vector<char> creases(sharpness_.size());
    parallel_each(creases.size(),
                  [&](std::size_t e) { creases[e] = is_crease(static_cast<std::int32_t>(e)); });
    return creases;
  }
  // By which the faces turn at an edge, in radians; 0 at a boundary.
  [[nodiscard]] double turn(std::int32_t edge) const {
    const std::int32_t corner = topology_.corner_of(edge), twin = topology_.twin(corner);
    if (twin < 0) return 0;
    return angle_between(normal(topology_.face_of(corner)), normal(topology_.face_of(twin)));
  }
  [[nodiscard]] double length(std::int32_t edge) const {
    const auto [a, b] = topology_.edge_vertices(edge);
    return glm::distance(position(a), position(b));
  }
  [[nodiscard]] float sharpness(std::int32_t edge) const { return sharpness_[edge]; }

  // Edges that have a tag, or other riders on their two sides.
  [[nodiscard]] std::vector<char> lines() const {
    std::vector<char> is_line(sharpness_.size(), 0);
    parallel_each(is_line.size(), [&](std::size_t e) {
      const std::int32_t corner = topology_.corner_of(static_cast<std::int32_t>(e));
      const std::int32_t twin = topology_.twin(corner);
      if (twin < 0) return;
      const std::int32_t f = topology_.face_of(corner), g = topology_.face_of(twin);
      is_line[e] = sharpness_[e] > 0 || group(f) != group(g) ||
                   is_hole(holes_, f) != is_hole(holes_, g) ||
                   uv(corner) != uv(topology_.next(twin)) || uv(topology_.next(corner)) != uv(twin);
    });
    return is_line;
  }

  [[nodiscard]] bool hole(std::int32_t face) const { return is_hole(holes_, face); }

  // Colours and attributes of the added vertices.
  void add_vertices(std::span<const FacePlace> places, PolygonMesh& to) const {
    const auto first = to.positions.size() - places.size();
    if (!mesh_.colors.empty()) {
      to.colors.resize(to.positions.size());
      for (std::size_t i = 0; i < places.size(); ++i) {
        glm::dvec4 color(0);
        for (int k = 0; k < 3; ++k)
          color += places[i].weights[k] * glm::dvec4(mesh_.colors[vertex(places[i], k)]);
        to.colors[first + i] = color;
      }
    }
    for (VertexAttribute& attribute : to.attributes) {
      const auto width = static_cast<std::size_t>(attribute.width);
      attribute.values.resize(width * to.positions.size());
      for (std::size_t i = 0; i < places.size(); ++i)
        for (std::size_t j = 0; j < width; ++j) {
          double value = 0;
          for (int k = 0; k < 3; ++k)
            value += places[i].weights[k] *
                     attribute.values[width * static_cast<std::size_t>(vertex(places[i], k)) + j];
          attribute.values[width * (first + i) + j] = static_cast<float>(value);
        }
    }
  }

  // Texture coordinates of the corners of `even`, whose vertices are numbered without unused ones.
  void add_uvs(const EvenTriangles& even, PolygonMesh& to) const {
    if (mesh_.face_uvs.empty()) return;
    to.face_uvs.reserve(even.corner_places.size());
    // Of each added vertex, by the given face on whose side the corner is: one, or two on lines.
    const std::size_t given = even.positions.size() - even.places.size();
    std::vector<std::array<std::pair<std::int32_t, std::int32_t>, 2>> made(
        even.places.size(), {std::pair{-1, -1}, std::pair{-1, -1}});
    for (std::size_t c = 0; c < even.corner_places.size(); ++c) {
      const FacePlace& place = even.corner_places[c];
      const auto v = static_cast<std::size_t>(even.triangles[c / 3][c % 3]);
      const std::int32_t corner = topology_.first_corner(place.face);
      if (v < given) {
        const int k = place.weights.x > 0.5 ? 0 : place.weights.y > 0.5 ? 1 : 2;
        to.face_uvs.push_back(uv(corner + k));
        continue;
      }
      auto& sides = made[v - given];
      auto& side = sides[0].first < 0 || sides[0].first == place.face ? sides[0] : sides[1];
      if (side.first < 0) side = {place.face, added_uv(place, corner, to)};
      to.face_uvs.push_back(side.second);
    }
  }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  std::span<const std::int32_t> vertices_;
  std::vector<std::int32_t> holes_;  // ascending
  std::vector<float> sharpness_;     // by edge

  [[nodiscard]] const glm::dvec3& position(std::int32_t vertex) const {
    return mesh_.positions[vertices_[vertex]];
  }
  [[nodiscard]] glm::dvec3 normal(std::int32_t face) const {
    const std::span<const std::int32_t> v = topology_.face(face);
    const glm::dvec3& a = position(v[0]);
    return glm::cross(position(v[1]) - a, position(v[2]) - a);
  }
  [[nodiscard]] std::int32_t group(std::int32_t face) const {
    return mesh_.face_groups.empty() ? 0 : mesh_.face_groups[face];
  }
  [[nodiscard]] std::int32_t uv(std::int32_t corner) const {
    return mesh_.face_uvs.empty() ? -1 : mesh_.face_uvs[corner];
  }
  [[nodiscard]] std::int32_t vertex(const FacePlace& place, int corner) const {
    return vertices_[topology_.face(place.face)[corner]];
  }
  [[nodiscard]] std::int32_t added_uv(const FacePlace& place, std::int32_t corner,
                                      PolygonMesh& to) const {
    glm::dvec2 sum(0);
    for (int k = 0; k < 3; ++k) {
      if (uv(corner + k) < 0) return -1;
      sum += place.weights[k] * mesh_.uvs[uv(corner + k)];
    }
    to.uvs.push_back(sum);
    return static_cast<std::int32_t>(to.uvs.size()) - 1;
  }
};

bool are_triangles(const PolygonMesh& mesh) {
  return mesh.face_vertices.size() == 3 * static_cast<std::size_t>(mesh.face_count()) &&
         std::ranges::all_of(std::views::iota(0, mesh.face_count()),
                             [&](std::int32_t f) { return mesh.face_size(f) == 3; });
}

// Faces in the order of the given ones that they lie over, added vertices in that of the faces:
// what is drawn, packed or cut into parts by numbers keeps together what lies together.
void order_by_hosts(EvenTriangles& even) {
  std::vector<std::int32_t> order(even.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::int32_t f) { return even.source_faces[f]; });
  EvenTriangles made = even;
  const std::size_t given = even.positions.size() - even.places.size();
  std::vector<std::int32_t> number(even.positions.size(), -1);
  std::iota(number.begin(), number.begin() + static_cast<std::ptrdiff_t>(given), 0);
  auto next = static_cast<std::int32_t>(given);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto from = static_cast<std::size_t>(order[i]);
    made.source_faces[i] = even.source_faces[from];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = even.triangles[from][k];
      if (number[v] < 0) number[v] = next++;
      made.triangles[i][k] = number[v];
      made.corner_places[3 * i + k] = even.corner_places[3 * from + k];
    }
  }
  for (std::size_t v = given; v < even.positions.size(); ++v) {
    made.positions[number[v]] = even.positions[v];
    made.places[number[v] - given] = even.places[v - given];
  }
  for (LinePart& part : made.lines) {
    part.v0 = number[part.v0];
    part.v1 = number[part.v1];
  }
  even = std::move(made);
}

// Quads have even rings of their own: they gain nothing.
bool are_mostly_quads(const PolygonMesh& mesh) {
  std::int64_t quads = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) quads += mesh.face_size(f) == 4;
  return 2 * quads >= mesh.face_count();
}

// Larger faces in triangles; what rides on the mesh rides on.
struct CutMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_faces;
};

CutMesh in_triangles(const PolygonMesh& mesh) {
  CutMesh cut{mesh, {}};
  PolygonMesh& to = cut.mesh;
  to.face_offsets = {0};
  for (auto* const list : {&to.face_vertices, &to.face_uvs, &to.face_groups, &to.hole_faces})
    list->clear();
  std::vector<std::int32_t> holes = mesh.hole_faces, places;
  std::ranges::sort(holes);
  std::vector<glm::dvec3> points;
  std::vector<std::uint32_t> parts;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::int32_t> face = mesh.face(f);
    const std::int32_t first = mesh.face_offsets[f];
    places.resize(face.size());
    std::iota(places.begin(), places.end(), 0);
    points.clear();
    for (const std::int32_t v : face) points.push_back(mesh.positions[v]);
    parts.resize(3 * (face.size() - 2));
    triangulate(places, points, parts);
    for (std::size_t i = 0; i < parts.size(); i += 3) {
      to.add_face(std::array{face[parts[i]], face[parts[i + 1]], face[parts[i + 2]]});
      for (std::size_t k = i; k < i + 3 && !mesh.face_uvs.empty(); ++k)
        to.face_uvs.push_back(mesh.face_uvs[first + parts[k]]);
      if (!mesh.face_groups.empty()) to.face_groups.push_back(mesh.face_groups[f]);
      if (is_hole(holes, f)) to.hole_faces.push_back(to.face_count() - 1);
      cut.source_faces.push_back(f);
    }
  }
  return cut;
}

std::optional<RefinedMesh> refine_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  std::vector<glm::dvec3> used(prepared.vertices.size());
  for (std::size_t i = 0; i < used.size(); ++i) used[i] = mesh.positions[prepared.vertices[i]];
  const Riders riders(mesh, prepared);
  // Each side of an edge by which no smooth surface goes is looked at by itself.
  std::vector<char> is_sharp = riders.creases();
  mark_ridges(used, *prepared.topology, is_sharp);
  EvenTriangles even = make_even_triangles(used, *prepared.topology, riders.lines(), is_sharp);
  if (even.places.empty()) return std::nullopt;
  order_by_hosts(even);
  RefinedMesh made;
  PolygonMesh& to = made.mesh;
  to.positions = mesh.positions;
  to.positions.insert(to.positions.end(), even.positions.begin() + std::ssize(used),
                      even.positions.end());
  // Unused vertices stay among the given ones.
  const auto number = [&](std::int32_t v) {
    const auto given = static_cast<std::int32_t>(used.size());
    return v < given ? prepared.vertices[v] : mesh.vertex_count() + v - given;
  };
  for (const auto& [a, b, c] : even.triangles)
    to.add_face(std::array{number(a), number(b), number(c)});
  for (const LinePart& part : even.lines)
    if (const float sharpness = riders.sharpness(part.edge); sharpness > 0)
      to.creases.push_back({number(part.v0), number(part.v1), sharpness});
  to.corners = mesh.corners;
  to.uvs = mesh.uvs;
  to.colors = mesh.colors;
  to.attributes = mesh.attributes;
  riders.add_vertices(even.places, to);
  riders.add_uvs(even, to);
  to.groups = mesh.groups;
  for (std::size_t f = 0; f < even.source_faces.size(); ++f) {
    const std::int32_t source = even.source_faces[f];
    if (!mesh.face_groups.empty()) to.face_groups.push_back(mesh.face_groups[source]);
    if (riders.hole(source)) to.hole_faces.push_back(static_cast<std::int32_t>(f));
  }
  made.source_faces = std::move(even.source_faces);
  made.added.reserve(even.places.size());
  for (const FacePlace& place : even.places) {
    const std::span<const std::int32_t> v = prepared.topology->face(place.face);
    const auto doubts =
        std::span(even.doubts).subspan(prepared.topology->first_corner(place.face), 3);
    made.added.push_back({{number(v[0]), number(v[1]), number(v[2])},
                          place.weights,
                          glm::dot(place.weights, glm::dvec3(doubts[0], doubts[1], doubts[2]))});
  }
  return made;
}

}  // namespace

std::optional<RefinedMesh> refine_mesh(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  if (are_triangles(mesh)) return refine_triangles(mesh, prepared);
  if (are_mostly_quads(mesh)) return std::nullopt;
  CutMesh cut = in_triangles(mesh);
  // A diagonal may run where the mesh has an edge.
  const auto cut_prepared = prepare_if_sound(cut.mesh);
  if (!cut_prepared) return std::nullopt;
  std::optional<RefinedMesh> made = refine_triangles(cut.mesh, *cut_prepared);
  if (!made) return std::nullopt;
  for (std::int32_t& face : made->source_faces) face = cut.source_faces[face];
  return made;
}

double rms_turn(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  const Riders riders(mesh, prepared);
  struct Sum {
    double squares = 0, length = 0;
  };
  const Sum sum = ordered_reduce(
      static_cast<std::size_t>(prepared.topology->edge_count()), kSumPiece, Sum{},
      [&](std::size_t begin, std::size_t end) {
        Sum part;
        for (auto e = static_cast<std::int32_t>(begin); e < static_cast<std::int32_t>(end); ++e) {
          if (riders.is_crease(e)) continue;
          const double length = riders.length(e), turn = riders.turn(e);
          part.squares += length * turn * turn;
          part.length += length;
        }
        return part;
      },
      [](Sum& total, const Sum& part) {
        total.squares += part.squares;
        total.length += part.length;
      });
  return sum.length > 0 ? glm::degrees(std::sqrt(sum.squares / sum.length)) : 0;
}

}  // namespace planish
