#include "planish/reconstruct/compare_source.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/raw_vector.h"
#include "planish/surface/quality_sum.h"

namespace planish {

namespace {

// How far from its corner towards the face's middle a normal is looked up.
constexpr double kInward = 0.01;
// Of the time, that of the source's tree.
constexpr double kTreeMade = 0.2;
// Each a few dozen milliseconds of a thread.
constexpr std::int64_t kFacesAtOnce = 4096, kRowsAtOnce = 1 << 14;

std::vector<Triangle> fans_of(const PolygonMesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto vertices = mesh.face(f);
    for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
      triangles.push_back({vertices[0], vertices[i], vertices[i + 1]});
    }
  }
  return triangles;
}

// Of a run of faces, corner by corner; with the bits of the surface's rows.
struct ComparedFaces {
  RawVector<glm::dvec3> positions, wanted;
  RawVector<glm::vec3> normals;

  void take(const SurfaceBlocks& surface, RowRange faces) {
    const SurfaceInfo& info = surface.info();
    vertices_.resize(static_cast<std::size_t>(info.first_corner(faces.first + faces.count) -
                                              info.first_corner(faces.first)));
    surface.face_vertices(faces, vertices_);
    rows_.assign(vertices_.begin(), vertices_.end());
    std::ranges::sort(rows_);
    rows_.erase(std::unique(rows_.begin(), rows_.end()), rows_.end());
    row_positions_.resize(rows_.size());
    row_normals_.resize(rows_.size());
    RowTarget target;
    target.positions = row_positions_;
    target.normals = row_normals_;
    (void)surface.rows_at(rows_, target);
    positions.resize(vertices_.size());
    wanted.resize(vertices_.size());
    normals.resize(vertices_.size());
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const auto at =
          static_cast<std::size_t>(std::ranges::lower_bound(rows_, vertices_[i]) - rows_.begin());
      positions[i] = row_positions_[at];
      normals[i] = row_normals_[at];
    }
  }

 private:
  RawVector<std::int32_t> vertices_;
  std::vector<std::int32_t> rows_;  // that the faces name, ascending
  RawVector<glm::dvec3> row_positions_;
  RawVector<glm::vec3> row_normals_;
};

// What a surface is held against.
class SourceShape {
 public:
  explicit SourceShape(const PolygonMesh& source)
      : positions_(source.positions), triangles_(fans_of(source)), tree_(positions_, triangles_) {
    if (triangles_.empty()) throw Error(ErrorCode::UnusableMesh, "the source has no faces");
  }

  [[nodiscard]] double squared_distance(const glm::dvec3& point) const {
    return tree_.nearest(point).squared_distance;
  }

  // The normals of the nearest triangles to the corners of a face.
  void look_up(std::span<const glm::dvec3> corners, std::span<glm::dvec3> normals) const {
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& corner : corners) middle += corner;
    middle /= static_cast<double>(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      normals[i] = normal_of(
          triangles_[tree_.nearest(corners[i] + kInward * (middle - corners[i])).triangle]);
  }

 private:
  [[nodiscard]] glm::dvec3 normal_of(const Triangle& t) const {
    const glm::dvec3& origin = positions_[t[0]];
    return glm::cross(positions_[t[1]] - origin, positions_[t[2]] - origin);
  }

  std::span<const glm::dvec3> positions_;
  std::vector<Triangle> triangles_;
  TriangleTree tree_;
};

// Places of a face's corners in a piece that begins with face `first`.
RowRange corners_in_piece(const SurfaceInfo& info, std::int64_t first, std::int64_t face) {
  const std::int64_t begin = info.first_corner(face);
  return {begin - info.first_corner(first), info.first_corner(face + 1) - begin};
}

template <class Value>
std::span<Value> part_of(RawVector<Value>& values, RowRange range) {
  return std::span(values).subspan(static_cast<std::size_t>(range.first),
                                   static_cast<std::size_t>(range.count));
}

SurfaceQuality quality_against(const SurfaceBlocks& surface, const SourceShape& source,
                               const Callbacks& callbacks) {
  const SurfaceInfo& info = surface.info();
  LoopProgress progress(callbacks, "measure", kTreeMade, 0.8, info.face_count);
  QualitySum sum;
  in_order<ComparedFaces>(
      ranges_of(info.face_count, kFacesAtOnce),
      [&](RowRange faces, ComparedFaces& piece) {
        piece.take(surface, faces);
        for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
          const RowRange corners = corners_in_piece(info, faces.first, f);
          source.look_up(part_of(piece.positions, corners), part_of(piece.wanted, corners));
        }
      },
      [&](RowRange faces, ComparedFaces& piece) {
        for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
          const RowRange corners = corners_in_piece(info, faces.first, f);
          sum.add(part_of(piece.positions, corners), part_of(piece.normals, corners),
                  part_of(piece.wanted, corners));
        }
        progress.add(faces.count);
      });
  return sum.result();
}

PointDistances distances_of(const SurfaceBlocks& surface, const SourceShape& source,
                            const Callbacks& callbacks) {
  LoopProgress progress(callbacks, "measure", 0.8, 1, surface.info().row_count);
  PointDistances distances;
  double largest = -1, total = 0;  // of squares
  in_order<std::vector<double>>(
      sorted(surface.row_blocks(kRowsAtOnce)),
      [&](RowRange rows, std::vector<double>& squared) {
        RawVector<glm::dvec3> positions(static_cast<std::size_t>(rows.count));
        RowTarget target;
        target.positions = positions;
        (void)surface.rows(rows, target);
        squared.resize(positions.size());
        std::ranges::transform(positions, squared.begin(), [&](const glm::dvec3& position) {
          return source.squared_distance(position);
        });
      },
      [&](RowRange rows, std::vector<double>& squared) {
        for (std::size_t i = 0; i < squared.size(); ++i) {
          total += squared[i];
          if (squared[i] <= largest) continue;
          largest = squared[i];
          distances.farthest = rows.first + static_cast<std::int64_t>(i);
        }
        progress.add(rows.count);
      });
  if (distances.farthest < 0) return distances;
  distances.max = std::sqrt(largest);
  distances.rms = std::sqrt(total / static_cast<double>(surface.info().row_count));
  return distances;
}

}  // namespace

SourceComparison compare_with_source(const SurfaceBlocks& surface, const PolygonMesh& source,
                                     const Callbacks& callbacks) {
  const HostScope host(callbacks);
  callbacks.report("measure", 0);
  const SourceShape shape(source);
  const SourceComparison found{.quality = quality_against(surface, shape, callbacks),
                               .distances = distances_of(surface, shape, callbacks)};
  callbacks.report("measure", 1);
  return found;
}

}  // namespace planish
