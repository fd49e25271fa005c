#include "planish/features/jumps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

// Of a face's longest edge squared: with less area its normal is rounding.
constexpr double kSliver = 1e-6;
// Faces of no plane are parted at a turn of an eighth, three times.
constexpr int kPartings = 4;
constexpr double kNoPlane = std::numeric_limits<double>::infinity();
constexpr double kFiner = 0.125;
// Of a dodecahedron, whose edges turn by as much as a hexagon's corners.
constexpr double kPolyhedron = 12;

class RegionMaker {
 public:
  RegionMaker(const PolygonMesh& mesh, const MeshTopology& topology, const FeatureRules& rules)
      : mesh_(mesh), topology_(topology), rules_(rules) {}

  [[nodiscard]] RegionMap make(double least_share) {
    measure_faces();
    if (!measure_turns() && mesh_.creases.empty() && mesh_.corners.empty()) return {};
    unite_faces();
    measure_regions();
    if (std::ranges::none_of(map_.regions,
                             [&](const Region& region) { return region.share >= least_share; }))
      return {};
    make_segments();
    map_.outlines = group_by<std::int32_t>(map_.regions.size(), [&](const auto& take) {
      for (std::size_t s = 0; s < map_.segments.size(); ++s)
        for (const std::int32_t region : map_.segments[s].regions)
          if (region >= 0) take(region, static_cast<std::int32_t>(s));
    });
    return std::move(map_);
  }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  const FeatureRules& rules_;
  std::vector<glm::dvec3> areas_;  // vectors
  std::vector<double> bends_;      // by edge: bend_of() both faces
  RegionMap map_;

  [[nodiscard]] glm::dvec3 at(std::int32_t vertex) const { return mesh_.positions[vertex]; }

  [[nodiscard]] double length_of(std::int32_t corner) const {
    return glm::distance(at(topology_.vertex_of(corner)),
                         at(topology_.vertex_of(topology_.next(corner))));
  }

  // A face without area lies in the plane of that across its longest side.
  void measure_faces() {
    const auto count = static_cast<std::size_t>(topology_.face_count());
    areas_.resize(count);
    std::vector<std::int32_t> sliver(count, -1);
    parallel_each(count, [&](std::size_t f) {
      const auto face = static_cast<std::int32_t>(f);
      areas_[f] = area_vector(mesh_.positions, topology_.face(face));
      std::int32_t longest = topology_.first_corner(face);
      for (int i = 1; i < topology_.face_size(face); ++i) {
        const std::int32_t corner = topology_.first_corner(face) + i;
        if (length_of(corner) > length_of(longest)) longest = corner;
      }
      const double length = length_of(longest);
      if (glm::length(areas_[f]) <= kSliver * length * length) sliver[f] = longest;
    });
    for (std::size_t f = 0; f < count; ++f) {
      if (sliver[f] < 0) continue;
      const std::int32_t twin = topology_.twin(sliver[f]);
      const std::int32_t other = twin < 0 ? -1 : topology_.face_of(twin);
      const double own = glm::length(areas_[f]);
      areas_[f] =
          other < 0 || sliver[other] >= 0 ? glm::dvec3(0.0) : own * unit_or_zero(areas_[other]);
    }
  }

  // The squared tangent of a turn: as good as the angle, for a tenth of the time.
  [[nodiscard]] static double bend_of(const glm::dvec3& a, const glm::dvec3& b) {
    const double cosine = glm::dot(a, b);
    const glm::dvec3 sine = glm::cross(a, b);
    const double square = glm::dot(sine, sine);
    if (!(cosine > 0)) return square > 0 || cosine < 0 ? kNoPlane : 0;
    return square / (cosine * cosine);
  }
  [[nodiscard]] static double bend_by(double degrees) {
    const double tangent = portable::tan(glm::radians(degrees));
    return tangent * tangent;
  }

  // Whether any edge turns, or is at a boundary.
  [[nodiscard]] bool measure_turns() {
    bends_.resize(topology_.edge_count());
    const double flat = bend_by(rules_.flat);
    std::atomic<bool> has = false;
    parallel_each(bends_.size(), [&](std::size_t e) {
      const std::int32_t corner = topology_.corner_of(static_cast<std::int32_t>(e));
      const std::int32_t twin = topology_.twin(corner);
      bends_[e] = twin < 0
                      ? kNoPlane
                      : bend_of(areas_[topology_.face_of(corner)], areas_[topology_.face_of(twin)]);
      if (bends_[e] >= flat) has.store(true, std::memory_order_relaxed);
    });
    return has;
  }

