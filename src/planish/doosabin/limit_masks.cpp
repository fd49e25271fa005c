// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1) and
// section 4 (B = A T). Boundaries and creases: uniform quadratic B-spline of the sharp polyline.
#include "planish/doosabin/limit_masks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/solve/stencil_builder.h"

namespace planish {

namespace {

constexpr std::size_t kGrain = 1024;

// Where the sums of faces stand as sources: none, or behind the vertices in the order of the faces.
class FaceSums {
 public:
  FaceSums() = default;
  FaceSums(const MeshTopology& topology, Weights weights)
      : rule_(face_sum_rule(weights)), per_face_(rule_.sum_count()) {
    for (std::int32_t f = 0; f < topology.face_count(); ++f)
      if (topology.face_size(f) >= kSummedRing) faces_.push_back(f);
    first_ = topology.vertex_count();
  }

  [[nodiscard]] bool is_summed(std::size_t size) const {
    return !faces_.empty() && size >= static_cast<std::size_t>(kSummedRing);
  }
  [[nodiscard]] const FaceSumRule& rule() const { return rule_; }
  [[nodiscard]] std::int32_t per_face() const { return per_face_; }
  [[nodiscard]] std::int32_t count() const {
    return per_face_ * static_cast<std::int32_t>(faces_.size());
  }
  /// Of a large face, its mean; behind it, where the rule turns, its Fourier pair.
  [[nodiscard]] std::int32_t source_of(std::int32_t face) const {
    return first_ + per_face_ * static_cast<std::int32_t>(std::ranges::lower_bound(faces_, face) -
                                                          faces_.begin());
  }
  [[nodiscard]] StencilTable table(const MeshTopology& topology) const;

 private:
  FaceSumRule rule_{};
  std::int32_t per_face_ = 0, first_ = 0;
  std::vector<std::int32_t> faces_;
};

double angle_of(std::size_t place, std::size_t size) {
  return 2 * std::numbers::pi * static_cast<double>(place) / static_cast<double>(size);
}

StencilTable FaceSums::table(const MeshTopology& topology) const {
  StencilTable sums;
  for (const std::int32_t f : faces_) {
    const auto vertices = topology.face(f);
    const double share = 1 / static_cast<double>(vertices.size());
    for (std::int32_t which = 0; which < per_face_; ++which) {
      sums.sizes.push_back(static_cast<std::int32_t>(vertices.size()));
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const double angle = angle_of(i, vertices.size());
        sums.indices.push_back(vertices[i]);
        sums.weights.push_back(
            which == 0 ? share
                       : 2 * share * (which == 1 ? portable::cos(angle) : portable::sin(angle)));
      }
    }
  }
  sums.close(topology.vertex_count());
  return sums;
}

struct MaskEmitter {
  const MeshTopology& topology;
  const Subdivision& subdivision;
  const FaceSums& sums;
  std::vector<double> scratch{}, beside{};

  // Entries of a row, but for vertices that several faces have besides the edges they share.
  [[nodiscard]] std::int32_t size_of(std::int32_t vertex) const {
    switch (subdivision.features().vertex_kinds[vertex]) {
      case VertexKind::Crease:
        return 3;
      case VertexKind::Corner:
        return 1;
      case VertexKind::Smooth:
      case VertexKind::Dart:
        break;
    }
    std::int32_t size = 1;
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      const std::int32_t m = topology.face_size(topology.face_of(corner));
      size += sums.is_summed(static_cast<std::size_t>(m)) ? 1 + sums.per_face() : m - 2;
    }
    return size;
  }

