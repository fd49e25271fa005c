#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/limit/cell_bound.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"

namespace planish {

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

}  // namespace planish
