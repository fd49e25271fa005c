#include "planish/limit/bezier_net.h"

#include <cstddef>

namespace planish {
namespace {

// A place of a 3 x 3 net as a piece sees it that is turned against its patch.
std::size_t turned_place(std::size_t i, std::size_t j, int turns) {
  for (int k = 0; k < turns; ++k) {
    const std::size_t before = i;
    i = j;
    j = 2 - before;
  }
  return i + 3 * j;
}

}  // namespace

BezierNet turned_net(const BezierNet& net, int turns) {
  BezierNet result;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) result[i + 3 * j] = net[turned_place(i, j, turns)];
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