  void smooth(std::int32_t vertex, StencilRow& row) {
    const auto corners = topology.corners_at(vertex);
    const std::size_t n = corners.size();
    const double share = 1.0 / static_cast<double>(n);
    double own = 0;
    beside.assign(n, 0.0);  // of the vertex after each corner, which the face before has as well
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t face = topology.face_of(corners[k]);
      const auto vertices = topology.face(face);
      const std::size_t m = vertices.size();
      auto place = static_cast<std::size_t>(corners[k] - topology.first_corner(face));
      const bool is_summed = sums.is_summed(m);
      std::span<const double> c;
      if (!is_summed) c = subdivision.face_weights().of(static_cast<std::int32_t>(m), scratch);
      own += share * (is_summed ? sums.rule().own : c[0]);
      beside[k] += share * (is_summed ? sums.rule().beside : c[1]);
      beside[k + 1 == n ? 0 : k + 1] += share * (is_summed ? sums.rule().beside : c[m - 1]);
      if (is_summed) {
        add_sums(face, angle_of(place, m), share, row);
        continue;
      }
      place += 2;
      for (std::size_t j = 2; j + 1 < m; ++j, ++place)
        row.add(vertices[place < m ? place : place - m], share * c[j]);
    }
    for (std::size_t k = 0; k < n; ++k)
      row.add(topology.vertex_of(topology.next(corners[k])), beside[k]);
    row.add(vertex, own);
  }

  void add_sums(std::int32_t face, double angle, double share, StencilRow& row) const {
    const std::int32_t source = sums.source_of(face);
    row.add(source, share * sums.rule().mean);
    if (sums.per_face() == 1) return;
    row.add(source + 1, share * sums.rule().turn * portable::cos(angle));
    row.add(source + 2, share * sums.rule().turn * portable::sin(angle));
  }

  void crease(std::int32_t vertex, StencilRow& row) const {
    row.add(vertex, 6.0 / 8.0);
    const auto add_along = [&](std::int32_t edge) {
      if (subdivision.sharp_of_edge(edge) < 0) return;
      const auto [v0, v1] = topology.edge_vertices(edge);
      row.add(v0 == vertex ? v1 : v0, 1.0 / 8.0);
    };
    const auto corners = topology.corners_at(vertex);
    for (const std::int32_t corner : corners) add_along(topology.edge_of(corner));
    if (topology.is_boundary_vertex(vertex))
      add_along(topology.edge_of(topology.prev(corners.back())));
    PLANISH_ASSERT(row.entries().size() == 3);
  }

  void emit(std::int32_t vertex, StencilRow& row) {
    switch (subdivision.features().vertex_kinds[vertex]) {
      case VertexKind::Smooth:
      case VertexKind::Dart:
        return smooth(vertex, row);
      case VertexKind::Crease:
        return crease(vertex, row);
      case VertexKind::Corner:
        return row.add(vertex, 1.0);
    }
  }
};

// Closes the gaps behind rows that came out shorter than their place.
void close_gaps(StencilTable& masks) {
  std::int32_t end = 0;
  for (std::size_t v = 0; v < masks.sizes.size(); ++v) {
    std::copy_n(masks.indices.begin() + masks.offsets[v], masks.sizes[v],
                masks.indices.begin() + end);
    std::copy_n(masks.weights.begin() + masks.offsets[v], masks.sizes[v],
                masks.weights.begin() + end);
    masks.offsets[v] = end;
    end += masks.sizes[v];
  }
  masks.indices.resize(end);
  masks.weights.resize(end);
}

}  // namespace

