#include "planish/mesh/statistics.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// Elements 0 to count - 1 in sets that can only be united, by any number of threads at once. Which
// sets arise does not depend on the order. Based on: Anderson & Woll, "Wait-free parallel
// algorithms for the union-find problem", 1991.
class ConcurrentSets {
 public:
  explicit ConcurrentSets(std::size_t count) : parents_(count) {
    parallel_each(count, 4096, [&](std::int32_t i) { parents_[i] = i; });
  }

  // False when both were in one set already: true is answered as often as sets vanish.
  bool unite(std::int32_t a, std::int32_t b) {
    while (true) {
      a = find(a);
      b = find(b);
      if (a == b) return false;
      if (a < b) std::swap(a, b);  // roots have the lowest number
      std::int32_t root = a;
      if (place(a).compare_exchange_strong(root, b, std::memory_order_relaxed)) return true;
    }
  }

  // The lowest element of its set, once no thread unites any.
  [[nodiscard]] std::int32_t find(std::int32_t element) {
    std::int32_t parent = place(element).load(std::memory_order_relaxed);
    while (parent != element) {
      // Halves the path; a parent that another thread has changed meanwhile may stay.
      const std::int32_t above = place(parent).load(std::memory_order_relaxed);
      if (above == parent) return parent;
      std::int32_t expected = parent;
      place(element).compare_exchange_weak(expected, above, std::memory_order_relaxed);
      element = above;
      parent = place(element).load(std::memory_order_relaxed);
    }
    return element;
  }

 private:
  [[nodiscard]] std::atomic_ref<std::int32_t> place(std::int32_t element) {
    return std::atomic_ref(parents_[element]);
  }

  RawVector<std::int32_t> parents_;
};

// The area_vector() of every face, on all threads.
std::vector<glm::dvec3> face_areas(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> areas(static_cast<std::size_t>(mesh.face_count()));
  parallel_each(areas.size(),
                [&](std::int32_t f) { areas[f] = area_vector(mesh.positions, mesh.face(f)); });
  return areas;
}

constexpr std::size_t kFoldGrain = 1 << 13;

// The vector areas of all faces, and which pairs of them turn too far.
class FaceAreas {
 public:
  explicit FaceAreas(const PolygonMesh& mesh) : areas_(face_areas(mesh)) {}
  [[nodiscard]] std::size_t count() const { return areas_.size(); }

  [[nodiscard]] bool are_folded(std::int32_t f, std::int32_t g) const {
    static const double least_cosine = portable::cos(kFoldedEdgeDegrees * std::numbers::pi / 180);
    const glm::dvec3 &a = areas_[f], &b = areas_[g];
    const double cosine = glm::dot(a, b);
    // Most edges need no length.
    return cosine < 0 && cosine < least_cosine * glm::length(a) * glm::length(b);
  }

  // The rest of the result once is_beside is known.
  void sum_up(FoldedEdges& result) const {
    double whole = 0;
    for (std::size_t f = 0; f < areas_.size(); ++f) {
      const double area = glm::length(areas_[f]);
      whole += area;
      if (!result.is_beside[f]) continue;
      result.area += area;
      if (result.first_face < 0) result.first_face = static_cast<std::int32_t>(f);
    }
    if (whole > 0) result.area /= whole;
  }

 private:
  RawVector<glm::dvec3> areas_;
};

}  // namespace

FoldedEdges folded_edges(const PolygonMesh& mesh) {
  const FaceAreas faces(mesh);
  FoldedEdges result;
  result.is_beside.assign(faces.count(), 0);
  const std::vector<std::uint8_t> all(faces.count(), 1);
  group_edges(mesh, all).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() < 2 || !faces.are_folded(sides[0].face, sides[1].face)) return;
    ++result.count;
    result.is_beside[sides[0].face] = result.is_beside[sides[1].face] = 1;
  });
  faces.sum_up(result);
  return result;
}

FoldedEdges folded_edges(const PolygonMesh& mesh, const MeshTopology& topology) {
  const FaceAreas faces(mesh);
  FoldedEdges result;
  result.is_beside.assign(faces.count(), 0);
  // Each face looks at its own edges; each edge counts from one side.
  std::vector<std::int64_t> counts((faces.count() + kFoldGrain - 1) / kFoldGrain, 0);
  parallel_for(counts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin * kFoldGrain; f < std::min(faces.count(), end * kFoldGrain); ++f) {
      const auto face = static_cast<std::int32_t>(f);
      const std::int32_t first = topology.first_corner(face);
      for (std::int32_t c = first; c < first + topology.face_size(face); ++c) {
        const std::int32_t twin = topology.twin(c);
        if (twin < 0 || !faces.are_folded(face, topology.face_of(twin))) continue;
        result.is_beside[f] = 1;
        counts[f / kFoldGrain] += c < twin;
      }
    }
  });
  for (const std::int64_t count : counts) result.count += count;
  faces.sum_up(result);
  return result;
}

