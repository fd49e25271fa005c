#include "planish/limit/patch_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace planish {
namespace {

constexpr int kSamples = 16;      // along a patch, for the largest sum of weights
constexpr double kMargin = 1.02;  // between samples, where there are negative weights

PatchBox empty_box() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {glm::dvec3(kFar), glm::dvec3(-kFar)};
}

void add_form(const PatchForm& form, std::span<const glm::dvec3> points, double reach,
              PatchBox& box) {
  if (form.is_polynomial()) {
    std::array<glm::dvec3, 9> bezier;
    bezier_points(form, points, bezier);
    for (const glm::dvec3& p : bezier) box.add(p);
    return;
  }
  PatchBox own = empty_box();
  for (const glm::dvec3& p : points) own.add(p);
  const glm::dvec3 middle = 0.5 * (own.low + own.high), half = 0.5 * reach * (own.high - own.low);
  box.add(middle - half);
  box.add(middle + half);
}

}  // namespace

void PatchBox::add(const glm::dvec3& point) {
  for (int d = 0; d < 3; ++d) {
    low[d] = std::min(low[d], point[d]);
    high[d] = std::max(high[d], point[d]);
  }
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

void bezier_points(const PatchForm& form, std::span<const glm::dvec3> points,
                   std::span<glm::dvec3, 9> bezier) {
  for (std::size_t i = 0; i < 9; ++i) bezier[i] = form.net.combine(i, points.data()).value();
  // B-spline to Bezier along u, then along v: midpoints at the ends.
  const auto convert = [&](std::size_t first, std::size_t step) {
    const glm::dvec3 middle = bezier[first + step];
    bezier[first] = 0.5 * (bezier[first] + middle);
    bezier[first + 2 * step] = 0.5 * (middle + bezier[first + 2 * step]);
  };
  for (std::size_t i = 0; i < 3; ++i) convert(3 * i, 1);
  for (std::size_t i = 0; i < 3; ++i) convert(i, 3);
}

// De Casteljau's halves of three points that are `step` apart.
void halve(std::span<glm::dvec3, 9> net, std::size_t first, std::size_t step, bool upper) {
  const glm::dvec3 a = net[first], b = net[first + step], c = net[first + 2 * step];
  const glm::dvec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), middle = 0.5 * (ab + bc);
  net[first] = upper ? middle : a;
  net[first + step] = upper ? bc : ab;
  net[first + 2 * step] = upper ? c : middle;
}

void bezier_quarter(std::span<glm::dvec3, 9> net, bool upper_u, bool upper_v) {
  for (std::size_t j = 0; j < 3; ++j) halve(net, 3 * j, 1, upper_u);
  for (std::size_t i = 0; i < 3; ++i) halve(net, i, 3, upper_v);
}

std::array<PatchBox, 4> quarter_boxes(const PatchForm& form, std::span<const glm::dvec3> points,
                                      const PatchReaches& reaches,
                                      std::vector<glm::dvec3>& scratch) {
  std::array<PatchBox, 4> boxes;
  boxes.fill(empty_box());
  if (form.is_polynomial()) {
    std::array<glm::dvec3, 9> whole;
    bezier_points(form, points, whole);
    for (int q = 0; q < 4; ++q) {
      std::array<glm::dvec3, 9> part = whole;
      bezier_quarter(part, q == 1 || q == 2, q >= 2);
      for (const glm::dvec3& p : part) boxes[q].add(p);
    }
    return boxes;
  }
  for (int q = 0; q < 4; ++q) {
    const PatchForm& quarter = *form.quarters[q];
    quarter_points(form, q, points, scratch);
    add_form(quarter, scratch, quarter.is_polynomial() ? 1 : reaches.of(quarter), boxes[q]);
  }
  return boxes;
}

PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                   const PatchReaches& reaches) {
  PatchBox box = empty_box();
  if (form.is_polynomial()) {
    add_form(form, points, 1, box);
    return box;
  }
  std::vector<glm::dvec3> scratch;
  for (const PatchBox& quarter : quarter_boxes(form, points, reaches, scratch)) {
    box.add(quarter.low);
    box.add(quarter.high);
  }
  return box;
}

}  // namespace planish
