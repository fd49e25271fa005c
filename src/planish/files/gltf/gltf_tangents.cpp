#include "planish/files/gltf/gltf_tangents.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <numeric>
#include <tuple>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/tangent_batch.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr std::int64_t kClusterFaces = 16;
// More than regular faces need. Beyond, corners are all apart.
constexpr std::size_t kShapes = 16;
constexpr std::size_t kTriangle = 0;

// is_same(corner, corner) of `count` corners.
template <class IsSame>
TangentShape shape_by(std::size_t count, const IsSame& is_same) {
  TangentShape shape;
  for (std::size_t c = 0; c < count; ++c) {
    const auto vertex = std::ranges::find_if(
        shape.first, [&](std::uint8_t other) { return is_same(c, std::size_t{other}); });
    shape.corners.push_back(static_cast<std::uint8_t>(vertex - shape.first.begin()));
    if (vertex == shape.first.end()) shape.first.push_back(static_cast<std::uint8_t>(c));
  }
  return shape;
}

}  // namespace

void TangentClusterMaker::operator()(RowRange faces, TangentClusters& made) {
  const SurfaceInfo& info = surface_.info();
  const auto count = static_cast<std::size_t>(info.first_corner(faces.first + faces.count) -
                                              info.first_corner(faces.first));
  rows_.resize(count), uvs_.resize(count);
  surface_.face_vertices(faces, rows_);
  surface_.face_uvs(faces, uvs_);
  groups_.resize(static_cast<std::size_t>(faces.count));
  if (info.has_groups) surface_.face_groups(faces, groups_);
  if (!info.has_groups) std::ranges::fill(groups_, 0);
  made.shapes = {TangentShape{{0, 1, 2, 2}, {0, 1, 2}}};
  made.clusters.clear();
  made.cuts.clear();
  corners_.clear();
  const bool is_of_quads = info.face_offsets.empty() && info.corners_per_face == 4;
  if (is_of_quads) {
    add_quads(faces, made);
  } else {
    add_polygons(faces, made);
  }
  made.rows.resize(corners_.size()), made.uvs.resize(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    made.rows[i] = rows_[corners_[i]];
    made.uvs[i] = uvs_[corners_[i]];
  }
  take_rows(made);
  if (!is_of_quads) return;
  made.cuts.resize(static_cast<std::size_t>(faces.count));
  surface_.cuts(faces, made.cuts);
}

// Not by the faces' corners, whose patches agree on a row but for rounding.
void TangentClusterMaker::take_rows(TangentClusters& made) {
  made.positions.resize(made.rows.size()), made.normals.resize(made.rows.size());
  if (surface_.kept_rows_at(made.rows, glm::dvec3(0.0), made.positions, made.normals)) return;
  std::vector<std::int32_t> rows(made.rows.begin(), made.rows.end());
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::vector<glm::vec3> stored(rows.size()), normals(rows.size());
  RowTarget target;
  target.stored = stored;
  target.normals = normals;
  (void)surface_.rows_at(rows, target);
  for (std::size_t i = 0; i < made.rows.size(); ++i) {
    const auto at = std::ranges::lower_bound(rows, made.rows[i]) - rows.begin();
    made.positions[i] = stored[at];
    made.normals[i] = normals[at];
  }
}

std::size_t TangentClusterMaker::shape_of(std::size_t corner, std::size_t count,
                                          TangentClusters& made) const {
  const std::int32_t *rows = rows_.data() + corner, *uvs = uvs_.data() + corner;
  const auto is_same = [&](std::size_t a, std::size_t b) {
    return rows[a] == rows[b] && uvs[a] == uvs[b];
  };
  for (std::size_t s = kTriangle + 1; s < made.shapes.size(); ++s) {
    const TangentShape& shape = made.shapes[s];
    bool fits = shape.corners.size() == count;
    for (std::size_t c = 0; fits && c < count; ++c)
      fits = is_same(c, shape.first[shape.corners[c]]);
    if (fits) return s;
  }
  const bool is_regular = made.shapes.size() < kShapes;
  made.shapes.push_back(
      shape_by(count, [&](std::size_t a, std::size_t b) { return is_regular && is_same(a, b); }));
  return made.shapes.size() - 1;
}

void TangentClusterMaker::add(const TangentCluster& cluster, std::size_t corner,
                              TangentClusters& made) {
  made.clusters.push_back(cluster);
  made.clusters.back().first_vertex = corners_.size();
  for (const std::uint8_t first : made.shapes[cluster.shape].first)
    corners_.push_back(corner + first);
}

