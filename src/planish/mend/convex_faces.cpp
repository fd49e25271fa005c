#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/portable_math.h"
#include "planish/core/work.h"
#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

// Based on: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983; Lawson, "Software
// for C1 surface interpolation", 1977 (flips).

using glm::dvec2;

constexpr std::uint32_t kOutside = 0xffffffff;
// A polygon of n corners is flipped so many times n at most: rounding must not flip without end.
constexpr std::size_t kFlipsPerCorner = 16;

struct HalfEdge {
  std::uint32_t from, next, previous, twin = kOutside;  // `from`: a corner of the polygon
  double angle = 0;                                     // of its face at `from`
};

// The triangles of a polygon, and what they merge to.
class Parts {
 public:
  explicit Parts(std::span<const dvec2> polygon) : polygon_(polygon) {
    using Side = std::pair<std::array<std::uint32_t, 2>, std::uint32_t>;
    std::vector<Side> sides;  // by the corners that they join
    for (const auto& triangle : clip_ears(polygon)) {
      const auto first = static_cast<std::uint32_t>(edges_.size());
      for (std::uint32_t k = 0; k < 3; ++k) {
        edges_.push_back({triangle[k], first + (k + 1) % 3, first + (k + 2) % 3});
        const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3]);
        sides.push_back({{low, high}, first + k});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
      if (sides[s].first != sides[s + 1].first) continue;
      edges_[sides[s].second].twin = sides[s + 1].second;
      edges_[sides[s + 1].second].twin = sides[s].second;
    }
  }

  // To a Delaunay triangulation, which ears nearly are.
  void flip_all() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t h = 0; h < edges_.size(); ++h)
      if (h < edges_[h].twin && edges_[h].twin != kOutside) open.push_back(h);
    for (std::size_t left = kFlipsPerCorner * polygon_.size(); left > 0 && !open.empty();) {
      const std::uint32_t h = open.back();
      open.pop_back();
      if (!is_better_flipped(h)) continue;
      flip(h);
      --left;
      const std::uint32_t g = edges_[h].twin;
      for (const std::uint32_t side :
           {edges_[h].next, edges_[h].previous, edges_[g].next, edges_[g].previous})
        if (edges_[side].twin != kOutside) open.push_back(side);
    }
  }

  void merge(std::span<const double> allowed,
             const std::function<bool(std::size_t, std::size_t)>& may_cut) {
    std::vector<std::pair<double, std::uint32_t>> diagonals;
    for (std::uint32_t h = 0; h < edges_.size(); ++h) {
      HalfEdge& edge = edges_[h];
      const dvec2 along = place(edges_[edge.next].from) - place(edge.from);
      const dvec2 back = place(edges_[edge.previous].from) - place(edge.from);
      edge.angle = portable::atan2(along.x * back.y - along.y * back.x, glm::dot(along, back));
      if (h < edge.twin && edge.twin != kOutside)
        diagonals.emplace_back(-glm::dot(along, along), h);
    }
    std::sort(diagonals.begin(), diagonals.end());
    for (const auto& [length, h] : diagonals) {
      const std::uint32_t g = edges_[h].twin;
      HalfEdge &after_h = edges_[edges_[h].next], &after_g = edges_[edges_[g].next];
      const double at_start = edges_[h].angle + after_g.angle;
      const double at_end = edges_[g].angle + after_h.angle;
      const std::uint32_t start = edges_[h].from, end = edges_[g].from;
      if ((at_start > allowed[start] || at_end > allowed[end]) && may_cut(start, end)) continue;
      link(edges_[h].previous, edges_[g].next);
      link(edges_[g].previous, edges_[h].next);
      after_g.angle = at_start;
      after_h.angle = at_end;
      edges_[h].from = edges_[g].from = kOutside;
    }
  }

  [[nodiscard]] std::vector<std::vector<std::size_t>> corners() {
    std::vector<std::vector<std::size_t>> parts;
    for (std::uint32_t h = 0; h < edges_.size(); ++h) {
      if (edges_[h].from == kOutside) continue;
      std::vector<std::size_t>& part = parts.emplace_back();
      for (std::uint32_t at = h; edges_[at].from != kOutside; at = edges_[at].next)
        part.push_back(std::exchange(edges_[at].from, kOutside));
    }
    return parts;
  }

 private:
  [[nodiscard]] const dvec2& place(std::uint32_t corner) const { return polygon_[corner]; }

  void link(std::uint32_t h, std::uint32_t next) {
    edges_[h].next = next;
    edges_[next].previous = h;
  }

  // The corner opposite of a side of a triangle.
  [[nodiscard]] const dvec2& opposite(std::uint32_t h) const {
    return place(edges_[edges_[h].previous].from);
  }

  [[nodiscard]] bool is_better_flipped(std::uint32_t h) const {
    constexpr double kRounding = 1e-12;
    const std::uint32_t g = edges_[h].twin;
    const dvec2 &a = place(edges_[h].from), &b = place(edges_[g].from);
    const dvec2 &c = opposite(h), &d = opposite(g);
    if (!(turn(d, b, c) > 0 && turn(c, a, d) > 0)) return false;
    // The angles at c and d are more than a half turn together: each is in the other's circle.
    const double sine_c = turn(c, a, b), sine_d = turn(d, b, a);
    const double cosine_c = glm::dot(a - c, b - c), cosine_d = glm::dot(b - d, a - d);
    const double size = std::abs(cosine_c * sine_d) + std::abs(sine_c * cosine_d);
    return sine_c * cosine_d + cosine_c * sine_d < -kRounding * size;
  }

  // a-b in the triangles a, b, c and b, a, d becomes d-c.
  void flip(std::uint32_t h) {
    const std::uint32_t g = edges_[h].twin;
    const std::uint32_t b_c = edges_[h].next, c_a = edges_[h].previous;
    const std::uint32_t a_d = edges_[g].next, d_b = edges_[g].previous;
    edges_[h].from = edges_[d_b].from;
    edges_[g].from = edges_[c_a].from;
    link(h, c_a);
    link(c_a, a_d);
    link(a_d, h);
    link(g, d_b);
    link(d_b, b_c);
    link(b_c, g);
  }

  std::span<const dvec2> polygon_;
  std::vector<HalfEdge> edges_;  // three a triangle; those of removed diagonals start nowhere
};

