// Whether shells are valid, told of what was damaged by hand.
#include "planish/brep/brep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "brep/step_cases.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish::test {
namespace {

TEST(CheckBrep, WhatIsMadeIsValid) {
  for (const auto& [name, mesh] : std::vector<NamedMesh>{{"icosphere", icosphere(1)},
                                                         {"cube", creased_cube(true)},
                                                         {"plate", plate_with_hole(5)},
                                                         {"torus", torus(9, 7, 3, 1)},
                                                         {"hub", bipyramid(9)},
                                                         {"closed", random_closed_mesh(4)},
                                                         {"open", random_open_mesh(6)}}) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const CatmullClarkSplines cubic(mesh, {});
    const std::array<BrepCheck, 2> checks{
        check_brep(make_brep(c.limit), c.surface->placement().diagonal),
        check_brep(make_brep(cubic), cubic.placement().diagonal)};
    for (const BrepCheck& check : checks) {
      EXPECT_TRUE(check.is_valid());
      EXPECT_EQ(check.broken_loops, 0);
      EXPECT_EQ(check.unmatched_edges, 0);
      EXPECT_LE(check.largest_gap, 3e-9);  // planes are within 1e-9 of the points
    }
  }
}

class DamagedBrep : public testing::Test {
 protected:
  template <class Damage>
  [[nodiscard]] BrepCheck after(const Damage& damage) const {
    Brep brep = sound_;
    damage(brep);
    return check_brep(brep, diagonal_);
  }

  const LimitCase case_{icosphere(1)};
  const double diagonal_ = case_.surface->placement().diagonal;
  const Brep sound_ = make_brep(case_.limit);
};

TEST_F(DamagedBrep, LoopsThatDoNotCloseOrRunTheWrongWayAreCounted) {
  BrepCheck check = after([](Brep& b) { b.faces[5].loop.pop_back(); });
  EXPECT_EQ(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 1);
  check = after([](Brep& b) { std::swap(b.faces[5].loop[0], b.faces[5].loop[1]); });
  EXPECT_EQ(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 0);
  check = after([](Brep& b) { b.faces[5].loop[2].is_reversed ^= true; });
  EXPECT_GE(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 1);
  EXPECT_FALSE(check.is_valid());
  // Loops that fit one another but not the parameters: a face that is larger than they enclose.
  check = after([](Brep& b) { b.faces[5].knots_u.back() += 1; });
  EXPECT_EQ(check.broken_loops, 1);
}

TEST_F(DamagedBrep, AnEdgeOfOneFaceThatHasTwoIsNotShared) {
  const BrepCheck check = after([](Brep& b) { b.edges[7].lines[1].face = -1; });
  EXPECT_EQ(check.unmatched_edges, 1);
  EXPECT_FALSE(check.is_valid());
}

TEST_F(DamagedBrep, GapsAreBoundedAndNamed) {
  const auto moved = [&](double by) {
    return after([&](Brep& b) {
      b.edges[9].points[1].x += by * diagonal_;  // between its ends
    });
  };
  // A control point moves the curve by less than itself, and a bound is at most 1.25 times that.
  const BrepCheck wide = moved(1e-3);
  EXPECT_GT(wide.largest_gap, 1e-4);
  EXPECT_LE(wide.largest_gap, 1.25e-3);
  EXPECT_LE(glm::length(wide.largest_gap_at - sound_.edges[9].points[1]), 0.5);
  EXPECT_FALSE(wide.is_valid());
  EXPECT_TRUE(moved(1e-8).is_valid());
  EXPECT_GT(moved(1e-8).largest_gap, 1e-9);
  const BrepCheck off_vertex = after([&](Brep& b) { b.vertices[3].z += 2e-7 * diagonal_; });
  EXPECT_NEAR(off_vertex.largest_gap, 2e-7, 1e-12);
  EXPECT_FALSE(off_vertex.is_valid());
  EXPECT_FALSE(after([](Brep& b) {
                 b.faces[4].points[0].x = std::numeric_limits<double>::quiet_NaN();
               }).is_valid());
}

// Which commands' exit codes go by.
TEST(StepFigures, AskForValidShellsWhateverTheLimits) {
  StepFigures figures;
  EXPECT_TRUE(figures.is_as_asked());
  figures.keeps_limits = false;  // limits that nobody has set
  EXPECT_TRUE(figures.is_as_asked());
  figures.check.broken_loops = 1;
  EXPECT_FALSE(figures.is_as_asked());
  figures.check = {.largest_gap = 2 * Brep::kSamePlace};
  EXPECT_FALSE(figures.is_as_asked());
  figures.check = {};
  figures.keeps_wishes = false;
  EXPECT_FALSE(figures.is_as_asked());
}

TEST_F(DamagedBrep, PlanesAreHeldAgainstTheirEdges) {
  const LimitCase flat(creased_cube(true));
  Brep brep = make_brep(flat.limit);
  const double diagonal = flat.surface->placement().diagonal;
  ASSERT_TRUE(check_brep(brep, diagonal).is_valid());
  const auto face =
      std::ranges::find_if(brep.faces, [](const auto& f) { return f.plane.has_value(); });
  ASSERT_NE(face, brep.faces.end());
  face->plane->normal = glm::normalize(face->plane->normal + 0.01 * face->plane->along);
  const BrepCheck check = check_brep(brep, diagonal);
  EXPECT_GT(check.largest_gap, 1e-4);
  EXPECT_FALSE(check.is_valid());
}

}  // namespace
}  // namespace planish::test
