#include "planish/measure/vertex_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "support/meshes.h"

namespace planish {
namespace {

// The cage itself stands for the mesh: its surface misses every vertex, by different lengths.
struct Case {
  PolygonMesh mesh;
  SurfaceMesh surface;
  VertexFields fields;
};

Case case_of(PolygonMesh mesh, int level, Scheme scheme = Scheme::DooSabin) {
  SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = level, .scheme = scheme});
  VertexFields fields = vertex_fields(surface, mesh, 2.0);
  return {std::move(mesh), std::move(surface), std::move(fields)};
}

// A plate with a spike: its surface leaves the faces beside it.
PolygonMesh spiked_plate() {
  PolygonMesh mesh = test::flat_grid(4, 4);
  mesh.positions[12].z = 3;
  return mesh;
}

TEST(VertexFields, ErrorIsTheDistanceFromTheGivenVertex) {
  for (int level = 0; level <= 2; ++level) {
    const Case c = case_of(test::prism(5), level);
    ASSERT_EQ(c.fields.error.size(), c.surface.positions.size());
    for (std::int32_t v = 0; v < c.mesh.vertex_count(); ++v) {
      const double distance = glm::distance(c.surface.positions[v], c.mesh.positions[v]);
      EXPECT_GT(distance, 0.01);
      EXPECT_FLOAT_EQ(c.fields.error[v], static_cast<float>(distance / 2));
    }
  }
}

TEST(VertexFields, ErrorKnowsWhichVerticesAreUsed) {
  PolygonMesh mesh = test::prism(4);
  mesh.positions.insert(mesh.positions.begin(), glm::dvec3(50, 0, 0));
  for (std::int32_t& v : mesh.face_vertices) ++v;
  const Case c = case_of(mesh, 1);
  for (const float error : c.fields.error) EXPECT_LT(error, 1);
  EXPECT_FLOAT_EQ(
      c.fields.error[0],
      static_cast<float>(glm::distance(c.surface.positions[0], c.mesh.positions[1]) / 2));
}

TEST(VertexFields, ErrorBetweenGivenVerticesIsTheirMean) {
  const Case c = case_of(spiked_plate(), 1);
  // Level 1 appends a vertex for each face and one for each edge; faces come first.
  const std::int32_t given = c.mesh.vertex_count();
  for (std::int32_t f = 0; f < c.mesh.face_count(); ++f) {
    double sum = 0;
    for (const std::int32_t v : c.mesh.face(f)) sum += c.fields.error[v];
    EXPECT_NEAR(c.fields.error[given + f], sum / 4, 1e-7);
  }
}

TEST(VertexFields, CopiesOfAVertexHaveItsError) {
  PolygonMesh mesh = spiked_plate();
  for (int i = 0; i < 4; ++i) mesh.creases.push_back({10 + i, 11 + i});  // the middle row
  const Case c = case_of(mesh, 2);
  std::size_t copies = 0;
  for (std::size_t row = 0; row < c.surface.positions.size(); ++row) {
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
      if (c.surface.positions[row] != c.surface.positions[v] || row == static_cast<std::size_t>(v))
        continue;
      EXPECT_EQ(c.fields.error[row], c.fields.error[v]);
      ++copies;
    }
  }
  EXPECT_GE(copies, 5u);
}

TEST(VertexFields, DeviationAgreesWithTheSurfacesQuality) {
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark}) {
    for (int level = 0; level <= 2; ++level) {
      const Case c = case_of(spiked_plate(), level, scheme);
      const SurfaceQuality quality = surface_quality(c.surface, c.mesh);
      EXPECT_GT(quality.max_normal_deviation, 5);
      EXPECT_FLOAT_EQ(*std::ranges::max_element(c.fields.normal_deviation),
                      static_cast<float>(quality.max_normal_deviation));
    }
  }
}

// A square whose surface is turned over in one corner, given by hand.
Case folded_case() {
  Case c;
  c.mesh = test::flat_grid(2, 1);
  c.surface = evaluate(c.mesh, *make_cpu_backend(), {.level = 1});
  c.surface.normals[0] = -c.surface.normals[0];
  c.fields = vertex_fields(c.surface, c.mesh, 1.0);
  return c;
}

TEST(VertexFields, FoldsSumToTheFoldedArea) {
  const Case c = folded_case();
  std::vector<double> around(c.surface.positions.size(), 0.0);
  double whole = 0, folded = 0;
  for (std::int64_t f = 0; f < c.surface.face_count(); ++f) {
    const auto face = c.surface.face(f);
    const double area = glm::length(area_vector(c.surface.positions, face));
    whole += area;
    for (const std::int32_t v : face) around[v] += area / 4;
  }
  for (std::size_t v = 0; v < around.size(); ++v) folded += around[v] * c.fields.folded[v];
  EXPECT_EQ(c.fields.folded[0], 1.0f);
  EXPECT_GT(folded, 0);
  EXPECT_NEAR(folded / whole, surface_quality(c.surface, c.mesh).folded_area, 1e-12);
}

TEST(VertexFields, ChosenFieldsAreNamedInOrder) {
  const Case c = case_of(test::prism(5), 1);
  const auto named = named_fields(c.fields, {.error = true, .curvature = true});
  ASSERT_EQ(named.size(), 3u);
  EXPECT_EQ(named[0].name, "error");
  EXPECT_EQ(named[0].values.data(), c.fields.error.data());
  EXPECT_EQ(named[1].name, "mean_curvature");
  EXPECT_EQ(named[2].values.data(), c.fields.curvatures.gaussian.data());
  EXPECT_TRUE(named_fields(c.fields, {}).empty());
  EXPECT_FALSE(FieldChoice{}.any());
}

TEST(VertexFields, FoldedFacesSayWhereAndHowMuch) {
  const Case c = folded_case();
  const std::vector<FoldedFace> folds = folded_faces(c.surface, c.mesh);
  ASSERT_EQ(folds.size(), 1u);
  const auto face = c.surface.face(folds[0].face);
  EXPECT_EQ(std::ranges::count(face, 0), 1);
  EXPECT_EQ(folds[0].ancestor, 0);
  EXPECT_DOUBLE_EQ(folds[0].area, glm::length(area_vector(c.surface.positions, face)) / 4);
  EXPECT_TRUE(folded_faces(case_of(test::icosphere(1), 2).surface, test::icosphere(1)).empty());
}

TEST(VertexFields, FoldedFacesComeLargestFirst) {
  Case c = folded_case();
  for (glm::vec3& normal : c.surface.normals) normal = glm::vec3(0, 0, -1);
  const std::vector<FoldedFace> folds = folded_faces(c.surface, c.mesh);
  EXPECT_EQ(folds.size(), static_cast<std::size_t>(c.surface.face_count()));
  EXPECT_TRUE(std::ranges::is_sorted(folds, [](const FoldedFace& a, const FoldedFace& b) {
    return a.area > b.area || (a.area == b.area && a.face < b.face);
  }));
}

}  // namespace
}  // namespace planish
