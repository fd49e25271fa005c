#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/patch_class.h"
#include "planish/patches/patch_step.h"

namespace planish {

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

}  // namespace planish