// Parts that a polygon falls into, as corner numbers in its winding, in no order: its Delaunay
// triangulation less the diagonals that no corner needs, the longest first. They are at most four
// times as many as the least possible. Time of the order of n log n for most polygons.
//
// `polygon`: the places of its n corners, counter-clockwise; where it crosses itself parts may
// overlap. `allowed`: n angles in radians; corners have no wider ones in a part unless the polygon
// has only room for those. `may_cut(i, j)`: whether a diagonal may stay between these corners.
// Source: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983.
std::vector<std::vector<std::size_t>> convex_parts(
    std::span<const dvec2> polygon, std::span<const double> allowed,
    const std::function<bool(std::size_t, std::size_t)>& may_cut) {
  Parts parts(polygon);
  parts.flip_all();
  parts.merge(allowed, may_cut);
  return parts.corners();
}

using Part = std::vector<std::size_t>;

// What is less even is cut by a chord, where that leaves something more even.
constexpr double kEven = 0.3, kGain = 1.05, kTie = 0.01;
// Two corners on each side of a row make a quad where that is so even, else a triangle.
constexpr double kEvenQuad = 0.6;
constexpr std::size_t kLongSides = 4;                 // whose ends are tried for chords and rows
constexpr std::size_t kOtherEnds = 64, kStarts = 16;  // tried too, evenly spread
constexpr double kNone = std::numeric_limits<double>::infinity();

