#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/patches/bezier_net.h"
#include "planish/patches/patch_form.h"
#include "planish/queries/limit_surface.h"

namespace planish {

/// How far triangles between places of a piece, whatever places, may be from it, and how much the
/// piece turns. Bounds: never too small.
struct CellBound {
  double distance = 0;     ///< between triangles and surface, both ways
  double turn = 0;         ///< between any two normals, radians; pi where it cannot be told
  bool u_is_worse = true;  ///< a split across u lowers the bound more
  /// Parts of `distance` by S_uu and S_vv, along the normal where there is one; of polynomials.
  double by_uu = 0, by_vv = 0;

  /// Not more than the bound in a part, about, where so many are made along u and along v.
  [[nodiscard]] double distance_in(int u, int v) const {
    return std::max(by_uu / (u * u), by_vv / (v * v));
  }
};

/// Of a polynomial piece. Linear interpolation on triangles inside a rectangle is off by at most
/// (|S_uu| + 2 |S_uv| + |S_vv|) / 8, sides being 1 in length. Across the surface counts what of it
/// is along the normal, where S_uu and S_vv of different signs do not add up, and the rest times
/// the slope.
[[nodiscard]] CellBound bound_of(const BezierNet& net);

/// A part of a region that is one polynomial, and how many times as long as it the rectangles are
/// that lie anywhere in the region.
struct BoundPiece {
  BezierNet net;
  double u = 1, v = 1;
};
/// Most pieces of a region: one of each corner of a face.
inline constexpr std::size_t kMostPieces = 4;

/// The same for rectangles that may cross from piece to piece, between which the surface and its
/// first derivatives are continuous.
[[nodiscard]] CellBound bound_of(std::span<const BoundPiece> pieces);

/// Three Bezier points of a curve.
using BezierCurve = std::array<glm::dvec3, 3>;

/// The same of curves that run on into one another and of chords as long as one of them between any
/// two of their places.
[[nodiscard]] double curve_bound(std::span<const BezierCurve> curves);

/// Of a piece that is no polynomial but lies in the hull of these points, as its places do. Its
/// normals are among directions like `normals`; its sides leave their chords by `aside`.
[[nodiscard]] CellBound hull_bound(std::span<const glm::dvec3> points,
                                   std::span<const glm::dvec3> normals, double aside);

/// Largest angle between any two of these directions, from above: twice that from their mean; pi
/// where one of them has no length or they are all around.
[[nodiscard]] double spread_of(std::span<const glm::dvec3> directions);

/// Products of the derivatives' control vectors, in whose cone the normals lie.
void add_normals(const BezierNet& net, std::span<glm::dvec3, 36> normals);

/// About how many cells triangles within `distance` (unit coordinates) of the surface take, from
/// below: what its curvature along u and along v asks for, and a part of that, since cells may be
/// of any shape. One look at each corner. `hidden`: one flag a corner. The same bits for every
/// thread count.
[[nodiscard]] double fewest_cells(const LimitSurface& surface, std::span<const std::uint8_t> hidden,
                                  double distance);

/// Halvings of a corner along each side beyond which cells are refused, but for a third.
inline constexpr int kMaxHalvings = 13;
/// A corner's parameters as whole numbers: 0 to kCellSide along each side.
inline constexpr std::int32_t kCellSide = 3 << kMaxHalvings;

/// A rectangle of a corner's square.
struct AdaptiveCell {
  std::uint16_t u = 0, v = 0;          ///< its lower end, of kCellSide
  std::uint16_t end_u = 0, end_v = 0;  ///< and its upper one

  [[nodiscard]] std::int32_t size_u() const { return end_u - u; }
  [[nodiscard]] std::int32_t size_v() const { return end_v - v; }
};

/// What cells must keep; 0: not asked for.
struct CellLimits {
  double distance = 0;  ///< of triangles from the surface, in unit coordinates
  double turn = 0;      ///< between normals within a cell, radians
};

/// Where a corner's sides end the surface or cross a sharp edge: triangles must follow the curve.
struct CornerBorders {
  bool leading = false, trailing = false;
};

/// Throws Error{OutOfMemory} for more cells than that.
[[noreturn]] void refuse_count(std::uint64_t most);

/// Splits corners into cells until each keeps the limits.
class CellSplitter {
 public:
  /// Of at most so many cells at once.
  CellSplitter(const LimitSurface& surface, const PatchReaches& reaches, const CellLimits& limits,
               std::uint64_t most)
      : corner_(surface), reaches_(reaches), limits_(limits), most_(most) {}

  /// Appends a corner's cells, in the order in which they are split. Throws Error{InvalidArgument}
  /// where kMaxHalvings do not do, Error{OutOfMemory} beyond the most cells.
  void run(std::int32_t corner, const CornerBorders& borders, std::vector<AdaptiveCell>& cells);

