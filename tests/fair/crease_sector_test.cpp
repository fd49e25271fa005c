#include "planish/fair/crease_sector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "fair/fair_case.h"

namespace planish::test {
namespace {

// A square whose corners are arcs of `steps` edges over half of its sides, as a prism with sharp
// rims; face 0 is the upper cap.
PolygonMesh rounded_prism(int steps) {
  PolygonMesh mesh;
  std::vector<glm::dvec2> outline;
  for (int corner = 0; corner < 4; ++corner) {
    for (int i = 0; i <= steps; ++i) {
      const double angle = std::numbers::pi / 2 * (corner + double(i) / steps);
      const double middle = std::numbers::pi / 2 * (corner + 0.5);
      outline.emplace_back(std::sqrt(0.5) * std::cos(middle) + 0.5 * std::cos(angle),
                           std::sqrt(0.5) * std::sin(middle) + 0.5 * std::sin(angle));
    }
  }
  const auto n = static_cast<std::int32_t>(outline.size());
  for (const double z : {1.0, -1.0})
    for (const glm::dvec2& p : outline) mesh.positions.emplace_back(p, z);
  std::vector<std::int32_t> top(outline.size()), bottom(outline.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t next = (i + 1) % n;
    top[i] = i;
    bottom[i] = n + (n - i) % n;
    mesh.creases.push_back({i, next, kInfiniteSharpness});
    mesh.creases.push_back({n + i, n + next, kInfiniteSharpness});
  }
  mesh.add_face(top);
  mesh.add_face(bottom);
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t next = (i + 1) % n;
    mesh.add_face(std::vector{n + i, n + next, next, i});
  }
  return mesh;
}

// Beside a long side the handle is far shorter than the side's quarter. What follows it deep in the
// face must not overtake the points beside it (the corner at a side's end lay 21 times the side's
// length away).
TEST(CreaseSector, KeepsTheOrderOfALargeFacesPoints) {
  for (const int steps : {4, 16, 32, 100}) {
    SCOPED_TRACE(steps);
    const FairCase c(rounded_prism(steps));
    const FairNet net =
        fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 0, .cures_folds = false});
    const std::int32_t count = c.mesh.face_size(0);
    for (std::int32_t i = 0; i < count; ++i) {
      const glm::dvec3 &own = net.state[i], &next = net.state[(i + 1) % count];
      EXPECT_GT(own.x * next.y - own.y * next.x, 0) << i;
      EXPECT_LT(glm::length(glm::dvec2(own)), glm::length(glm::dvec2(c.given[i]))) << i;
    }
  }
}

}  // namespace
}  // namespace planish::test