namespace {

constexpr std::int64_t kMostAddressed = std::numeric_limits<std::int32_t>::max();
// Rows without sums may take what a million quads do, or so many times what they would with them.
constexpr std::int64_t kMostUnsummed = 1 << 24, kMostExpansion = 8;

std::int64_t unsummed_entries(std::int64_t face_size) { return face_size * (face_size - 2); }
// A corner of a large face takes a neighbour, three sums and a place in each of these.
std::int64_t summed_entries(std::int64_t face_size) {
  return face_size >= kSummedRing ? 7 * face_size : unsummed_entries(face_size);
}

template <class OfFace>
std::int64_t entry_count(const MeshTopology& topology, const OfFace& of_face) {
  std::int64_t count = topology.vertex_count();
  for (std::int32_t f = 0; f < topology.face_count(); ++f) count += of_face(topology.face_size(f));
  return count;
}

MeshProblem too_many_entries(const MeshTopology& topology, std::int64_t count,
                             std::string_view rule) {
  std::int32_t largest = 0;
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (topology.face_size(f) > topology.face_size(largest)) largest = f;
  return {MeshProblemKind::TooLarge, largest,
          formatted("the stencils of the progressive method need up to {} entries, {}; the largest "
                    "face, {}, has {} corners; the fair method needs none",
                    count, rule, largest, topology.face_size(largest))};
}

StencilTable mask_rows(const Subdivision& subdivision, const FaceSums& sums) {
  const MeshTopology& topology = subdivision.topology();
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  StencilTable masks;
  masks.source_count = topology.vertex_count() + sums.count();
  masks.sizes.resize(count);
  masks.offsets.resize(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    const MaskEmitter emitter{topology, subdivision, sums};
    for (std::size_t v = begin; v < end; ++v)
      masks.offsets[v] = emitter.size_of(static_cast<std::int32_t>(v));
  });
  const std::int32_t entry_count = exclusive_sum(masks.offsets);
  masks.indices.resize(entry_count);
  masks.weights.resize(entry_count);
  std::atomic<bool> has_gaps{false};
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    MaskEmitter emitter{topology, subdivision, sums};
    StencilRow row;
    for (std::size_t v = begin; v < end; ++v) {
      row.clear();
      emitter.emit(static_cast<std::int32_t>(v), row);
      row.finish();
      std::int32_t place = masks.offsets[v];
      masks.sizes[v] = static_cast<std::int32_t>(row.entries().size());
      for (const StencilRow::Entry& entry : row.entries()) {
        masks.indices[place] = entry.index;
        masks.weights[place++] = entry.weight;
      }
      const std::int32_t next = v + 1 < count ? masks.offsets[v + 1] : entry_count;
      if (place != next) has_gaps.store(true, std::memory_order_relaxed);
    }
  });
  if (has_gaps.load()) close_gaps(masks);
  return masks;
}

void require_not(const std::optional<MeshProblem>& problem) {
  if (problem) throw Error(ErrorCode::UnusableMesh, problem->message, problem->element);
}

}  // namespace

std::optional<MeshProblem> too_large_masks(const MeshTopology& topology) {
  const std::int64_t count = entry_count(topology, unsummed_entries);
  const std::int64_t most =
      std::min(kMostAddressed,
               std::max(kMostUnsummed, kMostExpansion * entry_count(topology, summed_entries)));
  if (count <= most) return std::nullopt;
  return too_many_entries(topology, count,
                          formatted("without sums of large faces at most {} are taken here", most));
}

std::optional<MeshProblem> too_large_summed_masks(const MeshTopology& topology) {
  const std::int64_t count = entry_count(topology, summed_entries);
  if (count <= kMostAddressed) return std::nullopt;
  return too_many_entries(topology, count,
                          formatted("at most {} can be addressed", kMostAddressed));
}

StencilTable limit_masks(const Subdivision& subdivision) {
  require_not(too_large_masks(subdivision.topology()));
  return mask_rows(subdivision, {});
}

SummedTable summed_limit_masks(const Subdivision& subdivision) {
  const MeshTopology& topology = subdivision.topology();
  require_not(too_large_summed_masks(topology));
  const FaceSums sums(topology, subdivision.face_weights().weights());
  return {mask_rows(subdivision, sums), sums.table(topology)};
}

double spectral_bound(const PolygonMesh& mesh, Weights weights) {
  double bound = 1.0;
  std::int32_t last = 0;  // most faces are of the size of the one before
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t size = mesh.face_size(f);
    if (size == last) continue;
    last = size;
    bound = std::min(bound, smallest_face_eigenvalue(weights, size));
  }
  return bound;
}

bool is_self_adjoint(const SharpFeatures& features) {
  return features.sharp_edge_count == 0 && features.corner_count == 0;
}

std::vector<double> valences(const MeshTopology& topology) {
  std::vector<double> result(static_cast<std::size_t>(topology.vertex_count()));
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    result[v] = static_cast<double>(topology.corners_at(v).size());
  return result;
}

}  // namespace planish