// Places of a polygon, or of a run of its corners with the chord that cuts it off.
struct Run {
  std::span<const dvec2> polygon;
  std::size_t first, count;

  [[nodiscard]] const dvec2& at(std::size_t i) const {
    return polygon[(first + i % count) % polygon.size()];
  }
};

// How evenly the corners lie around their mean: the least area between it and a side, by the mean
// of all. 1 of affine regular polygons and triangles, negative where it lies behind a side. Of
// large ones few sides are asked.
double evenness(const Run& run) {
  constexpr std::size_t kMostAsked = 256;
  constexpr double kFlat = 1e-9;
  const std::size_t stride = 1 + (run.count - 1) / kMostAsked;
  dvec2 mean(0.0);
  double asked = 0;
  for (std::size_t i = 0; i < run.count; i += stride, ++asked) mean += run.at(i);
  mean /= asked;
  double least = kNone, sum = 0, reach = 0;
  const auto ask = [&](std::size_t i) {
    const dvec2 own = run.at(i) - mean;
    const double area = cross(own, run.at(i + 1) - mean);
    least = std::min(least, area);
    reach = std::max(reach, glm::dot(own, own));
    return std::abs(area);
  };
  for (std::size_t i = 0; i < run.count; i += stride) sum += ask(i);
  (void)ask(run.count - 1);  // the chord
  count_work(Work::Pairs, static_cast<std::int64_t>(asked));
  return sum > kFlat * reach ? least * asked / sum : -1;
}

std::vector<std::size_t> long_sides(std::span<const dvec2> polygon) {
  const std::size_t n = polygon.size();
  const auto square = [&](std::size_t i) {
    const dvec2 side = polygon[(i + 1) % n] - polygon[i];
    return glm::dot(side, side);
  };
  std::vector<std::size_t> sides(n);
  std::iota(sides.begin(), sides.end(), std::size_t{0});
  const auto end = sides.begin() + static_cast<std::ptrdiff_t>(std::min(n, kLongSides));
  std::partial_sort(sides.begin(), end, sides.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(-square(a), a) < std::pair(-square(b), b);
  });
  sides.erase(end, sides.end());
  return sides;
}

void add_spread(std::size_t count, std::size_t most, std::vector<std::size_t>& places) {
  const std::size_t taken = std::min(count, most);
  for (std::size_t k = 0; k < taken; ++k) places.push_back(k * count / taken);
}

struct Chord {
  double loss;           // the less the better
  std::size_t from, to;  // the part from the one to the other, and the rest

  auto operator<=>(const Chord&) const = default;
};

