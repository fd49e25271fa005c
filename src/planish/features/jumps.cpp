#include "planish/features/jumps.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "planish/core/parallel.h"
#include "planish/mesh/plane.h"

namespace planish {
namespace {

// Of a length: places nearer to each other are one.
constexpr double kSame = 1e-6;
// Segments of a region up to which each is compared with each.
constexpr std::size_t kFew = 16;
// Regions with more segments have no ring that a fit could look at.
constexpr std::size_t kLargestRing = 12;
// Of a turn: a line that turns by less, as the diagonal of a twisted quad, is looked through.
constexpr double kLittle = 0.1;

struct Line {
  glm::dvec2 middle, half;
  std::int32_t segment;
};

struct Hit {
  double distance = 0, cosine = 0;
  std::int32_t line = -1;
};

// The lines of a region in its plane, sorted into cells, of which a ray visits some.
class LineGrid {
 public:
  explicit LineGrid(std::vector<Line> lines) : lines_(std::move(lines)) {
    lower_ = upper_ = lines_.front().middle;
    for (const Line& line : lines_) {
      const glm::dvec2 reach = glm::abs(line.half);
      lower_ = glm::min(lower_, line.middle - reach);
      upper_ = glm::max(upper_, line.middle + reach);
    }
    const glm::dvec2 size = upper_ - lower_;
    const double widest = std::max(size.x, size.y);
    const bool is_one = lines_.size() <= kFew || !(widest > 0);
    const double cells = is_one ? 1 : std::ceil(std::sqrt(static_cast<double>(lines_.size())));
    cell_ = widest > 0 ? widest / cells * (1 + kSame) : 1;
    columns_ = static_cast<int>(size.x / cell_) + 1;
    rows_ = static_cast<int>(size.y / cell_) + 1;
    in_cell_ =
        group_by<std::int32_t>(static_cast<std::size_t>(columns_) * rows_, [&](const auto& take) {
          for (std::size_t i = 0; i < lines_.size(); ++i)
            visit_box(lines_[i],
                      [&](std::size_t cell) { take(cell, static_cast<std::int32_t>(i)); });
        });
  }

  [[nodiscard]] const std::vector<Line>& lines() const { return lines_; }

  // What a ray from the middle of a line meets first: of several at one place the most parallel.
  [[nodiscard]] Hit first_hit(std::int32_t from, const glm::dvec2& way) const {
    Hit best;
    const glm::dvec2 start = lines_[from].middle;
    glm::ivec2 cell(column(start.x), row(start.y));
    for (;;) {
      for (const std::int32_t i : in_cell_.of(static_cast<std::size_t>(cell.y) * columns_ + cell.x))
        if (i != from) take_hit(from, i, way, best);
      const double x = leaves(start.x - lower_.x, way.x, cell.x);
      const double y = leaves(start.y - lower_.y, way.y, cell.y);
      // What was met in this cell is the first; at its border the next one may have another.
      if (best.line >= 0 && best.distance * (1 + kSame) < std::min(x, y)) return best;
      if (x < y)
        cell.x += way.x > 0 ? 1 : -1;
      else
        cell.y += way.y > 0 ? 1 : -1;
      if (cell.x < 0 || cell.y < 0 || cell.x >= columns_ || cell.y >= rows_) return best;
    }
  }

 private:
  std::vector<Line> lines_;
  glm::dvec2 lower_{0.0}, upper_{0.0};
  double cell_ = 1;
  int columns_ = 1, rows_ = 1;
  Groups<std::int32_t> in_cell_;

  [[nodiscard]] int column(double x) const {
    return std::clamp(static_cast<int>((x - lower_.x) / cell_), 0, columns_ - 1);
  }
  [[nodiscard]] int row(double y) const {
    return std::clamp(static_cast<int>((y - lower_.y) / cell_), 0, rows_ - 1);
  }

