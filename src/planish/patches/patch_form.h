#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/patches/patch_mesh.h"

namespace planish {

/// A weighted sum of vectors, x and y in one register: the bits of the sums of each coordinate, in
/// two thirds of the instructions.
class VectorSum {
 public:
  void add(double weight, const glm::dvec3& vector) {
    Pair pair;
    std::memcpy(&pair, &vector.x, sizeof pair);
    xy_ += weight * pair;
    z_ += weight * vector.z;
  }
  void add(double weight, const VectorSum& other) {
    xy_ += weight * other.xy_;
    z_ += weight * other.z_;
  }
  [[nodiscard]] glm::dvec3 value() const { return {xy_[0], xy_[1], z_}; }

 private:
  typedef double Pair __attribute__((vector_size(16)));

  Pair xy_{0, 0};
  double z_ = 0;
};

class PatchRings;

/// Rows of weights that are mostly zeros: how points follow from a patch's control points.
struct PatchRows {
  std::vector<std::int32_t> offsets{0};  ///< row_count + 1
  std::vector<std::int32_t> columns;
  std::vector<double> weights;

  [[nodiscard]] bool empty() const { return columns.empty(); }
  [[nodiscard]] std::size_t row_count() const { return offsets.size() - 1; }
  void end_row() { offsets.push_back(static_cast<std::int32_t>(columns.size())); }
  void add(std::int32_t column, double weight);
  [[nodiscard]] VectorSum combine(std::size_t row, const glm::dvec3* points) const {
    VectorSum sum;
    for (auto i = static_cast<std::size_t>(offsets[row]);
         i < static_cast<std::size_t>(offsets[row + 1]); ++i)
      sum.add(weights[i], points[columns[i]]);
    return sum;
  }
};

/// How the points of a patch's quarter follow from the patch's K. Every point of a ring of n has
/// weights of all n, but they are a few sums of the ring and little more: so large rings have a few
/// entries a row instead of n.
struct PatchStep {
  PatchRows sums;  ///< of the patch's points; none where rings are small
  PatchRows rows;  ///< column K + i is sum i

  /// The quarter's points, of `points` (K).
  void apply(std::span<const glm::dvec3> points, std::vector<glm::dvec3>& result) const;
};

/// The step to quarter 0 to 3 of a patch of `column_count` control points.
[[nodiscard]] PatchStep make_step(const PatchRings& rings, int quarter, const FaceWeights& weights,
                                  std::int32_t column_count);

/// Dense rows over the points that `map` makes, as rows over the `columns` that it takes.
[[nodiscard]] std::vector<double> pulled_back(std::span<const double> rows, const PatchRows& map,
                                              std::size_t columns);
[[nodiscard]] std::vector<double> pulled_back(std::span<const double> rows, const PatchStep& step,
                                              std::size_t columns);

/// A point of a patch with its derivatives by the patch's u and v, in the control points' unit.
struct PatchPoint {
  glm::dvec3 position{}, du{}, dv{}, duu{}, duv{}, dvv{};
  /// Along du x dv or, at a vertex or face centre where no polynomial is, along the exact tangents'
  /// product; not of unit length.
  glm::dvec3 normal{};
  /// False at such vertices and centres, where second derivatives have no limit. They are 0 there;
  /// du and dv are the derivatives along the leading and the trailing edge.
  bool has_second = true;

  /// The same point by parameters of which u = factor (c s' + s t'), v = factor (-s s' + c t'), for
  /// quarter turns: one of c and s is 0, the other 1 or -1.
  [[nodiscard]] PatchPoint turned(int c, int s, double factor) const;
};

/// What a class's patches are as functions of (u, v): biquadratic where all rings are regular, else
/// quarters, each a patch of a class with control points of its own after a step. See PatchClass.
/// A quarter is seen from its own corner: (u, v) become (2u, 2v), (2v, 2 - 2u), (2 - 2u, 2 - 2v)
/// and (2 - 2v, 2u) at V, E1, F and E2.
struct PatchForm {
  PatchClass patch;
  std::int32_t column_count = 0;  ///< K
  /// The points (i, j) of the B-spline's net, row i + 3 j, i along u. Empty where the patch is not
  /// one polynomial.
  PatchRows net;
  /// Else the forms of the quarters, and the maps to their points.
  std::array<const PatchForm*, 4> quarters{};
  std::array<PatchStep, 4> steps;
  /// At V: the limit point, tangents that span its plane, and the derivatives along the leading and
  /// the trailing edge; 5 x K, where the patch is not one polynomial.
  std::vector<double> corner;

  std::int32_t halvings = 0;  ///< towards V after which `corner` stands in