void TangentClusterMaker::add_quads(RowRange faces, TangentClusters& made) {
  ancestors_.resize(static_cast<std::size_t>(faces.count));
  surface_.ancestors(faces, ancestors_);
  for (std::int64_t f = 0, end = 0; f < faces.count; f = end) {
    end = f + 1;
    while (end < faces.count && end < f + kClusterFaces && ancestors_[end] == ancestors_[f]) ++end;
    const int set = set_of_group_[groups_[f]];
    const auto corner = static_cast<std::size_t>(4 * f);
    if (set < 0) continue;
    add({.shape = shape_of(corner, static_cast<std::size_t>(4 * (end - f)), made),
         .set = set,
         .first_cut = static_cast<std::size_t>(f),
         .face = faces.first + f},
        corner, made);
  }
}

void TangentClusterMaker::add_polygons(RowRange faces, TangentClusters& made) {
  const SurfaceInfo& info = surface_.info();
  const std::int64_t first = info.first_corner(faces.first);
  positions_.resize(rows_.size()), normals_.resize(rows_.size());
  surface_.corners(faces, positions_, normals_);
  for (std::int64_t f = 0; f < faces.count; ++f) {
    const int set = set_of_group_[groups_[f]];
    if (set < 0) continue;
    const auto corner = static_cast<std::size_t>(info.first_corner(faces.first + f) - first);
    const auto size =
        static_cast<std::size_t>(info.first_corner(faces.first + f + 1) - first) - corner;
    if (size == 4) {
      const glm::dvec3* p = positions_.data() + corner;
      add({.shape = shape_of(corner, 4, made),
           .set = set,
           .first_cut = made.cuts.size(),
           .face = faces.first + f},
          corner, made);
      made.cuts.push_back(is_cut_from_1(p[0], p[1], p[2], p[3]) ? 1 : 0);
      continue;
    }
    numbers_.resize(size);
    std::iota(numbers_.begin(), numbers_.end(), 0);
    triangles_.resize(3 * (size - 2));
    triangulate(numbers_, std::span(positions_).subspan(corner, size), triangles_);
    for (std::size_t t = 0; t < triangles_.size(); t += 3) {
      made.clusters.push_back({.shape = kTriangle,
                               .set = set,
                               .first_vertex = corners_.size(),
                               .first_cut = made.cuts.size(),
                               .face = faces.first + f});
      for (std::size_t k = 0; k < 3; ++k) corners_.push_back(corner + triangles_[t + k]);
      made.cuts.push_back(0);
    }
  }
}

namespace {

constexpr std::int64_t kFaces = std::int64_t{1} << 12;
constexpr std::size_t kTangentsAtOnce = 1 << 12;

// Square to a normal.
glm::vec3 any_tangent(const glm::vec3& normal) {
  const glm::vec3 size = glm::abs(normal);
  const int axis = size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2;
  glm::vec3 any(0.0f);
  any[axis] = 1;
  const glm::vec3 flat = any - normal * normal[axis];
  return flat / glm::length(flat);
}

// What is known of each vertex of some faces' clusters: the sum of the directions of its triangles
// by their angles there, and of their areas in the texture.
struct Measured : TangentClusters {
  RawVector<glm::vec4> sums;
};

class Measurer {
 public:
  Measurer(const SurfaceBlocks& surface, const TangentSource& source)
      : surface_(surface), source_(source) {}

  void operator()(RowRange faces, Measured& made) const {
    thread_local Lanes lanes;
    TangentClusterMaker(surface_, source_.set_of_group)(faces, made);
    made.sums.resize(made.rows.size());
    for (std::size_t shape = 0; shape < made.shapes.size(); ++shape) {
      lanes.begin(made.shapes[shape]);
      for (const TangentCluster& cluster : made.clusters) {
        if (cluster.shape != shape) continue;
        lanes.add(cluster, source_, made);
        if (lanes.is_full()) lanes.finish(made);
      }
      lanes.finish(made);
    }
  }

 private:
  // Clusters of one shape side by side.
  class Lanes {
   public:
    void begin(const TangentShape& shape) {
      shape_ = &shape;
      count_ = 0;  // of a piece that ended by an exception some may be left
      vertices_.assign(shape.first.size() * kTangentNumbers * kTangentLanes, 0.0f);
      cuts_.assign(shape.corners.size() / 4 * kTangentLanes, 0);
    }
    [[nodiscard]] bool is_full() const { return count_ == kTangentLanes; }