  // Long lines are walked along, so that each is in few cells.
  template <class Visit>
  void visit_box(const Line& line, const Visit& visit) const {
    const int steps = 1 + static_cast<int>(2 * glm::length(line.half) / cell_);
    const double slack = kSame * cell_;
    std::size_t last = static_cast<std::size_t>(-1);
    for (int s = 0; s < steps; ++s) {
      const glm::dvec2 a = line.middle + (2.0 * s / steps - 1) * line.half;
      const glm::dvec2 b = line.middle + (2.0 * (s + 1) / steps - 1) * line.half;
      for (int y = row(std::min(a.y, b.y) - slack); y <= row(std::max(a.y, b.y) + slack); ++y) {
        for (int x = column(std::min(a.x, b.x) - slack); x <= column(std::max(a.x, b.x) + slack);
             ++x) {
          const std::size_t cell = static_cast<std::size_t>(y) * columns_ + x;
          if (cell != last) visit(cell);
          last = cell;
        }
      }
    }
  }

  [[nodiscard]] double leaves(double at, double way, int cell) const {
    if (way == 0) return 1e300;
    return ((way > 0 ? cell + 1 : cell) * cell_ - at) / way;
  }

  void take_hit(std::int32_t from, std::int32_t to, const glm::dvec2& way, Hit& best) const {
    const Line &source = lines_[from], &line = lines_[to];
    const double across = cross(way, line.half);
    const double length = glm::length(line.half);
    if (std::abs(across) <= 1e-12 * length) return;
    const glm::dvec2 between = line.middle - source.middle;
    const double distance = cross(between, line.half) / across;
    if (distance <= kSame * glm::length(source.half)) return;
    if (std::abs(cross(between, way) / across) > 1 + kSame) return;
    const double cosine = std::abs(cross(way, line.half)) / length;
    const bool is_nearer = best.line < 0 || distance < best.distance * (1 - kSame);
    const bool is_as_near = best.line >= 0 && distance < best.distance * (1 + kSame);
    if (is_nearer || (is_as_near && cosine > best.cosine)) best = {distance, cosine, to};
  }
};

struct Sample {
  double ratio, weight, distance, turn;
};

// Of the ratios: half of the weights are at or below, half at or above.
double weighted_median(std::vector<Sample>& samples, double weights) {
  std::ranges::sort(samples, {}, &Sample::ratio);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    sum += samples[i].weight;
    if (sum >= weights / 2 * (1 + kSame)) return samples[i].ratio;
    if (sum >= weights / 2 * (1 - kSame)) return (samples[i].ratio + samples[i + 1].ratio) / 2;
  }
  return samples.back().ratio;
}

}  // namespace

double jump_of(double turn, const Explained& left, const Explained& right) {
  return std::max(0.0, std::abs(turn) - left.turn - right.turn);
}

Explained explained_by(double turn, double turn_behind, double width, double width_behind,
                       double width_before, const FeatureRules& rules) {
  double whole = turn_behind / 2;
  if (width_behind > 0) whole = std::min(whole, turn_behind * width / (width + width_behind));
  if (width_before > 0 && width_before <= rules.uneven * width &&
      width_behind > rules.uneven * width) {
    // The turn behind is where the smooth surface ends at a plane: all of it is made on this side,
    // as is half of a turn inside. One that is as large is a chamfer's.
    const double ends = std::clamp(3 - 4 * turn_behind / turn, 0.0, 1.0);
    whole += ends * (turn_behind - whole);
  }
  const double even = width_before > 0 ? std::min(1.0, rules.uneven * width_before / width) : 1.0;
  return {std::min(rules.cap, whole) * even * even, whole * even * even, 0};
}

SegmentJumps::SegmentJumps(const RegionMap& map, const FeatureRules& rules)
    : map_(map), rules_(rules), across_(map.segments.size()) {
  parallel_each(map.regions.size(), 256,
                [&](std::size_t r) { look_across(static_cast<std::int32_t>(r)); });
}