// The chords between these corners that make a polygon, which has the evenness `own`, more even;
// the best first.
std::vector<Chord> good_chords(std::span<const dvec2> polygon, double own,
                               std::span<const std::size_t> ends,
                               std::span<const std::size_t> others) {
  const std::size_t n = polygon.size();
  std::vector<Chord> found;
  for (const std::size_t end : ends) {
    for (const std::size_t other : others) {
      const auto [from, to] = std::minmax(end, other);
      const std::size_t inside = to - from + 1, outside = n - inside + 2;
      if (inside < 3 || outside < 3) continue;
      const double a = evenness({polygon, from, inside}), b = evenness({polygon, to, outside});
      if (std::min(a, b) <= 0) continue;
      const double gain = (std::min(a, kEven) * static_cast<double>(inside - 2) +
                           std::min(b, kEven) * static_cast<double>(outside - 2)) /
                          static_cast<double>(n - 2);
      if (std::max(a, b) >= kEven || gain > kGain * own)
        found.push_back({-gain - kTie * std::min(a, b), from, to});
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Those between ends of long sides before all others.
std::vector<Chord> good_chords(std::span<const dvec2> polygon) {
  const std::size_t n = polygon.size();
  const double own = evenness({polygon, 0, n});
  if (own >= kEven) return {};
  std::vector<std::size_t> ends, others;
  for (const std::size_t side : long_sides(polygon)) {
    ends.push_back(side);
    ends.push_back((side + 1) % n);
  }
  std::vector<Chord> chords = good_chords(polygon, own, ends, ends);
  if (!chords.empty()) return chords;
  add_spread(n, kOtherEnds, others);
  return good_chords(polygon, own, ends, others);
}

// Cuts a polygon in a row of quads and triangles between its two sides, from the side that begins
// at `start` on: take(piece, from, to) gets each, by corners of the polygon, and the diagonal
// behind it, which behind the last one is a side or a corner. Ends where that returns false and
// where neither side can go on. Returns whether it came to the end.
template <class Take>
bool cut_in_row(std::span<const dvec2> polygon, std::size_t start, const Take& take) {
  const std::size_t n = polygon.size();
  std::size_t from = (start + 1) % n, to = start;
  for (std::size_t left = n - 2; left > 0;) {
    const std::size_t next = (from + 1) % n, last = (to + n - 1) % n;
    const dvec2 &a = polygon[from], &b = polygon[next], &c = polygon[last], &d = polygon[to];
    const std::array quad{a, b, c, d};
    const bool is_quad = left >= 2 && evenness({quad, 0, 4}) >= kEvenQuad;
    const bool can_go = cross(b - a, d - a) > 0, can_come = cross(c - a, d - a) > 0;
    if (!is_quad && !can_go && !can_come) return false;
    const bool goes =
        is_quad || (can_go && (!can_come || glm::distance(b, d) <= glm::distance(a, c)));
    const bool comes = is_quad || !goes;
    Part piece{from};
    if (goes) piece.push_back(next);
    if (comes) piece.push_back(last);
    piece.push_back(to);
    if (goes) from = next;
    if (comes) to = last;
    left -= piece.size() - 2;
    if (!take(std::move(piece), from, to)) return false;
  }
  return true;
}

// Of the row from there, all its diagonals; infinite where it does not come to the end.
double row_length(std::span<const dvec2> polygon, std::size_t start) {
  double length = 0;
  const bool ends = cut_in_row(polygon, start, [&](const Part&, std::size_t from, std::size_t to) {
    length += glm::distance(polygon[from], polygon[to]);
    return true;
  });
  return ends ? length : kNone;
}

// The shortest row of some; what can't be cut stays one part.
std::vector<Part> in_row(std::span<const dvec2> polygon,
                         const std::function<bool(std::size_t, std::size_t)>& may_cut) {
  const std::size_t n = polygon.size();
  std::vector<std::size_t> starts = long_sides(polygon);
  add_spread(n, kStarts, starts);
  std::vector<double> lengths;
  for (const std::size_t start : starts) lengths.push_back(row_length(polygon, start));
  const std::size_t start =
      starts[std::min_element(lengths.begin(), lengths.end()) - lengths.begin()];
  std::vector<Part> parts;
  std::size_t left_from = (start + 1) % n, left_to = start;
  const auto take = [&](Part&& piece, std::size_t from, std::size_t to) {
    const std::size_t apart = (to + n - from) % n;
    if (apart > 1 && !may_cut(from, to)) return false;
    parts.push_back(std::move(piece));
    left_from = from;
    left_to = to;
    return true;
  };
  if (!cut_in_row(polygon, start, take)) {
    Part& rest = parts.emplace_back();
    for (std::size_t i = left_from; i != left_to; i = (i + 1) % n) rest.push_back(i);
    rest.push_back(left_to);
  }
  return parts;
}

}  // namespace

double corner_swirl(std::span<const dvec2> polygon) {
  const auto n = static_cast<double>(polygon.size());
  const double step = 2 * std::numbers::pi / n;
  dvec2 mean(0.0), even(0.0), odd(0.0);
  for (const dvec2& p : polygon) mean += p / n;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    even += portable::cos(angle) * (polygon[i] - mean);
    odd += portable::sin(angle) * (polygon[i] - mean);
  }
  const double area = cross(even, odd);
  if (!(area > 0)) return n / 2;
  double most = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    const dvec2 own = polygon[i] - mean;
    const dvec2 place = dvec2(cross(own, odd), cross(even, own)) / area;
    const dvec2 wanted(portable::cos(angle), portable::sin(angle));
    most = std::max(most, std::abs(portable::atan2(cross(wanted, place), glm::dot(wanted, place))));
  }
  return most / step;
}

