#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/measure/figures.h"
#include "planish/mesh/face_geometry.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/quad_figures.h"

namespace planish {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kSharedPieces = 8;

using Sums = QualitySums;

}  // namespace

// Measures one range of quads after another; keeps its memory.
class QuadMeter {
 public:
  using Run = BlockQuality::Run;

  // `runs`: where the quads' parts are asked for.
  Sums operator()(const PolygonMesh& input, const ApexNormals& apexes,
                  std::span<const std::uint8_t> is_beside_folds, const SurfaceBlocks& surface,
                  RowRange faces, std::span<const glm::dvec3> positions,
                  std::span<const glm::vec3> normals, const PartOfFaces& parts = {},
                  std::vector<Run>* runs = nullptr) {
    input_ = &input;
    parts_ = parts.of_face;
    runs_ = runs;
    apexes_ = &apexes;
    is_beside_folds_ = is_beside_folds;
    positions_ = positions;
    normals_ = normals;
    const auto count = static_cast<std::size_t>(faces.count);
    ancestors_.resize(count);
    surface.ancestors(faces, ancestors_);
    ancestor_ = -1;
    Sums sums;
    for (std::size_t first = 0; first < count; first += kQuadLanes) {
      const auto lanes = static_cast<int>(std::min<std::size_t>(kQuadLanes, count - first));
      load(first, lanes);
      measure_quads(batch_, figures_);
      for (int i = 0; i < lanes; ++i) add(first + static_cast<std::size_t>(i), i, sums);
    }
    return sums;
  }

 private:
  // Unused lanes repeat the first.
  void load(std::size_t first, int lanes) {
    constexpr std::size_t kNumbers = 12;  // of a quad
    const bool is_full = lanes == kQuadLanes;
    if (is_full) take_corners(&positions_[4 * first].x, &normals_[4 * first].x, batch_);
    double* const position = &batch_.position[0][0][0];
    double* const normal = &batch_.normal[0][0][0];
    for (int i = 0; i < kQuadLanes; ++i) {
      const std::size_t face = first + static_cast<std::size_t>(i < lanes ? i : 0);
      if (ancestors_[face] != ancestor_) take_ancestor(ancestors_[face]);
      const double* const p = &positions_[4 * face].x;
      const float* const n = &normals_[4 * face].x;
      for (std::size_t j = is_full ? kNumbers : 0; j < kNumbers; ++j) {
        position[j * kQuadLanes + static_cast<std::size_t>(i)] = p[j];
        normal[j * kQuadLanes + static_cast<std::size_t>(i)] = static_cast<double>(n[j]);
      }
      if (apex_ != nullptr) take_normals_beside(face, static_cast<std::size_t>(i));
      deviates_[i] = has_normal_;
      for (int axis = 0; axis < 3; ++axis)
        batch_.wanted[axis][i] = has_normal_ ? wanted_[axis] : static_cast<double>(n[axis]);
    }
  }

  void take_ancestor(std::int32_t face) {
    ancestor_ = face;
    const glm::dvec3 area = area_vector(input_->positions, input_->face(face));
    const double length = glm::length(area);
    has_normal_ = length > 0;
    if (has_normal_) wanted_ = area / length;
    apex_ = apexes_->apex_of(face);
  }

  void take_normals_beside(std::size_t face, std::size_t lane) {
    std::array<glm::vec3, 4> normals;
    std::copy_n(normals_.begin() + static_cast<std::ptrdiff_t>(4 * face), 4, normals.begin());
    leave_out_apex(*apex_, positions_.subspan(4 * face, 4), normals);
    for (int k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis)
        batch_.normal[k][axis][lane] = static_cast<double>(normals[k][axis]);
  }

  void add_fold(std::size_t face, double area, Sums& sums) const {
    const std::int32_t ancestor = ancestors_[face];
    const bool counts = is_elsewhere(ancestor);
    sums.folded += area;
    if (counts) sums.folded_elsewhere += area;
    const glm::dvec3* const corners = positions_.data() + 4 * face;
    sums.places.add({ancestor, 0.25 * (corners[0] + corners[1] + corners[2] + corners[3])}, counts);
  }

  // Where the input is not to blame.
  [[nodiscard]] bool is_elsewhere(std::int32_t ancestor) const {
    return is_beside_folds_.empty() || is_beside_folds_[ancestor] == 0;
  }

  void add(std::size_t face, int i, Sums& sums) const {
    add_figures(face, i, sums);
    if (runs_ == nullptr) return;
    const std::int32_t part = parts_.empty() ? 0 : parts_[ancestors_[face]];
    if (runs_->empty() || runs_->back().part != part) runs_->push_back({part, {}});
    PartSums& of_part = runs_->back().sums;
    of_part.area += figures_.area[i];
    of_part.bending += figures_.bending[i];
    if (deviates_[i] && is_elsewhere(ancestors_[face]))
      of_part.folded_elsewhere += figures_.folded[i];
  }

