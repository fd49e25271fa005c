#include "planish/surface/derivative_curvatures.h"

#include <algorithm>

#include "planish/core/assert.h"
#include "planish/patches/patch_curvature.h"
#include "planish/patches/patch_form.h"
#include "planish/patches/patch_numbering.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

constexpr std::int64_t kCornersAPiece = 256;

struct Sum {
  double mean = 0, gaussian = 0;
  std::int32_t count = 0;
};

class CurvatureSums {
 public:
  CurvatureSums(const DooSabinSurface& surface, const SurfaceMesh& tessellation)
      : surface_(surface),
        topology_(surface.topology()),
        numbering_(surface.patches(), tessellation.level, surface.hidden()),
        forms_(surface.weights()),
        side_(1 << (std::max(tessellation.level, 1) - 1)),
        sums_(tessellation.positions.size()) {
    PLANISH_ASSERT(numbering_.row_count() == static_cast<std::int64_t>(sums_.size()));
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c)
      (void)forms_.of(surface.patches().corner_patch(c).patch);
  }

  const std::vector<Sum>& run() {
    in_order<Piece>(
        ranges_of(topology_.corner_count(), kCornersAPiece),
        [&](RowRange corners, Piece& piece) {
          piece.sums.clear();
          for (std::int64_t c = corners.first; c < corners.first + corners.count; ++c)
            add_corner(static_cast<std::int32_t>(c), piece);
        },
        [&](RowRange, const Piece& piece) {
          for (const auto& [row, sum] : piece.sums) {
            sums_[row].mean += sum.mean;
            sums_[row].gaussian += sum.gaussian;
            sums_[row].count += sum.count;
          }
        });
    return sums_;
  }

 private:
  struct Piece {
    std::vector<std::pair<std::size_t, Sum>> sums;
    std::vector<std::int32_t> indices, rows;
    std::vector<glm::dvec3> points;
    PatchScratch scratch;
  };

  void add_corner(std::int32_t corner, Piece& piece) const {
    if (numbering_.is_hidden(topology_.face_of(corner))) return;
    const PatchPlace place = surface_.patches().corner_patch(corner);
    piece.indices.resize(static_cast<std::size_t>(place.patch.column_count()));
    surface_.patches().gather(place, piece.indices.data(), 1);
    piece.points.clear();
    const glm::dvec3 own = surface_.state()[piece.indices[0]];
    for (const std::int32_t i : piece.indices) piece.points.push_back(surface_.state()[i] - own);
    const PatchForm& form = forms_.known(place.patch);
    const bool only_vertex = numbering_.level() == 0;
    if (only_vertex) {
      piece.rows = {numbering_.vertex_row(corner)};
    } else {
      const auto row_count = static_cast<std::size_t>(side_) + 1;
      piece.rows.resize(row_count * row_count);
      numbering_.grid(corner, piece.rows.data());
    }
    for (std::int32_t b = 0; b <= (only_vertex ? 0 : side_); ++b) {
      for (std::int32_t a = 0; a <= (only_vertex ? 0 : side_); ++a) {
        const auto row = static_cast<std::size_t>(piece.rows[b * (side_ + 1) + a]);
        piece.sums.emplace_back(row, around(form, piece, a, b));
      }
    }
  }

  // Over the cells of the corner's grid that meet at a sample, each seen from its own quarter at
  // the sample, which lies in one polynomial.
  Sum around(const PatchForm& form, Piece& piece, std::int32_t a, std::int32_t b) const {
    Sum sum;
    for (const std::int32_t i : {-1, 1}) {
      for (const std::int32_t j : {-1, 1}) {
        if (a + i < 0 || a + i > side_ || b + j < 0 || b + j > side_) continue;
        const PatchParameter at(double(a) / side_, double(b) / side_, (a + 0.25 * i) / side_,
                                (b + 0.25 * j) / side_);
        const PointCurvature curvature =
            curvature_of(patch_point(form, piece.points, at, piece.scratch));
        if (!curvature.is_known) continue;
        sum.mean += curvature.mean;
        sum.gaussian += curvature.gaussian;
        ++sum.count;
      }
    }
    return sum;
  }

  const DooSabinSurface& surface_;
  const MeshTopology& topology_;
  PatchNumbering numbering_;
  PatchForms forms_;
  std::int32_t side_;  // cells along a patch
  std::vector<Sum> sums_;
};

}  // namespace

Curvatures curvatures_of_derivatives(const DooSabinSurface& surface,
                                     const SurfaceMesh& tessellation, Curvatures elsewhere) {
  Curvatures result = std::move(elsewhere);
  CurvatureSums sums(surface, tessellation);
  const double unit = surface.placement().diagonal;
  const std::vector<Sum>& rows = sums.run();
  for (std::size_t v = 0; v < rows.size(); ++v) {
    if (rows[v].count == 0) continue;
    result.mean[v] = static_cast<float>(rows[v].mean / rows[v].count / unit);
    result.gaussian[v] = static_cast<float>(rows[v].gaussian / rows[v].count / (unit * unit));
  }
  return result;
}

}  // namespace planish