void SegmentJumps::look_across(std::int32_t region) {
  const std::span<const std::int32_t> outline = map_.outlines.of(region);
  if (outline.empty()) return;
  const glm::dvec3 n = map_.regions[region].normal, centre = map_.regions[region].centre;
  if (glm::dot(n, n) == 0) return;
  const glm::dvec3 e1 = glm::normalize(
      glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  const glm::dvec3 e2 = glm::cross(n, e1);
  const auto flat = [&](const glm::dvec3& v) {
    return glm::dvec2(glm::dot(v, e1), glm::dot(v, e2));
  };
  std::vector<Line> lines;
  lines.reserve(outline.size());
  for (const std::int32_t s : outline) {
    const Segment& segment = map_.segments[s];
    lines.push_back({flat(segment.middle - centre), flat(segment.along * (segment.length / 2)), s});
  }
  const LineGrid grid(std::move(lines));
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const std::int32_t s = outline[i];
    const Hit hit = grid.first_hit(static_cast<std::int32_t>(i), flat(map_.inward(s, region)));
    if (hit.line < 0) continue;
    across_[s][side_of(s, region)] = {
        hit.distance, hit.cosine >= rules_.parallel ? grid.lines()[hit.line].segment : -1};
  }
}

bool SegmentJumps::is_plane(std::int32_t region) const {
  const Region& plane = map_.regions[region];
  return plane.warp <= rules_.flat / 8 && plane.share >= rules_.large;
}

bool SegmentJumps::is_told(std::int32_t region) const {
  return is_plane(region) && map_.is_more_than_a_facet(region);
}

bool SegmentJumps::is_between_planes(std::int32_t segment) const {
  const auto& [a, b] = map_.segments[segment].regions;
  return is_told(a) && b >= 0 && is_told(b);
}

Explained SegmentJumps::explained(std::int32_t segment, int side,
                                  std::span<const char> is_sharp) const {
  const std::int32_t region = map_.segments[segment].regions[side];
  const Across& across = across_[segment][side];
  if (map_.outlines.of(region).size() > kLargestRing) return {};
  if (across.segment < 0) return fitted(segment, region, is_sharp);
  Explained result = explained_by_far(segment, side, is_sharp);
  result.spread = map_.regions[region].warp;
  return result;
}

Explained SegmentJumps::explained_by_far(std::int32_t segment, int side,
                                         std::span<const char> is_sharp) const {
  const Segment& line = map_.segments[segment];
  std::int32_t region = line.regions[side];
  Across across = across_[segment][side];
  int behind = 1 - side_of(across.segment, region);
  if (!is_sharp[across.segment] &&
      std::abs(map_.segments[across.segment].turn) < kLittle * std::abs(line.turn)) {
    const Across& next = across_[across.segment][behind];
    if (next.segment >= 0) {
      region = map_.segments[across.segment].regions[behind];
      across = {across.width + next.width, next.segment};
      behind = 1 - side_of(across.segment, region);
    }
  }
  const Segment& far = map_.segments[across.segment];
  if (is_sharp[across.segment]) return {};
  Explained result =
      explained_by(std::abs(line.turn), std::abs(far.turn), across.width,
                   across_[across.segment][behind].width, across_[segment][1 - side].width, rules_);
  if (far.turn * line.turn <= 0) result.turn = 0;
  return result;
}