std::vector<std::vector<std::size_t>> even_parts(
    std::span<const dvec2> places, std::vector<std::size_t> part,
    const std::function<bool(std::size_t, std::size_t)>& may_cut) {
  std::vector<Part> open, done;
  open.push_back(std::move(part));
  std::vector<dvec2> polygon;
  while (!open.empty()) {
    Part own = std::move(open.back());
    open.pop_back();
    polygon.clear();
    for (const std::size_t corner : own) polygon.push_back(places[corner]);
    if (own.size() <= 4 || corner_swirl(polygon) <= kMostSwirl) {
      done.push_back(std::move(own));
      continue;
    }
    const auto may = [&](std::size_t a, std::size_t b) { return may_cut(own[a], own[b]); };
    const std::vector<Chord> chords = good_chords(polygon);
    const auto chord =
        std::ranges::find_if(chords, [&](const Chord& c) { return may(c.from, c.to); });
    if (chord == chords.end()) {
      for (Part& piece : in_row(polygon, may)) {
        for (std::size_t& corner : piece) corner = own[corner];
        done.push_back(std::move(piece));
      }
      continue;
    }
    const auto from = own.begin() + static_cast<std::ptrdiff_t>(chord->from);
    const auto to = own.begin() + static_cast<std::ptrdiff_t>(chord->to);
    open.emplace_back(from, to + 1);
    Part& rest = open.emplace_back(to, own.end());
    rest.insert(rest.end(), own.begin(), from + 1);
  }
  return done;
}

namespace {

using glm::dvec3;
using std::numbers::pi;

// Corners may turn inward by this angle: merged and meshed faces are rarely flat to the last digit.
constexpr double kStraight = 0.05;
// A finely drawn arc turns inward by less at each corner, but may by so much in all.
constexpr double kStraightInAll = 0.1;
// Of larger faces good diagonals are not searched for one by one, which takes time of the order of
// their square, and leaves slivers between those that it takes first.
constexpr std::size_t kMostCorners = 32;

// From a to b counter-clockwise, 0 to a full turn.
double turn_between(const dvec2& a, const dvec2& b) {
  const double angle = portable::atan2(cross(a, b), glm::dot(a, b));
  return angle < 0 ? angle + 2 * pi : angle;
}

std::vector<dvec2> flat_points(const PolygonMesh& mesh, std::int32_t face) {
  const auto vertices = mesh.face(face);
  std::vector<dvec2> points(vertices.size(), dvec2(0.0));
  const dvec3 area = area_vector(mesh.positions, vertices);
  const double size = glm::length(area);
  if (!(size > 0)) return points;
  const dvec3 normal = area / size;
  // Along the axis that the normal is farthest from.
  const dvec3 bent = glm::abs(normal);
  const bool x_is_least = bent.x <= bent.y && bent.x <= bent.z;
  const dvec3 axis = x_is_least         ? dvec3(1, 0, 0)
                     : bent.y <= bent.z ? dvec3(0, 1, 0)
                                        : dvec3(0, 0, 1);
  const dvec3 first = glm::normalize(glm::cross(axis, normal)), second = glm::cross(normal, first);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const dvec3 p = mesh.positions[vertices[i]] - mesh.positions[vertices[0]];
    points[i] = {glm::dot(p, first), glm::dot(p, second)};
  }
  return points;
}

