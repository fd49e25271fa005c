#include "planish/limit/patch_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "planish/limit/bezier_net.h"

namespace planish {
namespace {

constexpr int kSamples = 16;      // along a patch, for the largest sum of weights
constexpr double kMargin = 1.02;  // between samples, where there are negative weights

// Around a patch that is one polynomial, or one that is left whole.
PatchBox box_of_form(const PatchForm& form, std::span<const glm::dvec3> points,
                     const PatchReaches& reaches) {
  return form.is_polynomial() ? box_of(bezier_net(form, points))
                              : box_around(points, reaches.of(form));
}

}  // namespace

void PatchBox::add(const glm::dvec3& point) {
  for (int d = 0; d < 3; ++d) {
    low[d] = std::min(low[d], point[d]);
    high[d] = std::max(high[d], point[d]);
  }
}

PatchBox box_of(std::span<const glm::dvec3> points) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PatchBox box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (const glm::dvec3& p : points) box.add(p);
  return box;
}

PatchBox box_around(std::span<const glm::dvec3> points, double reach) {
  const PatchBox box = box_of(points);
  const glm::dvec3 middle = 0.5 * (box.low + box.high), half = 0.5 * reach * (box.high - box.low);
  return {middle - half, middle + half};
}

double patch_reach(const PatchForm& form) {
  const auto count = static_cast<std::size_t>(form.column_count);
  double most = 1;
  for (int b = 0; b <= kSamples; ++b) {
    for (int a = 0; a <= kSamples; ++a) {
      const std::vector<double> rows =
          patch_weights(form, double(a) / kSamples, double(b) / kSamples);
      double sum = 0;
      for (std::size_t k = 0; k < count; ++k) sum += std::abs(rows[k]);
      most = std::max(most, sum);
    }
  }
  return most > 1 + 1e-9 ? kMargin * most : 1 + 1e-12;
}

void PatchReaches::add(const PatchForm& form) {
  if (form.is_polynomial() || reaches_.contains(&form)) return;
  reaches_[&form] = patch_reach(form);
  for (const PatchForm* quarter : form.quarters) add(*quarter);
}

std::array<PatchBox, 4> quarter_boxes(const PatchForm& form, std::span<const glm::dvec3> points,
                                      const PatchReaches& reaches,
                                      std::vector<glm::dvec3>& scratch) {
  std::array<PatchBox, 4> boxes;
  if (form.is_polynomial()) {
    const BezierNet whole = bezier_net(form, points);
    for (int q = 0; q < 4; ++q) boxes[q] = box_of(net_quarter(whole, q == 1 || q == 2, q >= 2));
    return boxes;
  }
  for (int q = 0; q < 4; ++q) {
    quarter_points(form, q, points, scratch);
    boxes[q] = box_of_form(*form.quarters[q], scratch, reaches);
  }
  return boxes;
}

PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                   const PatchReaches& reaches) {
  if (form.is_polynomial()) return box_of_form(form, points, reaches);
  std::vector<glm::dvec3> scratch;
  PatchBox box = box_of({});
  for (const PatchBox& quarter : quarter_boxes(form, points, reaches, scratch)) {
    box.add(quarter.low);
    box.add(quarter.high);
  }
  return box;
}

}  // namespace planish