 private:
  // How many parts a cell becomes along each side.
  struct Split {
    int u = 1, v = 1;
  };

  [[nodiscard]] bool keeps(const CellBound& bound, const AdaptiveCell& cell) const;
  [[nodiscard]] Split fewest_parts(const BezierNet& net, const CellBound& bound,
                                   const AdaptiveCell& cell) const;
  [[nodiscard]] Split split_of(const BezierNet& net, const AdaptiveCell& cell) const;
  [[nodiscard]] bool is_on_border(const AdaptiveCell& cell) const;
  [[nodiscard]] double limit_at(const AdaptiveCell& cell) const;
  [[nodiscard]] double border_bound(const AdaptiveCell& cell);
  [[nodiscard]] double sides_aside(const AdaptiveCell& cell);
  [[noreturn]] void refuse_depth() const;
  void emit(const AdaptiveCell& cell);
  void split_net(const BezierNet& net, const AdaptiveCell& cell);
  void split_form(const PatchForm& form, std::span<const glm::dvec3> points, int turns,
                  const AdaptiveCell& cell);

  LimitSurface::Corner corner_;
  const PatchReaches& reaches_;
  CellLimits limits_;
  std::uint64_t most_;
  CornerBorders borders_;
  std::int32_t number_ = -1;
  std::vector<AdaptiveCell>* cells_ = nullptr;
};

/// Even cuts of a whole face with four corners, into so many parts along its first and along its
/// second edge; none: each corner has cells of its own.
struct FaceGrid {
  std::uint8_t u = 0, v = 0;

  [[nodiscard]] bool exists() const { return u > 0; }
  [[nodiscard]] int parts_of_side(int side) const { return side % 2 == 0 ? u : v; }
  [[nodiscard]] std::int32_t inside() const { return exists() ? (u - 1) * (v - 1) : 0; }
};

/// Whether other faces share no more with a face than one edge, or one vertex: only then may
/// triangles join places of its different edges, since no others join the same.
[[nodiscard]] bool stands_alone(const MeshTopology& topology, std::int32_t face);

/// Finds grids of faces: so that triangles between their places keep a distance, whatever places
/// the sides have, as long as these are as near to each other as the grid's own.
class GridFinder {
 public:
  explicit GridFinder(const LimitSurface& surface) : corner_(surface), surface_(surface) {}

  /// What is asked of a face.
  struct Limits {
    double distance = 0;            ///< of triangles from the surface, in unit coordinates
    double turn = 0;                ///< between normals beneath a triangle, radians; 0: any
    std::array<bool, 4> borders{};  ///< sides that triangles must follow as curves
    int most = 0;                   ///< parts
  };
  /// One of the fewest parts; none where a corner is no polynomial, or within `most` parts.
  [[nodiscard]] FaceGrid find(std::int32_t face, const Limits& limits);

 private:
  // A rectangle of the face, of 0 to 2 along each side.
  struct Region {
    double u0, v0, u1, v1;
  };
  [[nodiscard]] bool take_nets(std::int32_t face);
  [[nodiscard]] bool keeps(int u, int v);
  [[nodiscard]] bool keeps_in(const Region& region, double size_u, double size_v) const;
  [[nodiscard]] bool keeps_borders(int u, int v) const;
  [[nodiscard]] bool is_slim(int u, int v) const;

  LimitSurface::Corner corner_;
  const LimitSurface& surface_;
  Limits limits_;
  std::array<BezierNet, 4> nets_;  // of the corners, as the first one sees them
  double length_u_ = 0, length_v_ = 0;
};

/// The cells of all corners, and the grids of those faces that have one instead.
struct AdaptiveCells {
  std::vector<std::int64_t> first;  ///< corner_count + 1
  RawVector<AdaptiveCell> cells;
  std::vector<std::uint8_t> hidden;  ///< one a corner: of a hole, without cells
  std::vector<FaceGrid> grids;       ///< one a face

  [[nodiscard]] std::span<const AdaptiveCell> of(std::int32_t corner) const {
    const auto c = static_cast<std::size_t>(corner);
    return std::span(cells).subspan(static_cast<std::size_t>(first[c]),
                                    static_cast<std::size_t>(first[c + 1] - first[c]));
  }
};

/// On all threads, the same for every thread count. Throws as CellSplitter,
/// Error{OutOfMemory} before cells and what is made of them take more than `memory_limit_bytes`.
/// Callbacks: step "evaluate".
[[nodiscard]] AdaptiveCells make_cells(const LimitSurface& surface, const CellLimits& limits,
                                       std::uint64_t memory_limit_bytes,
                                       const Callbacks& callbacks = {});

}  // namespace planish