double interior_angle(std::span<const dvec2> points, const Part& part, std::size_t i) {
  const std::size_t m = part.size();
  const dvec2& own = points[part[i]];
  return turn_between(points[part[(i + 1) % m]] - own, points[part[(i + m - 1) % m]] - own);
}

Part whole_face(std::size_t corners) {
  Part part(corners);
  std::iota(part.begin(), part.end(), 0);
  return part;
}

// The widest angle that each corner of a face may have: corners that turn inward a little may,
// until those since the last one that may not do by too much together.
std::vector<double> allowed_angles(std::span<const dvec2> points) {
  const std::size_t m = points.size();
  const Part face = whole_face(m);
  std::vector<double> turns(m);  // inward
  for (std::size_t i = 0; i < m; ++i) turns[i] = interior_angle(points, face, i) - pi;
  std::vector<double> allowed(m, pi + kStraight);
  const auto start =
      static_cast<std::size_t>(std::min_element(turns.begin(), turns.end()) - turns.begin());
  double in_all = 0;
  for (std::size_t k = 0; k < m; ++k) {
    const std::size_t i = (start + k) % m;
    in_all = turns[i] > kStraight ? 0 : std::max(in_all + turns[i], 0.0);
    if (in_all <= kStraightInAll) continue;
    allowed[i] = pi;
    in_all = 0;
  }
  return allowed;
}

// The corner with the widest angle of those that may not have theirs; the part's size where there
// is none.
std::size_t worst_corner(std::span<const dvec2> points, std::span<const double> allowed,
                         const Part& part) {
  constexpr double kRounding = 1e-9;
  std::size_t worst = part.size();
  double largest = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double angle = interior_angle(points, part, i);
    if (angle > allowed[part[i]] + kRounding && angle > largest) {
      largest = angle;
      worst = i;
    }
  }
  return worst;
}

// Whether the segment between corners i and j meets an edge of the part that ends at neither.
bool meets_an_edge(std::span<const dvec2> points, const Part& part, std::size_t i, std::size_t j) {
  const std::size_t m = part.size();
  count_work(Work::Pairs, static_cast<std::int64_t>(m));
  const dvec2& start = points[part[i]];
  const dvec2 way = points[part[j]] - start;
  for (std::size_t e = 0; e < m; ++e) {
    const std::size_t next = (e + 1) % m;
    if (e == i || e == j || next == i || next == j) continue;
    const dvec2 a = points[part[e]], edge = points[part[next]] - a;
    const bool parts_edge = cross(way, a - start) * cross(way, a + edge - start) <= 0;
    const bool parts_way = cross(edge, start - a) * cross(edge, start + way - a) <= 0;
    if (parts_edge && parts_way) return true;
  }
  return false;
}

// How good the diagonal from corner i to corner j is; below every number where it leaves the part.
// Good ones leave wide angles, none of which is nearly straight, and are short.
double merit(std::span<const dvec2> points, const Part& part, std::size_t i, std::size_t j) {
  constexpr double kWorst = -std::numeric_limits<double>::infinity();
  constexpr double kNearlyStraight = 0.9 * pi, kStraightCost = 3.0, kLengthCost = 0.2;
  const std::size_t m = part.size();
  const dvec2& from = points[part[i]];
  const dvec2& to = points[part[j]];
  const dvec2 along = points[part[(i + 1) % m]] - from;
  const double before = turn_between(along, to - from);
  const double after = interior_angle(points, part, i) - before;
  const double far_after = turn_between(points[part[(j + 1) % m]] - to, from - to);
  const double far_before = interior_angle(points, part, j) - far_after;
  const double least = std::min({before, after, far_before, far_after});
  if (!(least > 0) || !(glm::length(along) > 0)) return kWorst;
  const double straightest = std::max({before, after, kNearlyStraight}) - kNearlyStraight;
  return least - kStraightCost * straightest -
         kLengthCost * glm::distance(from, to) / glm::length(along);
}