  // By turns below `flat`; sets that are no plane by smaller ones, until single faces are left.
  void unite_faces() {
    const std::int32_t count = topology_.face_count();
    std::vector<std::int32_t> set_of(count), open(count);
    for (std::int32_t f = 0; f < count; ++f) set_of[f] = open[f] = f;
    std::vector<char> is_open(count, 1);
    std::vector<glm::dvec3> sums(count);
    std::vector<double> most(count);
    double degrees = rules_.flat;
    for (int parting = 0; parting < kPartings && !open.empty(); ++parting, degrees *= kFiner) {
      const double flat = bend_by(degrees);
      DisjointSets sets(count);
      for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
        if (bends_[e] >= flat) continue;
        const std::int32_t a = topology_.face_of(topology_.corner_of(e));
        const std::int32_t b = topology_.face_of(topology_.twin(topology_.corner_of(e)));
        if (is_open[a] && is_open[b]) sets.unite(a, b);
      }
      for (const std::int32_t f : open) {
        sums[f] = glm::dvec3(0.0);
        most[f] = 0;
      }
      for (const std::int32_t f : open) sums[sets.find(f)] += areas_[f];
      for (const std::int32_t f : open) {
        double& widest = most[sets.find(f)];
        widest = std::max(widest, bend_of(sums[sets.find(f)], areas_[f]));
      }
      const double plane = bend_by(rules_.flat);
      std::erase_if(open, [&](std::int32_t f) {
        if (most[sets.find(f)] > plane) return false;
        set_of[f] = sets.find(f);
        is_open[f] = 0;
        return true;
      });
    }
    number_regions(set_of);
  }

  void number_regions(const std::vector<std::int32_t>& set_of) {
    std::vector<std::int32_t> number(set_of.size(), -1);
    map_.region_of_face.resize(set_of.size());
    std::int32_t regions = 0;
    for (std::size_t f = 0; f < set_of.size(); ++f) {
      std::int32_t& region = number[set_of[f]];
      if (region < 0) region = regions++;
      map_.region_of_face[f] = region;
    }
    map_.regions.resize(regions);
  }

  void measure_regions() {
    std::vector<glm::dvec3> sums(map_.regions.size(), glm::dvec3(0.0));
    std::vector<std::int32_t> faces(map_.regions.size(), 0);
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      Region& region = map_.regions[map_.region_of_face[f]];
      const std::span<const std::int32_t> corners = topology_.face(f);
      glm::dvec3 middle(0.0);
      for (const std::int32_t v : corners) middle += at(v);
      middle /= static_cast<double>(corners.size());
      const double area = glm::length(areas_[f]);
      region.normal += areas_[f];
      region.area += area;
      region.centre += area * middle;
      sums[map_.region_of_face[f]] += middle;
      ++faces[map_.region_of_face[f]];
    }
    for (std::size_t r = 0; r < map_.regions.size(); ++r) {
      Region& region = map_.regions[r];
      region.normal = unit_or_zero(region.normal);
      region.centre = region.area > 0 ? region.centre / region.area : sums[r] / double(faces[r]);
    }
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      Region& region = map_.regions[map_.region_of_face[f]];
      for (const std::int32_t v : topology_.face(f))
        region.warp =
            std::max(region.warp, std::abs(glm::dot(at(v) - region.centre, region.normal)));
    }
    const std::vector<double> parts = part_areas();
    for (std::size_t r = 0; r < map_.regions.size(); ++r) {
      Region& region = map_.regions[r];
      const double size = std::sqrt(region.area);
      // A square whose corners are off by h, two up and two down, bends by 4 h over its side.
      region.warp = size > 0 ? glm::degrees(4 * region.warp / size) : 0;
      region.share = parts[r] > 0 ? size / std::sqrt(parts[r]) : 0;
      region.facet = std::max(0.0, 1 - kPolyhedron * region.share * region.share);
    }
  }

  // By region: the area of the connected part that it is of.
  [[nodiscard]] std::vector<double> part_areas() const {
    DisjointSets parts(map_.regions.size());
    for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
      const auto [a, b] = regions_of(e);
      if (b >= 0) parts.unite(a, b);
    }
    std::vector<double> sums(map_.regions.size(), 0.0), areas(map_.regions.size());
    for (std::size_t r = 0; r < sums.size(); ++r)
      sums[parts.find(static_cast<std::int32_t>(r))] += map_.regions[r].area;
    for (std::size_t r = 0; r < sums.size(); ++r)
      areas[r] = sums[parts.find(static_cast<std::int32_t>(r))];
    return areas;
  }

  [[nodiscard]] std::pair<std::int32_t, std::int32_t> regions_of(std::int32_t edge) const {
    const std::int32_t corner = topology_.corner_of(edge), twin = topology_.twin(corner);
    return {map_.region_of_face[topology_.face_of(corner)],
            twin < 0 ? -1 : map_.region_of_face[topology_.face_of(twin)]};
  }

  [[nodiscard]] std::vector<char> tagged_edges() const {
    std::vector<char> is_tagged(topology_.edge_count(), 0);
    for (const CreaseEdge& crease : mesh_.creases) {
      const std::int32_t edge = topology_.find_edge(crease.v0, crease.v1);
      if (edge >= 0 && crease.sharpness > 0) is_tagged[edge] = 1;
    }
    return is_tagged;
  }

  void make_segments() {
    const std::int32_t count = topology_.edge_count();
    const std::vector<char> is_tagged = tagged_edges();
    std::vector<char> is_line(count);
    for (std::int32_t e = 0; e < count; ++e) {
      const auto [a, b] = regions_of(e);
      is_line[e] = a != b;
    }
    DisjointSets sets(count);
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) {
      const auto [e, f] = two_lines_at(v, is_line);
      if (e >= 0 && f >= 0 && is_tagged[e] == is_tagged[f] && go_on(e, f, v)) sets.unite(e, f);
    }
    map_.segment_of_edge.assign(count, -1);
    map_.segments.reserve(static_cast<std::size_t>(std::ranges::count(is_line, 1)));
    for (std::int32_t e = 0; e < count; ++e) {
      if (!is_line[e]) continue;
      std::int32_t& segment = map_.segment_of_edge[sets.find(e)];
      if (segment < 0) {
        segment = static_cast<std::int32_t>(map_.segments.size());
        map_.segments.emplace_back();
      }
      map_.segment_of_edge[e] = segment;
      map_.segments[segment].is_tagged = is_tagged[e];
      add_edge(map_.segments[segment], e);
    }
    parallel_each(map_.segments.size(), [&](std::size_t s) { finish(map_.segments[s]); });
  }

  // The edges at a vertex that are lines, if they are two, else -1.
  [[nodiscard]] std::pair<std::int32_t, std::int32_t> two_lines_at(
      std::int32_t v, const std::vector<char>& is_line) const {
    std::pair<std::int32_t, std::int32_t> found{-1, -1};
    const auto add = [&](std::int32_t edge) {
      if (!is_line[edge]) return true;
      if (found.second >= 0) return false;
      (found.first < 0 ? found.first : found.second) = edge;
      return true;
    };
    for (const std::int32_t corner : topology_.corners_at(v)) {
      if (!add(topology_.edge_of(corner))) return {-1, -1};
      if (topology_.ccw(corner) < 0 && !add(topology_.edge_of(topology_.prev(corner))))
        return {-1, -1};
    }
    return found;
  }

  // Whether two edges at a vertex are one straight line between the same regions.
  [[nodiscard]] bool go_on(std::int32_t e, std::int32_t f, std::int32_t v) const {
    const auto [a, b] = regions_of(e);
    const auto [c, d] = regions_of(f);
    if (std::pair(std::min(a, b), std::max(a, b)) != std::pair(std::min(c, d), std::max(c, d)))
      return false;
    const auto other = [&](std::int32_t edge) {
      const auto [v0, v1] = topology_.edge_vertices(edge);
      return at(v0 == v ? v1 : v0);
    };
    return degrees_between(at(v) - other(e), other(f) - at(v)) < rules_.flat;
  }

  void add_edge(Segment& segment, std::int32_t edge) {
    const auto [a, b] = topology_.edge_vertices(edge);
    const auto [left, right] = regions_of(edge);
    if (segment.length == 0 && segment.regions[0] < 0) segment.regions = {left, right};
    const glm::dvec3 way = at(b) - at(a);
    const double length = glm::length(way);
    segment.along += left == segment.regions[0] ? way : -way;
    segment.middle += length * (at(a) + at(b)) / 2.0;
    segment.length += length;
    if (length == 0) segment.middle = at(a);
  }

  void finish(Segment& segment) const {
    segment.along = unit_or_zero(segment.along);
    if (segment.length > 0) segment.middle /= segment.length;
    if (segment.regions[1] < 0) return;
    const glm::dvec3 &a = map_.regions[segment.regions[0]].normal,
                     &b = map_.regions[segment.regions[1]].normal;
    const double turn = degrees_between(a, b);
    segment.turn = glm::dot(glm::cross(a, b), segment.along) < 0 ? -turn : turn;
  }
};

}  // namespace

glm::dvec3 RegionMap::inward(std::int32_t segment, std::int32_t region) const {
  const Segment& line = segments[segment];
  const glm::dvec3 left = glm::cross(regions[region].normal, line.along);
  return unit_or_zero(line.regions[0] == region ? left : -left);
}

RegionMap make_regions(const PolygonMesh& mesh, const MeshTopology& topology,
                       const FeatureRules& rules, double least_share) {
  return RegionMaker(mesh, topology, rules).make(least_share);
}

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
  std::ranges::stable_sort(samples, {}, &Sample::ratio);
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
    const double turn = sign * glm::degrees(portable::atan2(glm::dot(there.normal, away),
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
    result.scale = portable::hypot(rules_.jump, rules_.spread * (left.spread + right.spread));
  return result;
}

}  // namespace planish
