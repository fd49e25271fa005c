#include "planish/primal/primal_stencils.h"

#include <gtest/gtest.h>

#include "planish/core/error.h"
#include "support/meshes.h"

namespace planish {
namespace {

TEST(PrimalSplit, CountsLevelsWithoutMakingThem) {
  for (const PrimalScheme scheme : {PrimalScheme::CatmullClark, PrimalScheme::Loop}) {
    PrimalSplit split(test::icosphere(1), {scheme, {}});
    const auto counts = split.counts_to(3);
    split.refine(3);
    for (int l = 0; l <= 3; ++l) {
      EXPECT_EQ(counts[l].vertices, split.level(l).GetNumVertices());
      EXPECT_EQ(counts[l].edges, split.level(l).GetNumEdges());
      EXPECT_EQ(counts[l].faces, split.level(l).GetNumFaces());
    }
  }
}

void expect_refused(const PolygonMesh& mesh, PrimalScheme scheme, std::int64_t face,
                    const char* message) {
  try {
    (void)PrimalSplit(mesh, {scheme, {}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.element(), face);
    EXPECT_STREQ(error.what(), message);
  }
}

TEST(PrimalSplit, LoopNamesTheFirstFaceThatIsNoTriangle) {
  expect_refused(test::make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}},
                                 {{1, 4, 2}, {0, 1, 2, 3}}),
                 PrimalScheme::Loop, 1,
                 "face 1 has 4 corners, and Loop subdivision knows triangles only; split the faces "
                 "into triangles, or take catmull-clark or doo-sabin");
}

// Before memory is taken for it: of 100,000 corners 600 GB.
TEST(PrimalSplit, CatmullClarkNamesAFaceThatIsTooLarge) {
  EXPECT_NO_THROW((void)PrimalSplit(test::prism(2896), {}));  // two of them: 16,773,632
  expect_refused(test::prism(2897), PrimalScheme::CatmullClark, 0,
                 "face 0 has 2897 corners: Catmull-Clark's stencils take the square of a face's "
                 "corners, 16785218 here and 16777216 at most; split its large faces, or take "
                 "doo-sabin");
}

TEST(PrimalSplit, TagsCanBeIgnoredAndBoundariesHaveCorners) {
  PolygonMesh mesh = test::flat_grid(2, 2);
  mesh.creases.push_back({1, 4, 2.5f});
  const PrimalSplit plain(mesh, {PrimalScheme::CatmullClark, {BoundaryRule::Edge, false}});
  const PrimalSplit cornered(mesh,
                             {PrimalScheme::CatmullClark, {BoundaryRule::EdgeAndCorner, true}});
  float plain_sum = 0, sum = 0;
  for (int e = 0; e < plain.level(0).GetNumEdges(); ++e) {
    if (plain.level(0).IsEdgeBoundary(e)) continue;
    plain_sum += plain.level(0).GetEdgeSharpness(e);
    sum += cornered.level(0).GetEdgeSharpness(e);
  }
  EXPECT_EQ(plain_sum, 0.0f);
  EXPECT_EQ(sum, 2.5f);
  EXPECT_LT(plain.level(0).GetVertexSharpness(0), kInfiniteSharpness);
  EXPECT_GE(cornered.level(0).GetVertexSharpness(0), kInfiniteSharpness);
  EXPECT_LT(cornered.level(0).GetVertexSharpness(1), kInfiniteSharpness);
}

}  // namespace
}  // namespace planish
