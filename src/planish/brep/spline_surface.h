#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/brep/square_piece.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/placement.h"

namespace planish {

/// A corner's patch, over its quad of Q_1: from its vertex V at (0, 0) to its face's centre F at
/// (1, 1), u along the leading edge. All points are in unit coordinates (see Placement).
class SplinePatch {
 public:
  /// A place where no polynomial is, however small: V, or F.
  struct End {
    bool is_face = false;
    glm::dvec3 limit{};
  };
  struct Point {
    glm::dvec3 position{}, normal{};  ///< the normal not of unit length
  };

  virtual ~SplinePatch() = default;
  virtual void move_to(std::int32_t corner) = 0;
  /// The surface itself, at ends too.
  [[nodiscard]] virtual Point at(double u, double v) = 0;
  /// Adds the polynomials that cover the patch but for squares of 2^-depth at its ends, and these.
  /// `depths`: at V and F, at least 1.
  virtual void add_pieces(const std::array<int, 2>& depths, std::vector<SquarePiece>& pieces,
                          std::vector<End>& ends) = 0;
};

/// A surface that consists of tensor-product polynomials, those of regular quads of Q_1 and, at
/// extraordinary points, those of squares that halve: C1 of degree 2, or C2 of degree 3.
class SplineSurface {
 public:
  virtual ~SplineSurface() = default;
  [[nodiscard]] virtual std::size_t degree() const = 0;
  [[nodiscard]] virtual const MeshTopology& topology() const = 0;
  [[nodiscard]] virtual const Placement& placement() const = 0;
  /// One flag a face where some are not shown, else nothing.
  [[nodiscard]] virtual std::span<const std::uint8_t> hidden() const = 0;
  /// Of a corner's leading edge: whether normals jump there.
  [[nodiscard]] virtual bool is_sharp(std::int32_t corner) const = 0;
  /// Whether no polynomial is at a corner's vertex, however small.
  [[nodiscard]] virtual bool is_singular_at_vertex(std::int32_t corner) const = 0;
  /// Which can be moved; must not outlive the surface.
  [[nodiscard]] virtual std::unique_ptr<SplinePatch> patch() const = 0;
};

}  // namespace planish