  void add_figures(std::size_t face, int i, Sums& sums) const {
    sums.area += figures_.area[i];
    sums.bending += figures_.bending[i];
    if (!deviates_[i]) return;
    if (figures_.folded[i] > 0) add_fold(face, figures_.folded[i], sums);
    sums.squares += figures_.squares[i];
    sums.largest = std::max(sums.largest, figures_.largest[i]);
  }

  const PolygonMesh* input_ = nullptr;
  const ApexNormals* apexes_ = nullptr;
  std::span<const std::uint8_t> is_beside_folds_;
  std::span<const glm::dvec3> positions_;
  std::span<const glm::vec3> normals_;
  std::span<const std::int32_t> parts_;
  std::vector<Run>* runs_ = nullptr;
  RawVector<std::int32_t> ancestors_;
  std::int32_t ancestor_ = -1;
  const glm::dvec3* apex_ = nullptr;
  bool has_normal_ = false;
  glm::dvec3 wanted_{0.0};
  std::array<bool, kQuadLanes> deviates_{};  // a face without an area has no normal to deviate from
  QuadBatch batch_;
  QuadFigures figures_;
};

BlockQuality::BlockQuality(const SurfaceBlocks& surface, const PolygonMesh& input,
                           std::span<const std::uint8_t> is_beside_folds, const PartOfFaces& parts)
    : surface_(surface),
      input_(input),
      is_beside_folds_(is_beside_folds),
      apexes_(input),
      parts_(parts) {
  PLANISH_ASSERT(surface.info().level >= 1 && surface.info().corners_per_face == 4);
  const std::vector<RowRange> pieces = swept_pieces(surface.info());
  if (!pieces.empty()) piece_size_ = pieces.front().count;
  of_pieces_.resize(pieces.size());
  runs_of_pieces_.resize(pieces.size());
}

void BlockQuality::add(RowRange piece, std::span<const glm::dvec3> positions,
                       std::span<const glm::vec3> normals) {
  thread_local QuadMeter measure;
  const auto number = static_cast<std::size_t>(piece.first / piece_size_);
  of_pieces_[number] = measure(input_, apexes_, is_beside_folds_, surface_, piece, positions,
                               normals, parts_, &runs_of_pieces_[number]);
}

SurfaceQuality BlockQuality::result() const {
  QualitySums all;
  for (const QualitySums& part : of_pieces_) all.add(part);
  return all.quality();
}

std::vector<PartSums> BlockQuality::parts() const {
  std::vector<PartSums> parts(static_cast<std::size_t>(parts_.count));
  for (const std::vector<Run>& runs : runs_of_pieces_) {
    for (const Run& run : runs) {
      PartSums& part = parts[run.part];
      part.area += run.sums.area;
      part.folded_elsewhere += run.sums.folded_elsewhere;
      part.bending += run.sums.bending;
    }
  }
  return parts;
}

void QualitySums::add(const QualitySums& later) {
  area += later.area;
  folded += later.folded;
  folded_elsewhere += later.folded_elsewhere;
  squares += later.squares;
  largest = std::max(largest, later.largest);
  bending += later.bending;
  places.add(later.places);
}

SurfaceQuality QualitySums::quality() const {
  SurfaceQuality quality;
  quality.max_normal_deviation = largest * kDegrees;
  quality.bending = bending;
  if (area > 0) {
    quality.folded_area = folded / area;
    quality.folded_area_elsewhere = folded_elsewhere / area;
    quality.folded_places = FoldedPlaces(places).take();
    quality.rms_normal_deviation = std::sqrt(squares / area) * kDegrees;
  }
  return quality;
}

QualitySums quality_sums(const SurfaceBlocks& surface, std::span<const RowRange> ranges,
                         const PolygonMesh& input, std::span<const std::uint8_t> is_beside_folds) {
  constexpr std::int64_t kPieceFaces = 4096;
  const ApexNormals apexes(input);
  QuadMeter measure;
  QualitySums all;
  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;
  for (const RowRange& range : ranges) {
    for (std::int64_t done = 0; done < range.count; done += kPieceFaces) {
      const RowRange piece{range.first + done, std::min(kPieceFaces, range.count - done)};
      positions.resize(static_cast<std::size_t>(4 * piece.count));
      normals.resize(positions.size());
      surface.corners(piece, positions, normals);
      all.add(measure(input, apexes, is_beside_folds, surface, piece, positions, normals));
    }
  }
  return all;
}

