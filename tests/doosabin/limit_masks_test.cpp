#include "planish/doosabin/limit_masks.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "planish/core/error.h"
#include "planish/solve/stencil_builder.h"
#include "support/meshes.h"

namespace planish {
namespace {

using Row = std::map<std::int32_t, double>;

Row mask_of(const PolygonMesh& mesh, Weights weights, std::int32_t vertex,
            const SharpFeatureOptions& sharp = {}) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, sharp);
  const StencilTable masks = limit_masks(Subdivision(topology, features, weights));
  const auto view = masks.view();
  Row row;
  for (int k = view.offsets[vertex]; k < view.offsets[vertex] + view.sizes[vertex]; ++k) {
    row[view.indices[k]] = view.weights[k];
  }
  return row;
}

void expect_row(const Row& actual, const Row& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (const auto& [index, weight] : expected) {
    EXPECT_NEAR(actual.at(index), weight, 1e-15) << "source " << index;
  }
}

TEST(LimitMasks, OnARegularGridAreTheBiquadraticBSplines) {
  // (1 6 1)/8 in both directions.
  const PolygonMesh mesh = test::torus(5, 4, 1.0, 0.4);
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    std::map<double, int> weight_counts;
    for (const auto& [index, weight] : mask_of(mesh, weights, 7)) ++weight_counts[weight * 64];
    EXPECT_EQ(weight_counts, (std::map<double, int>{{1, 4}, {6, 4}, {36, 1}}));
  }
}

PolygonMesh polygon(std::int32_t corners) {
  PolygonMesh mesh;
  mesh.positions.resize(static_cast<std::size_t>(corners), glm::dvec3(0.0));
  mesh.positions[0].x = 1;
  std::vector<std::int32_t> face(mesh.positions.size());
  std::iota(face.begin(), face.end(), 0);
  mesh.add_face(face);
  return mesh;
}

TEST(LimitMasks, MayBeLargeWhereNoFaceIs) {
  constexpr int kSize = 16, kCount = 80'000;  // 224 entries each, 17'920'000 > 2^24
  PolygonMesh mesh;
  mesh.positions.resize(std::size_t{kSize} * kCount);
  mesh.face_vertices.resize(mesh.positions.size());
  std::iota(mesh.face_vertices.begin(), mesh.face_vertices.end(), 0);
  mesh.face_offsets.clear();
  for (int i = 0; i <= kCount; ++i) mesh.face_offsets.push_back(kSize * i);
  EXPECT_FALSE(too_large_masks(MeshTopology(mesh)));
}

TEST(LimitMasks, AreRefusedWhereTheyMayBeTooLarge) {
  // 4096 * (4096 - 1) = 16773120 < 2^24
  EXPECT_FALSE(too_large_masks(MeshTopology(polygon(4096))));
  const PolygonMesh mesh = polygon(4097);
  const MeshTopology topology(mesh);
  const auto problem = too_large_masks(topology);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->kind, MeshProblemKind::TooLarge);
  EXPECT_EQ(problem->element, 0);
  EXPECT_EQ(
      problem->message,
      "the stencils of the progressive method need up to 16781312 entries, without sums "
      "of large faces at most 16777216 are taken here; the largest face, 0, has 4097 corners; "
      "the fair method needs none");
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  try {
    (void)limit_masks(Subdivision(topology, features, Weights::DooSabin));
    FAIL() << "was made";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.what(), problem->message);
  }
}

TEST(LimitMasks, WithSumsAreTheSameMatrix) {
  PolygonMesh creased = test::prism(40);
  creased.creases = {{0, 1, kInfiniteSharpness}, {1, 2, kInfiniteSharpness}};
  for (const PolygonMesh& mesh :
       {test::prism(31), test::prism(32), test::prism(45), creased, test::single_polygon(64)}) {
    const MeshTopology topology(mesh);
    const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      const Subdivision subdivision(topology, features, weights);
      const StencilTable whole = limit_masks(subdivision);
      const SummedTable apart = summed_limit_masks(subdivision);
      EXPECT_EQ(apart.sums.sizes.empty(), mesh.face_size(0) < kSummedRing);
      const StencilTable back = expanded(apart.view());
      EXPECT_GE(expansion(apart.view()) * double(apart.entry_count()) + 0.5,
                double(back.weights.size()));
      ASSERT_EQ(back.sizes, whole.sizes);
      for (std::size_t k = 0; k < whole.weights.size(); ++k) {
        EXPECT_EQ(back.indices[k], whole.indices[k]);
        EXPECT_NEAR(back.weights[k], whole.weights[k], 1e-15);
      }
    }
  }
}

