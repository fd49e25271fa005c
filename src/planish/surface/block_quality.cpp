#include "planish/surface/block_quality.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/area_vector.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/quad_figures.h"

namespace planish {

struct BlockQuality::Sums {
  double area = 0, folded = 0, folded_elsewhere = 0, squares = 0, largest = 0, bending = 0;
  FoldedPlaces places;

  void add(const Sums& other) {
    area += other.area;
    folded += other.folded;
    folded_elsewhere += other.folded_elsewhere;
    squares += other.squares;
    largest = std::max(largest, other.largest);
    bending += other.bending;
    places.add(other.places);
  }
};

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

using Sums = BlockQuality::Sums;

// Measures one range of quads after another; keeps its memory.
class QuadMeter {
 public:
  Sums operator()(const PolygonMesh& input, std::span<const std::uint8_t> is_beside_folds,
                  const SurfaceBlocks& surface, RowRange faces,
                  std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals) {
    input_ = &input;
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
      // A face without an area has no normal to deviate from.
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
  }

  void add_fold(std::size_t face, double area, Sums& sums) const {
    const std::int32_t ancestor = ancestors_[face];
    const bool is_elsewhere = is_beside_folds_.empty() || is_beside_folds_[ancestor] == 0;
    sums.folded += area;
    if (is_elsewhere) sums.folded_elsewhere += area;
    const glm::dvec3* const corners = positions_.data() + 4 * face;
    sums.places.add({ancestor, 0.25 * (corners[0] + corners[1] + corners[2] + corners[3])},
                    is_elsewhere);
  }

  void add(std::size_t face, int i, Sums& sums) const {
    sums.area += figures_.area[i];
    if (figures_.folded[i] > 0) add_fold(face, figures_.folded[i], sums);
    sums.squares += figures_.squares[i];
    sums.largest = std::max(sums.largest, figures_.largest[i]);
    sums.bending += figures_.bending[i];
  }

  const PolygonMesh* input_ = nullptr;
  std::span<const std::uint8_t> is_beside_folds_;
  std::span<const glm::dvec3> positions_;
  std::span<const glm::vec3> normals_;
  RawVector<std::int32_t> ancestors_;
  std::int32_t ancestor_ = -1;
  bool has_normal_ = false;
  glm::dvec3 wanted_{0.0};
  QuadBatch batch_;
  QuadFigures figures_;
};

}  // namespace

BlockQuality::BlockQuality(const SurfaceBlocks& surface, const PolygonMesh& input,
                           std::span<const std::uint8_t> is_beside_folds)
    : surface_(surface), input_(input), is_beside_folds_(is_beside_folds) {
  PLANISH_ASSERT(surface.info().level >= 1 && surface.info().corners_per_face == 4);
  const std::vector<RowRange> pieces = swept_pieces(surface.info());
  if (!pieces.empty()) piece_size_ = pieces.front().count;
  of_pieces_.resize(pieces.size());
}

BlockQuality::~BlockQuality() = default;

void BlockQuality::add(RowRange piece, std::span<const glm::dvec3> positions,
                       std::span<const glm::vec3> normals) {
  thread_local QuadMeter measure;
  of_pieces_[static_cast<std::size_t>(piece.first / piece_size_)] =
      measure(input_, is_beside_folds_, surface_, piece, positions, normals);
}

SurfaceQuality BlockQuality::result() const {
  Sums all;
  for (const Sums& part : of_pieces_) all.add(part);
  SurfaceQuality quality;
  quality.max_normal_deviation = all.largest * kDegrees;
  quality.bending = all.bending;
  if (all.area > 0) {
    quality.folded_area = all.folded / all.area;
    quality.folded_area_elsewhere = all.folded_elsewhere / all.area;
    quality.folded_places = all.places.take();
    quality.rms_normal_deviation = std::sqrt(all.squares / all.area) * kDegrees;
  }
  return quality;
}

SurfaceQuality surface_quality(const SurfaceBlocks& surface, const PolygonMesh& input,
                               std::span<const std::uint8_t> is_beside_folds,
                               const Callbacks& callbacks) {
  BlockQuality quality(surface, input, is_beside_folds);
  const std::vector<RowRange> pieces = swept_pieces(surface.info());
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    RawVector<glm::dvec3> positions;
    RawVector<glm::vec3> normals;
    for (std::size_t i = begin; i < end; ++i) {
      callbacks.check_cancelled();
      positions.resize(static_cast<std::size_t>(4 * pieces[i].count));
      normals.resize(positions.size());
      surface.corners(pieces[i], positions, normals);
      quality.add(pieces[i], positions, normals);
    }
  });
  return quality.result();
}

}  // namespace planish