// Cuts faces one after another.
class Cutter {
 public:
  // `faces`: those that will be cut.
  Cutter(const PolygonMesh& mesh, std::span<const std::int32_t> faces) : mesh_(mesh) {
    std::vector<bool> is_theirs(static_cast<std::size_t>(mesh.vertex_count()));
    for (const std::int32_t f : faces)
      for (const std::int32_t v : mesh.face(f)) is_theirs[v] = true;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto vertices = mesh.face(f);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const std::int32_t own = vertices[i], next = vertices[(i + 1) % vertices.size()];
        if (is_theirs[own] && is_theirs[next]) edges_.insert(std::minmax(own, next));
      }
    }
  }

  // The parts of a face; some may still be concave, and `clean` is then false.
  std::vector<Part> cut(std::int32_t face, bool& clean) {
    const std::vector<dvec2> points = flat_points(mesh_, face);
    const std::vector<double> allowed = allowed_angles(points);
    return points.size() > kMostCorners ? cut_large(face, points, allowed, clean)
                                        : cut_small(face, points, allowed, clean);
  }

 private:
  std::vector<Part> cut_small(std::int32_t face, std::span<const dvec2> points,
                              std::span<const double> allowed, bool& clean) {
    std::vector<Part> open{whole_face(points.size())}, done;
    while (!open.empty()) {
      const Part part = std::move(open.back());
      open.pop_back();
      const std::size_t i = worst_corner(points, allowed, part);
      const std::size_t j = i == part.size() ? i : other_end(face, points, part, i);
      if (j == i) {
        clean = clean && i == part.size();
        done.push_back(part);
        continue;
      }
      edges_.insert(vertices_of(face, part[i], part[j]));
      for (const auto& [first, last] : {std::pair(i, j), std::pair(j, i)}) {
        Part piece;
        for (std::size_t k = first;; k = (k + 1) % part.size()) {
          piece.push_back(part[k]);
          if (k == last) break;
        }
        open.push_back(std::move(piece));
      }
    }
    return done;
  }

  [[nodiscard]] std::pair<std::int32_t, std::int32_t> vertices_of(std::int32_t face, std::size_t a,
                                                                  std::size_t b) const {
    return std::minmax(mesh_.face(face)[a], mesh_.face(face)[b]);
  }

  std::vector<Part> cut_large(std::int32_t face, std::span<const dvec2> points,
                              std::span<const double> allowed, bool& clean) {
    const auto may_cut = [&](std::size_t a, std::size_t b) {
      return edges_.insert(vertices_of(face, a, b)).second;
    };
    std::vector<Part> parts;
    for (Part& part : convex_parts(points, allowed, may_cut)) {
      clean = clean && worst_corner(points, allowed, part) == part.size();
      std::ranges::move(even_parts(points, std::move(part), may_cut), std::back_inserter(parts));
    }
    for (Part& part : parts) std::ranges::rotate(part, std::ranges::min_element(part));
    std::ranges::sort(parts);
    return parts;
  }

  // The best corner to cut to from corner i; i where there is none.
  [[nodiscard]] std::size_t other_end(std::int32_t face, std::span<const dvec2> points,
                                      const Part& part, std::size_t i) const {
    std::vector<std::pair<double, std::size_t>> candidates;
    for (std::size_t k = 2; k + 1 < part.size(); ++k) {
      const std::size_t j = (i + k) % part.size();
      const double value = merit(points, part, i, j);
      if (std::isfinite(value)) candidates.emplace_back(-value, j);
    }
    std::sort(candidates.begin(), candidates.end());
    for (const auto& [cost, j] : candidates) {
      if (edges_.contains(vertices_of(face, part[i], part[j]))) continue;
      if (!meets_an_edge(points, part, i, j)) return j;
    }
    return i;
  }

  const PolygonMesh& mesh_;
  std::set<std::pair<std::int32_t, std::int32_t>> edges_;
};

