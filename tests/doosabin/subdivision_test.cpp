#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "planish/core/error.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/solve/stencil_builder.h"
#include "support/doo_sabin_tables.h"
#include "support/meshes.h"

namespace planish {
namespace {

constexpr Weights kBoth[] = {Weights::DooSabin, Weights::Averaged};

TEST(FaceWeights, SumToOneAndAreSymmetric) {
  for (const Weights weights : kBoth) {
    for (int m = 2; m <= 70; ++m) {
      const auto c = face_weights(weights, m);
      EXPECT_NEAR(std::accumulate(c.begin(), c.end(), 0.0), 1.0, 1e-14);
      for (int j = 1; j < m; ++j) EXPECT_NEAR(c[j], c[m - j], 1e-15);
    }
  }
}

TEST(FaceWeights, AgreeOnQuads) {
  // 9/16, 3/16, 1/16, 3/16: biquadratic B-splines.
  for (const Weights weights : kBoth) {
    const auto c = face_weights(weights, 4);
    EXPECT_DOUBLE_EQ(c[0], 9.0 / 16);
    EXPECT_DOUBLE_EQ(c[1], 3.0 / 16);
    EXPECT_DOUBLE_EQ(c[2], 1.0 / 16);
    EXPECT_DOUBLE_EQ(c[3], 3.0 / 16);
  }
}

TEST(FaceWeights, OfATriangle) {
  // Averaged: (vertex + centroid + two edge midpoints) / 4 = 1/4 + 1/12 + 1/4, 1/12 + 1/8.
  EXPECT_DOUBLE_EQ(face_weights(Weights::Averaged, 3)[0], 7.0 / 12);
  EXPECT_DOUBLE_EQ(face_weights(Weights::Averaged, 3)[1], 5.0 / 24);
  // 1978: (3 + 5) / 12 and (3 + 2 cos 120) / 12.
  EXPECT_DOUBLE_EQ(face_weights(Weights::DooSabin, 3)[0], 2.0 / 3);
  EXPECT_NEAR(face_weights(Weights::DooSabin, 3)[1], 1.0 / 6, 1e-15);
}

TEST(FaceWeights, SmallestEigenvalueIsTheCirculants) {
  for (const Weights weights : kBoth) {
    for (int m = 3; m <= 40; ++m) {
      const auto c = face_weights(weights, m);
      double smallest = 1;
      for (int k = 0; k < m; ++k) {
        double eigenvalue = 0;
        for (int j = 0; j < m; ++j) {
          eigenvalue += c[j] * std::cos(2 * std::numbers::pi * j * k / m);
        }
        smallest = std::min(smallest, eigenvalue);
      }
      EXPECT_NEAR(smallest_face_eigenvalue(weights, m), smallest, 1e-13) << m;
    }
  }
}

SharpFeatures features_of(const PolygonMesh& mesh, const SharpFeatureOptions& options = {}) {
  return find_sharp_features(mesh, MeshTopology(mesh), mesh.positions, options);
}

// Vertex (i, j) of a 4 x 4 grid.
std::int32_t at(int i, int j) { return j * 5 + i; }

TEST(SharpFeatures, OfAClosedMeshWithoutTagsAreNone) {
  const SharpFeatures features = features_of(test::cube());
  EXPECT_EQ(features.sharp_edge_count, 0);
  EXPECT_TRUE(features.sharp_of_edge.empty());
  EXPECT_TRUE(std::all_of(features.vertex_kinds.begin(), features.vertex_kinds.end(),
                          [](VertexKind kind) { return kind == VertexKind::Smooth; }));
}

TEST(SharpFeatures, CountTheSharpEdgesAtAVertex) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  // A crease from the boundary inwards: T-junction, crease, dart.
  mesh.creases = {{at(2, 0), at(2, 1), 10}, {at(2, 2), at(2, 1), 12}};
  const SharpFeatures features = features_of(mesh);
  EXPECT_EQ(features.vertex_kinds[at(2, 0)], VertexKind::Corner);
  EXPECT_EQ(features.vertex_kinds[at(2, 1)], VertexKind::Crease);
  EXPECT_EQ(features.vertex_kinds[at(2, 2)], VertexKind::Dart);
  EXPECT_EQ(features.vertex_kinds[at(2, 3)], VertexKind::Smooth);
  EXPECT_EQ(features.vertex_kinds[at(0, 0)], VertexKind::Crease);
  EXPECT_EQ(features.sharp_edge_count, 16 + 2);
  EXPECT_EQ(features.interior_sharp_edge_count, 2);
  EXPECT_EQ(features.corner_vertices, std::vector<std::int32_t>{at(2, 0)});
}

TEST(SharpFeatures, OfLowerSharpnessOrIgnoredTagsAreNone) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  mesh.creases = {{at(2, 1), at(2, 2), 3.0f}};
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 0);
  mesh.creases[0].sharpness = 10.0f;
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 1);
  EXPECT_EQ(features_of(mesh, {.use_tags = false}).interior_sharp_edge_count, 0);
}