    // Differences from the first vertex.
    void add(const TangentCluster& cluster, const TangentSource& source, const Measured& made) {
      const std::span<const glm::dvec2> uvs = source.sets[cluster.set];
      const std::size_t first = cluster.first_vertex;
      const glm::vec3 origin = made.positions[first];
      const glm::dvec2 uv_origin = uvs[made.uvs[first]];
      float* to = vertices_.data() + count_;
      for (std::size_t v = first; v < first + shape_->first.size(); ++v) {
        const glm::vec3 p = made.positions[v] - origin, &n = made.normals[v];
        const glm::vec2 t(uvs[made.uvs[v]] - uv_origin);
        for (const float number : {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y}) {
          *to = number;
          to += kTangentLanes;
        }
      }
      for (std::size_t q = 0; q < shape_->corners.size() / 4; ++q)
        cuts_[q * kTangentLanes + static_cast<std::size_t>(count_)] =
            made.cuts[cluster.first_cut + q];
      first_[count_++] = first;
    }

    void finish(Measured& made) {
      if (count_ == 0) return;
      const std::size_t vertices = shape_->first.size();
      sums_.assign(vertices * 4 * kTangentLanes, 0.0f);
      measure_tangents({.count = static_cast<int>(shape_->corners.size() / 4),
                        .corners = shape_->corners.data(),
                        .vertex_count = static_cast<int>(vertices),
                        .vertices = vertices_.data(),
                        .cuts = cuts_.data()},
                       sums_.data());
      for (int i = 0; i < count_; ++i) {
        const float* from = sums_.data() + i;
        for (std::size_t v = 0; v < vertices; ++v, from += 4 * kTangentLanes)
          made.sums[first_[i] + v] = {from[0], from[kTangentLanes], from[2 * kTangentLanes],
                                      from[3 * kTangentLanes]};
      }
      count_ = 0;
    }

   private:
    const TangentShape* shape_ = nullptr;
    std::vector<float> vertices_, sums_;
    std::vector<int> cuts_;
    std::size_t first_[kTangentLanes];  // vertex of each cluster
    int count_ = 0;
  };

  const SurfaceBlocks& surface_;
  const TangentSource& source_;
};

// Sums of each texture coordinate on the first row that has it, then on further ones.
class TangentSums {
 public:
  TangentSums(const SurfaceBlocks& surface, const TangentSource& source)
      : source_(source), row_count_(static_cast<std::size_t>(surface.info().row_count)) {
    const auto count = static_cast<std::size_t>(surface.info().uv_count);
    values_.resize(4 * count);
    rows_.assign(count, -1);
    for (const int set : source.set_of_group) {
      if (set >= 0 && set_ >= 0 && set != set_) sets_.resize(count, set);
      if (set >= 0) set_ = set;
    }
  }

  // One piece after another.
  void add(const Measured& piece) {
    for (const TangentCluster& cluster : piece.clusters) {
      const std::size_t end = cluster.first_vertex + piece.shapes[cluster.shape].first.size();
      for (std::size_t v = cluster.first_vertex; v < end; ++v) {
        const std::size_t slot = slot_of({piece.uvs[v], piece.rows[v]});
        if (!sets_.empty()) sets_[piece.uvs[v]] = cluster.set;
        float* const sum = sum_of(slot);
        for (int k = 0; k < 4; ++k) sum[k] += piece.sums[v][k];
        if (is_zero(sum)) zero_.push_back({slot, piece.normals[v]});
      }
    }
  }

  [[nodiscard]] SurfaceTangents finished() && {
    join_seams();
    for (const auto& [slot, normal] : zero_) {
      float* const sum = sum_of(slot);
      if (!is_zero(sum)) continue;
      const glm::vec3 any = any_tangent(normal);
      for (int axis = 0; axis < 3; ++axis) sum[axis] = any[axis];
    }
    parallel_each(slot_count(), kTangentsAtOnce, [&](std::size_t slot) {
      float* const v = sum_of(slot);
      if (rows_[slot] < 0) {
        std::fill_n(v, 4, 0.0f);
        return;
      }
      const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      v[0] /= length, v[1] /= length, v[2] /= length;
      v[3] = v[3] < 0 ? -1.0f : 1.0f;
    });
    SurfaceTangents made;
    for (const auto& [place, slot] : further_) {
      made.further.push_back(place);
      made.further_values.insert(made.further_values.end(), sum_of(slot), sum_of(slot) + 4);
    }
    made.values = std::move(values_);
    return made;
  }