  [[nodiscard]] bool is_polynomial() const { return !net.empty(); }
  /// Whether (0, 0) lies in no polynomial, however small.
  [[nodiscard]] bool is_singular_at_vertex() const {
    return !is_polynomial() && !quarters[0]->is_polynomial();
  }
};

/// The forms of all classes that a surface has.
class PatchForms {
 public:
  explicit PatchForms(Weights weights) : weights_(weights) {}

  /// Made when first asked for, with all that it leads to; stays where it is. Not from several
  /// threads at once.
  [[nodiscard]] const PatchForm& of(const PatchClass& patch);
  /// One that has been asked for.
  [[nodiscard]] const PatchForm& known(const PatchClass& patch) const { return *forms_.at(patch); }
  /// The most control points of a form.
  [[nodiscard]] std::int32_t largest_count() const { return largest_count_; }

 private:
  void make_corner(PatchForm& form) const;

  FaceWeights weights_;
  std::map<PatchClass, std::unique_ptr<PatchForm>> forms_;
  std::int32_t largest_count_ = 0;
};

/// The control points of a patch's quarter, relative to the same point as the patch's.
void quarter_points(const PatchForm& form, int quarter, std::span<const glm::dvec3> points,
                    std::vector<glm::dvec3>& result);

/// Room for the points of two patches, used again from call to call.
struct PatchScratch {
  std::vector<glm::dvec3> points, next;
};

/// A place in a patch, and where it is seen from: derivatives are those of the polynomial in which
/// (towards_u, towards_v) lies, which must be one that the place borders on.
struct PatchParameter {
  double u = 0, v = 0, towards_u = 0, towards_v = 0;

  PatchParameter(double at_u, double at_v) : PatchParameter(at_u, at_v, at_u, at_v) {}
  PatchParameter(double at_u, double at_v, double seen_u, double seen_v)
      : u(at_u), v(at_v), towards_u(seen_u), towards_v(seen_v) {}
};

/// The point of a patch at (u, v) in [0, 1]^2. `points` are its control points relative to the own
/// one, which is the first; so is the result. Values and derivatives are as exact as double allows
/// down to 2^-27 from V or F (2^-50 with averaged weights), where those at V or F stand in.
[[nodiscard]] PatchPoint patch_point(const PatchForm& form, std::span<const glm::dvec3> points,
                                     PatchParameter at, PatchScratch& scratch);

/// Weights of the control points (own one included) in patch_point()'s position, du and dv: three
/// rows of K, positions' summing to 1.
[[nodiscard]] std::vector<double> patch_weights(const PatchForm& form, double u, double v);

/// Curvatures at a point, in one over the unit of its position (Gaussian: over its square). They
/// are positive where the surface bends away from its normal: 1/R on a sphere of radius R with
/// outward normals.
struct PointCurvature {
  double mean = 0, gaussian = 0;
  double largest = 0, smallest = 0;  ///< principal ones
  /// Unit tangents along which they are; any two where both are the same.
  glm::dvec3 largest_direction{}, smallest_direction{};
  bool is_known = false;  ///< second derivatives exist, and du and dv are not parallel
};

[[nodiscard]] PointCurvature curvature_of(const PatchPoint& point);

struct PatchBox {
  glm::dvec3 low, high;

  void add(const glm::dvec3& point);
};

/// Around points; low above high where there are none.
[[nodiscard]] PatchBox box_of(std::span<const glm::dvec3> points);

/// Of a point from a box with `low` and `high`; 0 inside.
template <class Box>
[[nodiscard]] double square_distance(const Box& box, const glm::dvec3& point) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) {
    const double off = std::max({box.low[d] - point[d], point[d] - box.high[d], 0.0});
    sum += off * off;
  }
  return sum;
}

/// How far patches of a form may leave the box of their control points: the box times this, about
/// its middle, holds them. 1 where no weight is negative.
[[nodiscard]] double patch_reach(const PatchForm& form);

/// Reaches of forms, made once.
class PatchReaches {
 public:
  /// For the form and those of its quarters.
  void add(const PatchForm& form);
  [[nodiscard]] double of(const PatchForm& form) const { return reaches_.at(&form); }

 private:
  std::map<const PatchForm*, double> reaches_;
};

/// Around a patch of such a reach, by its control points.
[[nodiscard]] PatchBox box_around(std::span<const glm::dvec3> points, double reach);

/// A box around a patch: that of the Bezier points of its polynomial, or of its quarters' where it
/// is none, and of the control points of those quarters that are none.
[[nodiscard]] PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                                 const PatchReaches& reaches);

/// Boxes around a patch's quarters, at V, E1, F and E2.
[[nodiscard]] std::array<PatchBox, 4> quarter_boxes(const PatchForm& form,
                                                    std::span<const glm::dvec3> points,
                                                    const PatchReaches& reaches,
                                                    std::vector<glm::dvec3>& scratch);

}  // namespace planish