namespace {

// The whole surface.
void sweep(const SurfaceBlocks& surface, BlockQuality& quality, const Callbacks& callbacks) {
  const std::vector<RowRange> pieces = swept_pieces(surface.info());
  // At level 1 the quads of a range share their points, so that long ones make fewer of them.
  const std::size_t together = surface.info().level == 1 ? kSharedPieces : 1;
  const std::size_t range_count = (pieces.size() + together - 1) / together;
  const HostScope host(callbacks);
  LoopProgress progress(callbacks, "measure", 0, 1, static_cast<std::int64_t>(range_count));
  parallel_for(range_count, 1, [&](std::size_t begin, std::size_t end) {
    RawVector<glm::dvec3> positions;
    RawVector<glm::vec3> normals;
    for (std::size_t i = begin; i < end; ++i) {
      const auto some =
          std::span(pieces).subspan(i * together, std::min(together, pieces.size() - i * together));
      const std::int64_t first = some.front().first;
      const RowRange faces{first, some.back().first + some.back().count - first};
      positions.resize(static_cast<std::size_t>(4 * faces.count));
      normals.resize(positions.size());
      surface.corners(faces, positions, normals);
      for (const RowRange& piece : some) {
        const auto at = static_cast<std::size_t>(4 * (piece.first - first)),
                   count = static_cast<std::size_t>(4 * piece.count);
        quality.add(piece, std::span(positions).subspan(at, count),
                    std::span(normals).subspan(at, count));
      }
      progress.add();
    }
  });
  callbacks.report("measure", 1);
}

}  // namespace

SurfaceQuality surface_quality(const SurfaceBlocks& surface, const PolygonMesh& input,
                               std::span<const std::uint8_t> is_beside_folds,
                               const Callbacks& callbacks) {
  BlockQuality quality(surface, input, is_beside_folds);
  sweep(surface, quality, callbacks);
  return quality.result();
}

PartQuality quality_of_parts(const SurfaceBlocks& surface, const PolygonMesh& input,
                             std::span<const std::uint8_t> is_beside_folds,
                             const PartOfFaces& parts, const Callbacks& callbacks) {
  BlockQuality quality(surface, input, is_beside_folds, parts);
  sweep(surface, quality, callbacks);
  return {quality.result(), quality.parts()};
}

namespace {

constexpr std::size_t kGapGrain = 64;
constexpr int kHalf = 8;  // steps from an end to the middle of an edge

using Curve = std::array<glm::dvec3, 2 * kHalf + 1>;

// A side of a face over one of the edges.
struct Side {
  std::int64_t edge;    // its place in the list
  std::int32_t corner;  // where it begins
};

std::vector<Side> sides_on(const LimitSurface& surface,
                           std::span<const std::int32_t> source_vertices,
                           std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::int32_t> given = surface.surface().used().vertices;
  const auto source_of = [&](std::int32_t corner) {
    return source_vertices[given[topology.vertex_of(corner)]];
  };
  std::vector<Side> sides;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    if (topology.twin(c) >= 0) continue;
    const std::int32_t v = source_of(c), w = source_of(topology.next(c));
    const std::pair<std::int32_t, std::int32_t> ends(std::min(v, w), std::max(v, w));
    const auto place = std::ranges::lower_bound(edges, ends);
    if (place != edges.end() && *place == ends) sides.push_back({place - edges.begin(), c});
  }
  std::ranges::stable_sort(sides, {}, &Side::edge);
  return sides;
}

// The boundary of the surface over a side, from its middle to both ends by (u, 0) and (0, v).
Curve curve_over(const LimitSurface& surface, std::int32_t corner) {
  const MeshTopology& topology = surface.topology();
  const std::int32_t next = topology.next(corner);
  Curve curve;
  for (int i = 0; i <= kHalf; ++i) {
    const double at = static_cast<double>(i) / kHalf;
    curve[i] = surface.evaluate(surface_parameter(topology, corner, at, 0)).position;
    curve[2 * kHalf - i] = surface.evaluate(surface_parameter(topology, next, 0, at)).position;
  }
  return curve;
}

double distance_to(const Curve& curve, const glm::dvec3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const glm::dvec3 along = curve[i] - curve[i - 1], to = point - curve[i - 1];
    const double square = glm::dot(along, along);
    const double t = square > 0 ? std::clamp(glm::dot(to, along) / square, 0.0, 1.0) : 0;
    least = std::min(least, glm::length(to - t * along));
  }
  return least;
}

double gap_between(const Curve& a, const Curve& b) {
  double gap = 0;
  for (const glm::dvec3& point : a) gap = std::max(gap, distance_to(b, point));
  for (const glm::dvec3& point : b) gap = std::max(gap, distance_to(a, point));
  return gap;
}

}  // namespace

double sheet_gap(const LimitSurface& surface, std::span<const std::int32_t> source_vertices,
                 std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  const std::vector<Side> sides = sides_on(surface, source_vertices, edges);
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (i == 0 || sides[i].edge != sides[i - 1].edge) starts.push_back(i);
  std::vector<double> gaps(starts.size(), 0);
  parallel_each(starts.size(), kGapGrain, [&](std::size_t e) {
    const std::size_t last = e + 1 < starts.size() ? starts[e + 1] : sides.size();
    const Curve first = curve_over(surface, sides[starts[e]].corner);
    for (std::size_t i = starts[e] + 1; i < last; ++i)
      gaps[e] = std::max(gaps[e], gap_between(first, curve_over(surface, sides[i].corner)));
  });
  return gaps.empty() ? 0 : *std::ranges::max_element(gaps);
}

}  // namespace planish