namespace {

constexpr std::size_t kInsideOutGrain = 1 << 14;
// Of its box: a closed part of less volume is a sheet.
constexpr double kThin = 1e-6;
// Parts that are asked whether one is within them: with more around it that stays open.
constexpr std::size_t kMostHosts = 256;

struct ClosedPart {
  double volume = 0;  // signed, below 0 where faces look inward
  glm::dvec3 low{std::numeric_limits<double>::max()}, high{-std::numeric_limits<double>::max()};
  std::int32_t first_face = -1;
  bool is_open = false;

  [[nodiscard]] bool is_solid() const {
    const glm::dvec3 size = high - low;
    return !is_open && std::abs(volume) > kThin * size.x * size.y * size.z;
  }
  [[nodiscard]] bool holds(const ClosedPart& other) const {
    return glm::all(glm::lessThanEqual(low, other.low)) &&
           glm::all(glm::lessThanEqual(other.high, high));
  }
};

// By the first vertex of each part, of which all others know.
std::vector<std::int32_t> first_vertices(const MeshTopology& topology) {
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  ConcurrentSets sets(count);
  parallel_each(topology.edge_count(), kInsideOutGrain, [&](std::int32_t e) {
    const auto [v, w] = topology.edge_vertices(e);
    sets.unite(v, w);
  });
  std::vector<std::int32_t> first(count);
  parallel_each(count, kInsideOutGrain, [&](std::int32_t v) { first[v] = sets.find(v); });
  return first;
}

// What a face and a point enclose, three times; below 0 where the face looks at the point.
double volume_of(const PolygonMesh& mesh, std::span<const std::int32_t> face,
                 const glm::dvec3& about) {
  return glm::dot(mesh.positions[face[0]] - about, area_vector(mesh.positions, face));
}

// What a closed part holds, three times.
double volume_of(const PolygonMesh& mesh, const MeshTopology& topology) {
  return ordered_reduce(
      static_cast<std::size_t>(topology.face_count()), kInsideOutGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t f = begin; f < end; ++f)
          sum += volume_of(mesh, topology.face(static_cast<std::int32_t>(f)), mesh.positions[0]);
        return sum;
      },
      [](double& total, double part) { total += part; });
}

std::vector<ClosedPart> parts_of(const PolygonMesh& mesh, const MeshTopology& topology) {
  const std::vector<std::int32_t> first = first_vertices(topology);
  std::vector<std::int32_t> part_of(first.size(), -1);
  std::vector<ClosedPart> parts;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const auto face = topology.face(f);
    const std::int32_t root = first[face[0]];
    if (part_of[root] < 0) {
      part_of[root] = static_cast<std::int32_t>(parts.size());
      parts.push_back({.first_face = f});
    }
    ClosedPart& part = parts[part_of[root]];
    part.volume += volume_of(mesh, face, mesh.positions[root]) / 3;
    for (const std::int32_t v : face) {
      part.low = glm::min(part.low, mesh.positions[v]);
      part.high = glm::max(part.high, mesh.positions[v]);
    }
  }
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    if (topology.is_boundary_edge(e))
      parts[part_of[first[topology.edge_vertices(e).first]]].is_open = true;
  return parts;
}

}  // namespace

InsideOutParts inside_out_parts(const PolygonMesh& mesh, const MeshTopology& topology,
                                std::int64_t component_count) {
  if (component_count == 1 && volume_of(mesh, topology) > 0) return {};
  std::vector<ClosedPart> solids = parts_of(mesh, topology);
  std::erase_if(solids, [](const ClosedPart& part) { return !part.is_solid(); });
  std::ranges::stable_sort(solids, {}, [](const ClosedPart& part) { return part.low.x; });
  InsideOutParts found;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (solids[i].volume > 0) continue;
    // What holds it begins before it.
    const std::size_t asked = std::min(i, kMostHosts);
    const auto hosts = std::span(solids).subspan(i - asked, asked);
    const auto holds = [&](const ClosedPart& host) { return host.holds(solids[i]); };
    if (asked < i || std::ranges::any_of(hosts, holds)) continue;
    ++found.count;
    if (found.first_face < 0 || solids[i].first_face < found.first_face)
      found.first_face = solids[i].first_face;
  }
  return found;
}

namespace {

// Which faces of a mesh are even, by their vector areas.
class EvenFaces {
 public:
  EvenFaces(const PolygonMesh& mesh, const MeshTopology& topology)
      : topology_(topology), areas_(face_areas(mesh)) {}

  [[nodiscard]] double area(std::int32_t face) const { return glm::length(areas_[face]); }
  [[nodiscard]] bool is_even(std::int32_t face) const {
    const std::int32_t first = topology_.first_corner(face);
    for (std::int32_t c = first; c < first + topology_.face_size(face); ++c) {
      const std::int32_t twin = topology_.twin(c);
      if (twin >= 0 && turns(face, topology_.face_of(twin))) return false;
    }
    return true;
  }