 private:
  struct OfSlot {
    std::size_t slot;
    glm::vec3 normal;
  };

  [[nodiscard]] static bool is_zero(const float* sum) {
    return sum[0] == 0 && sum[1] == 0 && sum[2] == 0;
  }
  [[nodiscard]] std::size_t slot_count() const { return rows_.size(); }
  [[nodiscard]] float* sum_of(std::size_t slot) {
    const std::size_t first_further = values_.size() / 4;
    return slot < first_further ? values_.data() + 4 * slot
                                : further_values_.data() + 4 * (slot - first_further);
  }
  std::size_t slot_of(const UvOnRow& place) {
    const auto uv = static_cast<std::size_t>(place.uv);
    if (rows_[uv] < 0) {
      rows_[uv] = place.row;
      std::fill_n(values_.begin() + place.uv * std::int64_t{4}, 4, 0.0f);
    }
    if (rows_[uv] == place.row) return uv;
    const auto [entry, is_new] = further_.try_emplace(place, slot_count());
    if (is_new) {
      rows_.push_back(place.row);
      further_uvs_.push_back(place.uv);
      further_values_.resize(further_values_.size() + 4, 0.0f);
    }
    return entry->second;
  }

  // Slots on rows that have several.
  [[nodiscard]] std::vector<std::size_t> shared_slots() const {
    constexpr std::int32_t kNone = -1, kSeveral = -2;
    std::vector<std::int32_t> only(row_count_, kNone);
    for (const std::int32_t row : rows_) {
      if (row < 0) continue;
      std::int32_t& of = only[row];
      of = of == kNone ? 0 : kSeveral;
    }
    std::vector<std::size_t> shared;
    for (std::size_t slot = 0; slot < rows_.size(); ++slot)
      if (rows_[slot] >= 0 && only[rows_[slot]] == kSeveral) shared.push_back(slot);
    return shared;
  }

  // Texture coordinates that are one to a reader, which compares what vertices have.
  void join_seams() {
    std::vector<std::size_t> order = shared_slots();
    const std::size_t uv_count = values_.size() / 4;
    const auto key = [&](std::size_t slot) {
      const auto uv =
          slot < uv_count ? slot : static_cast<std::size_t>(further_uvs_[slot - uv_count]);
      const int set = sets_.empty() ? set_ : sets_[uv];
      const glm::dvec2 place = source_.sets[set][uv];
      return std::tuple(set, rows_[slot], place.x, place.y, sum_of(slot)[3] < 0);
    };
    oneapi::tbb::parallel_sort(order, [&](std::size_t a, std::size_t b) {
      const auto of_a = key(a), of_b = key(b);
      return of_a != of_b ? of_a < of_b : a < b;
    });
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
      glm::vec3 sum(0.0f);
      for (end = begin; end < order.size() && key(order[end]) == key(order[begin]); ++end)
        for (int axis = 0; axis < 3; ++axis) sum[axis] += sum_of(order[end])[axis];
      for (std::size_t i = begin; i < end && sum != glm::vec3(0.0f); ++i)
        for (int axis = 0; axis < 3; ++axis) sum_of(order[i])[axis] = sum[axis];
    }
  }

  const TangentSource& source_;
  std::size_t row_count_;
  RawVector<float> values_;  // of a slot without a row none yet
  std::vector<float> further_values_;
  std::vector<std::int32_t> rows_;         // of each slot; -1: none is wanted
  std::vector<std::int32_t> further_uvs_;  // of further slots
  std::map<UvOnRow, std::size_t> further_;
  int set_ = -1;
  std::vector<int> sets_;     // of each texture coordinate; empty: set_
  std::vector<OfSlot> zero_;  // whose sum was zero when a piece had been added
};

}  // namespace

SurfaceTangents surface_tangents(const SurfaceBlocks& surface, const TangentSource& source) {
  TangentSums sums(surface, source);
  const std::vector<RowRange> pieces = ranges_of(surface.info().face_count, kFaces);
  in_order<Measured>(pieces, Measurer(surface, source),
                     [&](RowRange, const Measured& piece) { sums.add(piece); });
  return std::move(sums).finished();
}

}  // namespace planish
