#include "planish/features/regions.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/unit_vector.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/disjoint_sets.h"

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

  [[nodiscard]] RegionMap make() {
    measure_faces();
    if (!measure_turns() && mesh_.creases.empty() && mesh_.corners.empty()) return {};
    unite_faces();
    measure_regions();
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
    const double tangent = std::tan(glm::radians(degrees));
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
                       const FeatureRules& rules) {
  return RegionMaker(mesh, topology, rules).make();
}

}  // namespace planish