 private:
  // Of a face without area nothing can be told.
  [[nodiscard]] bool turns(std::int32_t f, std::int32_t g) const {
    static const double least_cosine = portable::cos(kEvenDegrees * std::numbers::pi / 180);
    return glm::dot(areas_[f], areas_[g]) < least_cosine * area(f) * area(g);
  }

  const MeshTopology& topology_;
  std::vector<glm::dvec3> areas_;
};

struct Areas {
  double all = 0, even = 0;
};

}  // namespace

MeshDensity mesh_density(const PolygonMesh& mesh, const MeshTopology& topology) {
  MeshDensity density;
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    density.vertex_count += topology.corners_at(v).empty() ? 0 : 1;
  if (density.vertex_count < kDenseVertices) return density;
  const EvenFaces faces(mesh, topology);
  const auto areas_of = [&](std::size_t begin, std::size_t end) {
    Areas areas;
    for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end); ++f) {
      areas.all += faces.area(f);
      if (faces.is_even(f)) areas.even += faces.area(f);
    }
    return areas;
  };
  constexpr std::size_t kPiece = 1 << 13;
  const Areas areas = ordered_reduce(static_cast<std::size_t>(topology.face_count()), kPiece,
                                     Areas{}, areas_of, [](Areas& total, const Areas& one) {
                                       total.all += one.all;
                                       total.even += one.even;
                                     });
  if (areas.all > 0) density.even_share = areas.even / areas.all;
  return density;
}

namespace {

constexpr std::size_t kPiece = 1 << 16;  // elements that are counted together

// How often each value of value_of(0 .. count - 1) arises, pieces on all threads.
template <class ValueOf>
std::vector<std::int64_t> histogram(std::int32_t count, const ValueOf& value_of) {
  using Counts = std::vector<std::int64_t>;
  return ordered_reduce(
      static_cast<std::size_t>(count), kPiece, Counts(),
      [&](std::size_t begin, std::size_t end) {
        Counts counts;
        for (std::size_t i = begin; i < end; ++i) {
          const auto value = static_cast<std::size_t>(value_of(static_cast<std::int32_t>(i)));
          if (counts.size() <= value) counts.resize(value + 1, 0);
          ++counts[value];
        }
        return counts;
      },
      [](Counts& total, const Counts& counts) {
        if (total.size() < counts.size()) total.resize(counts.size(), 0);
        for (std::size_t i = 0; i < counts.size(); ++i) total[i] += counts[i];
      });
}

// How many sets fewer the vertices are in once the ends of edges with use_edge are united.
template <class UseEdge>
std::int64_t joins(const MeshTopology& topology, const UseEdge& use_edge) {
  ConcurrentSets sets(static_cast<std::size_t>(topology.vertex_count()));
  return count_selected(static_cast<std::size_t>(topology.edge_count()),
                        [&](std::int32_t edge) {
                          if (!use_edge(edge)) return false;
                          const auto [v0, v1] = topology.edge_vertices(edge);
                          return sets.unite(v0, v1);
                        })
      .total;
}

// Each boundary vertex of a checked mesh has two boundary edges, so that loops and connected sets
// of boundary vertices are the same.
std::int64_t count_boundary_loops(const MeshTopology& topology) {
  const std::int64_t vertices =
      count_selected(static_cast<std::size_t>(topology.vertex_count()), [&](std::int32_t v) {
        return topology.is_boundary_vertex(v);
      }).total;
  if (vertices == 0) return 0;
  return vertices - joins(topology, [&](std::int32_t e) { return topology.is_boundary_edge(e); });
}

MeshStatistics statistics_of(const MeshTopology& topology, std::int64_t vertex_count) {
  MeshStatistics result;
  result.vertex_count = vertex_count;
  result.face_count = topology.face_count();
  result.edge_count = topology.edge_count();
  result.face_size_counts =
      histogram(topology.face_count(), [&](std::int32_t f) { return topology.face_size(f); });
  result.valence_counts =
      histogram(topology.vertex_count(), [&](std::int32_t v) { return topology.valence(v); });
  std::int64_t used = topology.vertex_count();
  if (!result.valence_counts.empty()) {
    used -= result.valence_counts.front();
    result.valence_counts.front() = 0;
    if (used == 0) result.valence_counts.clear();
  }
  result.unused_vertex_count = vertex_count - used;
  result.boundary_loop_count = count_boundary_loops(topology);
  result.component_count = used - joins(topology, [](std::int32_t) { return true; });
  // Euler-Poincare: V - E + F + loops = sum over components of 2 - 2 genus.
  const std::int64_t euler =
      used - result.edge_count + result.face_count + result.boundary_loop_count;
  result.genus = result.component_count - euler / 2;
  return result;
}

}  // namespace

MeshStatistics statistics(const PolygonMesh& mesh) {
  return statistics_of(MeshTopology(mesh), mesh.vertex_count());
}

MeshStatistics statistics(const PreparedMesh& prepared) {
  return statistics_of(*prepared.topology, prepared.given_vertex_count);
}

}  // namespace planish