TEST(SharpFeatures, TheLastTagOfAnEdgeHolds) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  mesh.creases = {{at(2, 1), at(2, 2), 10.0f}, {at(2, 2), at(2, 1), 3.0f}};
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 0);
  std::ranges::reverse(mesh.creases);
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 1);
}

TEST(SharpFeatures, BoundaryCornersDependOnTheRule) {
  const PolygonMesh mesh = test::flat_grid(4, 4);
  EXPECT_EQ(features_of(mesh).corner_count, 0);
  const SharpFeatures features = features_of(mesh, {.boundary = BoundaryRule::EdgeAndCorner});
  EXPECT_EQ(features.corner_count, 4);
  EXPECT_EQ(features.corner_of_vertex[at(4, 4)], 3);
}

std::vector<CornerSector> sectors_of(const SharpFeatures& features) {
  std::vector<CornerSector> sectors;
  for (const auto& [key, sector] : features.corner_sectors) sectors.push_back(sector);
  std::sort(sectors.begin(), sectors.end());
  return sectors;
}

TEST(CornerSectors, FollowTheAngle) {
  PolygonMesh right_angles = test::flat_grid(4, 4);
  EXPECT_EQ(sectors_of(features_of(right_angles, {.boundary = BoundaryRule::EdgeAndCorner})),
            std::vector<CornerSector>(4, CornerSector::Convex));

  PolygonMesh straight = test::flat_grid(4, 4);
  straight.corners = {{at(2, 0), kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(straight)), std::vector{CornerSector::HalfPlane});

  PolygonMesh junction = test::flat_grid(4, 4);
  junction.creases = {{at(2, 0), at(2, 1), 10}};
  EXPECT_EQ(sectors_of(features_of(junction)),
            (std::vector{CornerSector::Convex, CornerSector::Convex}));

  PolygonMesh reflex = test::l_shaped_plate(3);
  reflex.corners = {{test::vertex_at(reflex, {3, 3, 0}), kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(reflex)), std::vector{CornerSector::Reflex});
}

