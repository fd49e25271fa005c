#include "planish/mesh/even_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "planish/core/work.h"
#include "planish/mesh/plane.h"

namespace planish {
namespace {

using glm::dvec2;
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
    even += std::cos(angle) * (polygon[i] - mean);
    odd += std::sin(angle) * (polygon[i] - mean);
  }
  const double area = cross(even, odd);
  if (!(area > 0)) return n / 2;
  double most = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    const dvec2 own = polygon[i] - mean;
    const dvec2 place = dvec2(cross(own, odd), cross(even, own)) / area;
    const dvec2 wanted(std::cos(angle), std::sin(angle));
    most = std::max(most, std::abs(std::atan2(cross(wanted, place), glm::dot(wanted, place))));
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

}  // namespace planish
