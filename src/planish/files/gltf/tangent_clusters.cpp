#include "planish/files/gltf/tangent_clusters.h"

#include <algorithm>
#include <numeric>

#include "planish/mesh/quad_cut.h"
#include "planish/mesh/triangulate.h"

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

}  // namespace planish
