#include "planish/limit/bezier_net.h"

#include <cstddef>

#include "planish/patches/patch_form.h"
#include "planish/patches/quarter_turn.h"

namespace planish {
namespace {

// De Casteljau's halves of three points that are `step` apart.
void halve(BezierNet& net, std::size_t first, std::size_t step, bool upper) {
  const glm::dvec3 a = net[first], b = net[first + step], c = net[first + 2 * step];
  const glm::dvec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), middle = 0.5 * (ab + bc);
  net[first] = upper ? middle : a;
  net[first + step] = upper ? bc : ab;
  net[first + 2 * step] = upper ? c : middle;
}

}  // namespace

BezierNet bezier_net(const PatchForm& form, std::span<const glm::dvec3> points) {
  BezierNet net;
  for (std::size_t i = 0; i < 9; ++i) net[i] = form.net.combine(i, points.data()).value();
  // B-spline to Bezier along u, then along v: midpoints at the ends.
  const auto convert = [&](std::size_t first, std::size_t step) {
    const glm::dvec3 middle = net[first + step];
    net[first] = 0.5 * (net[first] + middle);
    net[first + 2 * step] = 0.5 * (middle + net[first + 2 * step]);
  };
  for (std::size_t i = 0; i < 3; ++i) convert(3 * i, 1);
  for (std::size_t i = 0; i < 3; ++i) convert(i, 3);
  return net;
}

BezierNet net_quarter(BezierNet net, bool upper_u, bool upper_v) {
  for (std::size_t i = 0; i < 3; ++i) halve(net, 3 * i, 1, upper_u);
  for (std::size_t i = 0; i < 3; ++i) halve(net, i, 3, upper_v);
  return net;
}

BezierNet turned_net(const BezierNet& net, int turns) {
  BezierNet result;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [u, v] = seen_from(turns, std::size_t{2}, i, j);
      result[i + 3 * j] = net[u + 3 * v];
    }
  }
  return result;
}

// By blossoms.
BezierNet net_between(const BezierNet& net, bool along_v, double from, double to) {
  BezierNet result;
  const std::size_t step = along_v ? 3 : 1, across = along_v ? 1 : 3;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t at = k * across;
    const glm::dvec3 &a = net[at], &b = net[at + step], &c = net[at + 2 * step];
    result[at] = quadratic_blossom(a, b, c, from, from);
    result[at + step] = quadratic_blossom(a, b, c, from, to);
    result[at + 2 * step] = quadratic_blossom(a, b, c, to, to);
  }
  return result;
}

}  // namespace planish
