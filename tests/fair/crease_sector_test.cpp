#include "planish/fair/vertex_polygon.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "fair/fair_case.h"
#include "support/outlines.h"

namespace planish::test {
namespace {

// Beside a long side the handle is far shorter than the side's quarter. What follows it deep in the
// face must not overtake the points beside it (the corner at a side's end lay 21 times the side's
// length away).
TEST(CreaseSector, KeepsTheOrderOfALargeFacesPoints) {
  for (const int steps : {4, 16, 32, 100}) {
    SCOPED_TRACE(steps);
    const FairCase c(with_sharp_rims(prism_over(rounded_square(steps, 0.5))));
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