TEST(CornerSectors, AConcavePolygonsReflexCornerCountsAsReflex) {
  // An L of one face: 270 degrees at (1, 1).
  const PolygonMesh mesh = test::make_mesh(
      {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, {{0, 1, 2, 3, 4, 5}});
  PolygonMesh tagged = mesh;
  tagged.corners = {{3, kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(tagged)), std::vector{CornerSector::Reflex});
}

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

namespace planish::test {
namespace {

std::vector<glm::dvec3> apply_table(const StencilView<double>& table,
                                    const std::vector<glm::dvec3>& source) {
  std::vector<glm::dvec3> target(static_cast<std::size_t>(table.row_count()), glm::dvec3(0.0));
  for (std::int32_t i = 0; i < table.row_count(); ++i) {
    for (std::int32_t k = table.offsets[i]; k < table.offsets[i] + table.sizes[i]; ++k) {
      target[i] += table.weights[k] * source[table.indices[k]];
    }
  }
  return target;
}

// A grid with a crease that ends inside, a T-junction, and tagged corners.
PolygonMesh feature_rich_grid() {
  PolygonMesh mesh =
      grid(6, 6, [](double x, double y) { return glm::dvec3(x, y, 0.2 * x * x - 0.1 * x * y); });
  const auto at = [](int i, int j) { return j * 7 + i; };
  mesh.creases = {{at(3, 0), at(3, 1), 10}, {at(3, 1), at(3, 2), 10}, {at(3, 2), at(3, 3), 10}};
  mesh.corners = {{at(6, 6), 10}, {at(5, 5), 10}};
  return mesh;
}

TEST(SurfaceTables, RowsOfEveryTableSumToOne) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(3);
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
    const SubdivisionChain subdivision(split, features, weights);
    const auto expect_sums = [](const StencilView<double>& view) {
      for (std::int32_t i = 0; i < view.row_count(); ++i) {
        double sum = 0;
        for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
          sum += view.weights[k];
        }
        ASSERT_NEAR(sum, 1.0, 1e-14) << "row " << i;
      }
    };
    expect_sums(step_table(subdivision, 1).view());
    expect_sums(step_table(subdivision, 2).view());
    const LimitRows rows(subdivision, 2);
    const auto limit = limit_table(subdivision, rows);
    expect_sums(limit.view());
    const auto view = limit.view();
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      double du = 0, dv = 0;
      for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        du += view.du_weights[k];
        dv += view.dv_weights[k];
      }
      ASSERT_NEAR(du, 0.0, 1e-14) << "row " << i;
      ASSERT_NEAR(dv, 0.0, 1e-14) << "row " << i;
    }
  }
}

TEST(LimitRows, AddOneRowForEachFurtherSectorOfACrease) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(1);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const SubdivisionChain subdivision(split, features, Weights::DooSabin);
  const std::int64_t vertex_count = split.counts(1).vertices;
  const LimitRows rows(subdivision, 1);
  // T-junction, two crease vertices and three edge midpoints; the dart has one normal.
  EXPECT_EQ(rows.count(), vertex_count + 6);

  VertexRing ring;
  const auto& level = split.level(1);
  const std::int32_t crease_vertex = 7 + 3;
  std::vector<std::int32_t> seen;
  for (int f = 0; f < level.GetNumFaces(); ++f) {
    const auto vertices = level.GetFaceVertices(f);
    for (int k = 0; k < 4; ++k) {
      if (vertices[k] != crease_vertex) continue;
      const std::int32_t row = rows.row_of(crease_vertex, f, ring);
      EXPECT_EQ(rows.place(row).vertex, crease_vertex);
      seen.push_back(row);
    }
  }
  std::sort(seen.begin(), seen.end());
  ASSERT_EQ(seen.size(), 4u);
  EXPECT_EQ(seen[0], seen[1]);
  EXPECT_EQ(seen[0], crease_vertex);
  EXPECT_EQ(seen[2], seen[3]);
  EXPECT_GE(seen[2], vertex_count);
}

TEST(SurfaceTables, SlicesEqualTheWholeTable) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(2);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const SubdivisionChain subdivision(split, features, Weights::DooSabin);
  const std::int64_t size = subdivision.state_layout(2).size;
  const auto state = apply_table(step_table(subdivision, 1).view(), mesh.positions);
  const auto whole = apply_table(step_table(subdivision, 2).view(), state);
  const auto head = apply_table(step_table(subdivision, 2, {0, 100}).view(), state);
  const auto tail = apply_table(step_table(subdivision, 2, {100, size - 100}).view(), state);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(whole[i], i < 100 ? head[i] : tail[i - 100]);
  }
}

}  // namespace
}  // namespace planish::test