// The rate at which planes around a region turn about the segment, as one goes away from it: the
// weighted median of two rings.
Explained SegmentJumps::fitted(std::int32_t segment, std::int32_t region,
                               std::span<const char> is_sharp) const {
  const std::span<const std::int32_t> outline = map_.outlines.of(region);
  if (outline.size() > kLargestRing) return {};
  const Region& own = map_.regions[region];
  const Segment& line = map_.segments[segment];
  const glm::dvec3 away = map_.inward(segment, region);
  const double reach = glm::dot(own.centre - line.middle, away);
  const double sign = line.turn < 0 ? -1 : 1;
  const std::int32_t other = map_.beyond(segment, region);
  std::vector<Sample> samples;
  double weights = 0;
  const auto add = [&](std::int32_t r, double weight) {
    const Region& there = map_.regions[r];
    const glm::dvec3 to = there.centre - own.centre;
    const double distance = glm::dot(to, away), length = glm::length(to);
    if (!(distance > std::max(0.0, 0.25 * reach)) || !(length > 0)) return;
    const double turn = sign * glm::degrees(std::atan2(glm::dot(there.normal, away),
                                                       glm::dot(there.normal, own.normal)));
    weight *= distance / length;
    samples.push_back({turn / distance, weight, distance, turn});
    weights += weight;
  };
  for (const std::int32_t f : outline) {
    const std::int32_t near = map_.beyond(f, region);
    if (f == segment || near < 0 || near == other || is_sharp[f]) continue;
    add(near, 1);
    if (map_.outlines.of(near).size() > kLargestRing) continue;
    for (const std::int32_t g : map_.outlines.of(near)) {
      const std::int32_t far = map_.beyond(g, near);
      if (g == f || far < 0 || far == other || far == region || is_sharp[g]) continue;
      add(far, 0.5);
    }
  }
  if (samples.empty()) return {.is_known = false};
  const double rate = weighted_median(samples, weights);
  Explained result;
  for (const Sample& sample : samples)
    result.spread += sample.weight / weights * std::abs(sample.turn - rate * sample.distance);
  result.spread *= own.facet;
  result.whole = std::abs(rate * reach);
  result.turn = std::clamp(rate * reach, 0.0, rules_.cap);
  return result;
}

// Of a facet of a smooth surface the most by which it bends at another of its lines; less where the
// way to that is far longer, or what is beyond far smaller: there the surface changes.
double SegmentJumps::bend_of(std::int32_t segment, int side, std::span<const char> is_sharp) const {
  const std::int32_t region = map_.segments[segment].regions[side];
  const double width = across_[segment][side].width;
  double most = 0;
  for (const std::int32_t s : map_.outlines.of(region)) {
    const std::int32_t beyond = map_.beyond(s, region);
    if (s == segment || s == across_[segment][side].segment || beyond < 0 || is_sharp[s]) continue;
    const double way = glm::distance(map_.segments[s].middle, map_.segments[segment].middle);
    const double size =
        std::min(map_.regions[beyond].share / map_.regions[region].share, width / way);
    const double even = std::min(1.0, rules_.uneven * size);
    most = std::max(most, std::abs(map_.segments[s].turn) / 2 * even * even);
  }
  return most * map_.regions[region].facet;
}

SegmentJumps::Jump SegmentJumps::jump(std::int32_t segment, std::span<const char> is_sharp) const {
  const Segment& line = map_.segments[segment];
  if (line.regions[1] < 0) return {};
  Explained left = explained(segment, 0, is_sharp), right = explained(segment, 1, is_sharp);
  if (!left.is_known) left = right;
  if (!right.is_known) right = left;
  Jump result{jump_of(line.turn, left, right), rules_.jump};
  const auto& [a, b] = line.regions;
  if (is_between_planes(segment)) {
    const double bend = bend_of(segment, 0, is_sharp) + bend_of(segment, 1, is_sharp);
    const double share =
        std::max(left.whole + right.whole, bend) / std::max(std::abs(line.turn), 1e-9);
    result.scale = std::clamp(2 * share * rules_.jump, rules_.flat, rules_.jump);
    return result;
  }
  const auto is_whole = [&](std::int32_t region) {
    return is_plane(region) && map_.outlines.of(region).size() > 4;
  };
  if (!is_whole(a) && !is_whole(b))
    result.scale = std::hypot(rules_.jump, rules_.spread * (left.spread + right.spread));
  return result;
}

}  // namespace planish