TEST(LimitMasks, WithSumsGrowAsTheCorners) {
  for (const std::int32_t n : {1000, 100000}) {
    const PolygonMesh mesh = test::prism(n);
    const MeshTopology topology(mesh);
    EXPECT_FALSE(too_large_summed_masks(topology));
    const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
    const Subdivision subdivision(topology, features, Weights::DooSabin);
    EXPECT_LE(summed_limit_masks(subdivision).entry_count(), 5 * topology.corner_count());
  }
}

TEST(LimitMasks, AtACubesCorner) {
  // Three quads: own 9/16; each neighbour lies in two of them, 2 * 3/16 / 3; each diagonal 1/16
  // / 3.
  const PolygonMesh mesh = test::cube();
  expect_row(mask_of(mesh, Weights::Averaged, 0), {{0, 9.0 / 16},
                                                   {1, 1.0 / 8},
                                                   {2, 1.0 / 8},
                                                   {4, 1.0 / 8},
                                                   {3, 1.0 / 48},
                                                   {5, 1.0 / 48},
                                                   {6, 1.0 / 48}});
}

TEST(LimitMasks, AtATetrahedronsCorner) {
  // Three triangles: own c_3(0), each other vertex in two of them.
  const PolygonMesh mesh = test::tetrahedron();
  const double averaged = 2 * (5.0 / 24) / 3, doo_sabin = 2 * (1.0 / 6) / 3;
  expect_row(mask_of(mesh, Weights::Averaged, 0),
             {{0, 7.0 / 12}, {1, averaged}, {2, averaged}, {3, averaged}});
  expect_row(mask_of(mesh, Weights::DooSabin, 0),
             {{0, 2.0 / 3}, {1, doo_sabin}, {2, doo_sabin}, {3, doo_sabin}});
}

TEST(LimitMasks, OnABoundaryFollowTheCurveAlone) {
  const PolygonMesh mesh = test::flat_grid(3, 3);
  expect_row(mask_of(mesh, Weights::DooSabin, 1), {{0, 1.0 / 8}, {1, 6.0 / 8}, {2, 1.0 / 8}});
  expect_row(mask_of(mesh, Weights::DooSabin, 0), {{0, 6.0 / 8}, {1, 1.0 / 8}, {4, 1.0 / 8}});
}

TEST(LimitMasks, AtCornersAreTheVertexItself) {
  PolygonMesh mesh = test::flat_grid(3, 3);
  expect_row(mask_of(mesh, Weights::DooSabin, 0, {.boundary = BoundaryRule::EdgeAndCorner}),
             {{0, 1.0}});
  mesh.corners = {{5, kInfiniteSharpness}};
  expect_row(mask_of(mesh, Weights::DooSabin, 5), {{5, 1.0}});
  EXPECT_EQ(mask_of(mesh, Weights::DooSabin, 5, {.use_tags = false}).size(), 9u);
}

TEST(SpectralBound, IsTheSmallestOfTheFaceSizesPresent) {
  EXPECT_DOUBLE_EQ(spectral_bound(test::tetrahedron(), Weights::Averaged), 3.0 / 8);
  EXPECT_DOUBLE_EQ(spectral_bound(test::tetrahedron(), Weights::DooSabin), 0.5);
  EXPECT_DOUBLE_EQ(spectral_bound(test::cube(), Weights::Averaged), 0.25);
  EXPECT_DOUBLE_EQ(spectral_bound(test::prism(5), Weights::DooSabin), 0.25);
}

TEST(LimitMasks, TellWhereConjugateGradientsApply) {
  const auto self_adjoint = [](const PolygonMesh& mesh) {
    return is_self_adjoint(find_sharp_features(mesh, MeshTopology(mesh), mesh.positions, {}));
  };
  EXPECT_TRUE(self_adjoint(test::cube()));
  EXPECT_FALSE(self_adjoint(test::flat_grid(3, 3)));
  PolygonMesh tagged = test::cube();
  tagged.corners = {{0, kInfiniteSharpness}};
  EXPECT_FALSE(self_adjoint(tagged));
}

}  // namespace
}  // namespace planish