// Appends a part of a face with what rides on its corners.
void add_part(const PolygonMesh& source, std::int32_t face, const Part& part, ConvexMesh& result) {
  PolygonMesh& mesh = result.mesh;
  const std::int32_t first = source.face_offsets[face];
  for (const std::size_t place : part) {
    const auto corner = first + static_cast<std::int32_t>(place);
    mesh.face_vertices.push_back(source.face_vertices[corner]);
    if (!source.face_uvs.empty()) mesh.face_uvs.push_back(source.face_uvs[corner]);
  }
  mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
  if (!source.face_groups.empty()) mesh.face_groups.push_back(source.face_groups[face]);
  result.source_faces.push_back(face);
}

// Whether any corner turns inward at all: most faces need no closer look.
bool may_be_concave(const PolygonMesh& mesh, std::int32_t face) {
  const auto vertices = mesh.face(face);
  const dvec3 area = area_vector(mesh.positions, vertices);
  const std::size_t m = vertices.size();
  for (std::size_t i = 0; m > 3 && i < m; ++i) {
    const dvec3& own = mesh.positions[vertices[i]];
    const dvec3 turn = glm::cross(mesh.positions[vertices[(i + 1) % m]] - own,
                                  mesh.positions[vertices[(i + m - 1) % m]] - own);
    if (glm::dot(turn, area) < 0) return true;
  }
  return false;
}

bool is_concave(const PolygonMesh& mesh, std::int32_t face) {
  if (!may_be_concave(mesh, face)) return false;
  const std::vector<dvec2> points = flat_points(mesh, face);
  const Part part = whole_face(points.size());
  return worst_corner(points, allowed_angles(points), part) < part.size();
}

bool is_uneven(const PolygonMesh& mesh, std::int32_t face) {
  return mesh.face(face).size() > kMostCorners &&
         corner_swirl(flat_points(mesh, face)) > kMostSwirl;
}

template <class Is>
std::vector<std::int32_t> faces_that(const PolygonMesh& mesh, const Is& is) {
  require_sound_indices(arrays_of(mesh), "mesh", ErrorCode::UnusableMesh);
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (is(f)) faces.push_back(f);
  return faces;
}

}  // namespace

std::vector<std::int32_t> concave_faces(const PolygonMesh& mesh) {
  return faces_that(mesh, [&](std::int32_t f) { return is_concave(mesh, f); });
}

ConvexMesh with_convex_faces(const PolygonMesh& mesh) {
  ConvexMesh result{mesh, {}, {}, {}};
  const std::vector<std::int32_t> bad =
      faces_that(mesh, [&](std::int32_t f) { return is_uneven(mesh, f) || is_concave(mesh, f); });
  if (bad.empty()) {
    result.source_faces.resize(static_cast<std::size_t>(mesh.face_count()));
    std::iota(result.source_faces.begin(), result.source_faces.end(), 0);
    return result;
  }
  PolygonMesh& cut = result.mesh;
  cut.face_offsets = {0};
  for (auto* const corners : {&cut.face_vertices, &cut.face_uvs, &cut.face_groups})
    corners->clear();
  cut.hole_faces.clear();
  const std::set<std::int32_t> holes(mesh.hole_faces.begin(), mesh.hole_faces.end());
  Cutter cutter(mesh, bad);
  auto next = bad.begin();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Part> parts;
    if (next != bad.end() && *next == f) {
      ++next;
      bool clean = true;
      parts = cutter.cut(f, clean);
      if (parts.size() > 1) result.cut_faces.push_back(f);
      if (!clean) result.concave_faces.push_back(f);
    } else {
      parts.push_back(whole_face(static_cast<std::size_t>(mesh.face_size(f))));
    }
    for (const Part& part : parts) {
      if (holes.contains(f)) cut.hole_faces.push_back(cut.face_count());
      add_part(mesh, f, part, result);
    }
  }
  return result;
}

}  // namespace planish
