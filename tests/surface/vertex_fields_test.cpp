#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/work.h"
#include "planish/measure/figures.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "planish/surface/surface_blocks.h"
#include "support/meshes.h"

namespace planish {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

SurfaceMesh surface_at(const PolygonMesh& mesh,
                       const std::function<glm::dvec3(const glm::dvec3&)>& normal_of) {
  SurfaceMesh surface;
  surface.positions = mesh.positions;
  surface.face_offsets = mesh.face_offsets;
  surface.face_vertices = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) surface.normals.emplace_back(normal_of(p));
  return surface;
}

glm::dvec3 from_the_middle(const glm::dvec3& p) { return glm::normalize(p); }

// On a sphere every chord shows the same curvature, whatever the mesh. Normals that are turned over
// turn the mean only.
TEST(NormalCurvatures, AreExactOnASphere) {
  for (const double radius : {1.0, 4.0, -1.0}) {
    SurfaceMesh surface =
        surface_at(test::icosphere(2), [&](const glm::dvec3& p) { return p * glm::sign(radius); });
    for (glm::dvec3& position : surface.positions) position *= std::abs(radius);
    const Curvatures curvatures = curvatures_of_normals(surface);
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      EXPECT_NEAR(curvatures.mean[v], 1 / radius, 1e-5 / std::abs(radius));
      EXPECT_NEAR(curvatures.gaussian[v], 1 / (radius * radius), 1e-5 / (radius * radius));
    }
  }
}

// Of a large face few corners are asked, neighbours among them: a sphere cut by two planes.
TEST(NormalCurvatures, AreExactAtLargeFaces) {
  for (const int n : {10, 34, 2000}) {
    PolygonMesh drum = test::prism(n);
    for (glm::dvec3& p : drum.positions) p = glm::normalize(p + glm::dvec3(0, 0, 0.1));
    const SurfaceMesh surface = surface_at(drum, from_the_middle);
    const std::atomic<std::int64_t>& pairs = work_counts[static_cast<std::size_t>(Work::Pairs)];
    const std::int64_t before = pairs;
    const Curvatures curvatures = curvatures_of_normals(surface);
    EXPECT_LE(pairs - before, 32 * static_cast<std::int64_t>(drum.face_vertices.size())) << n;
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      // Neighbours of the largest are 0.003 apart, of normals in single precision.
      EXPECT_NEAR(curvatures.mean[v], 1, 2e-4) << n;
      EXPECT_NEAR(curvatures.gaussian[v], 1, 4e-4) << n;
    }
  }
}

// A torus of radii R and r: 1/r across the tube, cos(t) / (R + r cos(t)) along it.
double torus_error(int n) {
  constexpr double kMajor = 2, kMinor = 1;
  const auto off_the_circle = [](const glm::dvec3& p) {  // around z
    return p - kMajor * glm::normalize(glm::dvec3(p.x, p.y, 0));
  };
  const SurfaceMesh surface =
      surface_at(test::torus(2 * n, n, kMajor, kMinor),
                 [&](const glm::dvec3& p) { return glm::normalize(off_the_circle(p)); });
  const Curvatures curvatures = curvatures_of_normals(surface);
  double error = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const glm::dvec3& p = surface.positions[v];
    const double cosine = (std::hypot(p.x, p.y) - kMajor) / kMinor;
    const double along = cosine / (kMajor + kMinor * cosine);
    error = std::max(error, std::abs(curvatures.mean[v] - (1 / kMinor + along) / 2));
    error = std::max(error, std::abs(curvatures.gaussian[v] - along / kMinor));
  }
  return error;
}

TEST(NormalCurvatures, ComeNearerToATorusWithTheSquareOfTheFaces) {
  const double coarse = torus_error(16), fine = torus_error(32);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, coarse / 3.5);
}

TEST(NormalCurvatures, AreZeroWhereNothingIsKnown) {
  SurfaceMesh surface =
      surface_at(test::flat_grid(2, 2), [](const glm::dvec3&) { return glm::dvec3(0, 0, 1); });
  surface.positions.emplace_back(9, 9, 9);  // of no face
  surface.normals.emplace_back(1, 0, 0);
  const Curvatures curvatures = curvatures_of_normals(surface);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_EQ(curvatures.mean[v], 0);
    EXPECT_EQ(curvatures.gaussian[v], 0);
  }
}

// The integral of the Gaussian curvature over a sphere-like surface is 4 pi, whatever its shape.
TEST(NormalCurvatures, KeepGaussAndBonnetOnAnEllipsoid) {
  const glm::dvec3 axes(1.5, 1, 0.8);
  SurfaceMesh surface =
      surface_at(test::icosphere(4), [&](const glm::dvec3& p) { return glm::normalize(p / axes); });
  for (glm::dvec3& position : surface.positions) position *= axes;
  const Curvatures curvatures = curvatures_of_normals(surface);
  double integral = 0;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const double area = glm::length(area_vector(surface.positions, face));
    for (const std::int32_t v : face) integral += curvatures.gaussian[v] * area / 3;
  }
  EXPECT_NEAR(integral, 4 * kHalfTurn, 0.02 * 4 * kHalfTurn);
}

struct Tessellated {
  Tessellated(const PolygonMesh& mesh, int level)
      : surface(mesh, EvaluateOptions{}), tessellation(collect(*surface.level(level), {})) {}

  [[nodiscard]] Curvatures exact(float mean = -7, float gaussian = -7) const {
    Curvatures elsewhere;
    elsewhere.mean.assign(tessellation.positions.size(), mean);
    elsewhere.gaussian.assign(tessellation.positions.size(), gaussian);
    return curvatures_of_derivatives(surface, tessellation, std::move(elsewhere));
  }

  DooSabinSurface surface;
  SurfaceMesh tessellation;
};

// One quadratic polynomial everywhere: z = (a x^2 + b y^2) / 2 over a grid of units, whose B-spline
// has exactly those second derivatives.
TEST(DerivativeCurvatures, AreThoseOfAParaboloid) {
  constexpr double kA = 0.3, kB = -0.2;
  constexpr int kSize = 8;
  PolygonMesh mesh = test::flat_grid(kSize, kSize);
  for (glm::dvec3& p : mesh.positions) {
    p.z = 0.5 * (kA * p.x * p.x + kB * p.y * p.y);
  }
  for (const int level : {0, 1, 2, 4}) {
    const Tessellated c(mesh, level);
    const Curvatures curvatures = c.exact();
    glm::dvec3 low = mesh.positions.front(), high = low;
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    std::int64_t inside = 0;
    for (std::size_t v = 0; v < curvatures.mean.size(); ++v) {
      const glm::dvec3 p = c.tessellation.positions[v];
      // Two faces from the boundary, whose curves are polynomials of their own.
      if (p.x < low.x + 2.1 || p.x > high.x - 2.1 || p.y < low.y + 2.1 || p.y > high.y - 2.1)
        continue;
      ++inside;
      const double zx = kA * p.x, zy = kB * p.y, w = 1 + zx * zx + zy * zy;
      const double sign = c.tessellation.normals[v].z > 0 ? -1 : 1;
      const double mean = sign * 0.5 * ((1 + zy * zy) * kA + (1 + zx * zx) * kB) / std::pow(w, 1.5);
      ASSERT_NEAR(curvatures.gaussian[v], kA * kB / (w * w), 1e-6) << level << " " << v;
      ASSERT_NEAR(curvatures.mean[v], mean, 1e-6) << level << " " << v;
    }
    EXPECT_GT(inside, 8);
  }
}

// Where valence and size are 4 there is a polynomial; elsewhere what was given stays.
TEST(DerivativeCurvatures, LeaveExtraordinaryPlacesAlone) {
  const PolygonMesh mesh = test::cube();  // valence 3 at every vertex, faces of 4
  const Curvatures curvatures = Tessellated(mesh, 2).exact(-7, -8);
  for (std::size_t v = 0; v < curvatures.mean.size(); ++v) {
    EXPECT_EQ(curvatures.mean[v] == -7, v < 8) << v;
    EXPECT_EQ(curvatures.gaussian[v] == -8, v < 8) << v;
  }
}

TEST(DerivativeCurvatures, AreWhatNormalsApproach) {
  const PolygonMesh mesh = test::torus(24, 12, 2, 1);
  double last = 1e9;
  for (const int level : {2, 3, 4}) {
    const Tessellated c(mesh, level);
    const Curvatures exact = c.exact(), normals = curvatures_of_normals(c.tessellation);
    double sum = 0;
    for (std::size_t v = 0; v < exact.mean.size(); ++v) {
      ASSERT_NE(exact.mean[v], -7.0f);
      sum += std::abs(exact.mean[v] - normals.mean[v]);
    }
    const double mean_gap = sum / static_cast<double>(exact.mean.size());
    EXPECT_LT(mean_gap, 0.6 * last);
    last = mean_gap;
  }
  EXPECT_LT(last, 0.01);
}

TEST(DerivativeCurvatures, ScaleWithTheModel) {
  PolygonMesh mesh = test::torus(12, 8, 2, 1);
  const Curvatures small = Tessellated(mesh, 1).exact();
  for (glm::dvec3& p : mesh.positions) p *= 10;
  const Curvatures large = Tessellated(mesh, 1).exact();
  for (std::size_t v = 0; v < small.mean.size(); ++v) {
    EXPECT_NEAR(small.mean[v], 10 * large.mean[v], 1e-6);
    EXPECT_NEAR(small.gaussian[v], 100 * large.gaussian[v], 1e-5);
  }
}

TEST(DerivativeCurvatures, AreNamedByTheFields) {
  const PolygonMesh mesh = test::torus(12, 8, 2, 1);
  const Tessellated c(mesh, 1);
  const VertexFields fields = vertex_fields(c.tessellation, mesh, 1, &c.surface);
  EXPECT_STREQ(name_of(fields.curvature_source), "second derivatives");
  EXPECT_EQ(fields.curvatures.mean, c.exact().mean);
  EXPECT_STREQ(name_of(vertex_fields(c.tessellation, mesh, 1).curvature_source), "normals");
}

// A surface of four quads over one face from 0 to 2, its texture as `uv` has it.
template <class Uv>
TextureSlide slide_of(const PolygonMesh& mesh, double height, const Uv& uv) {
  SurfaceMesh surface;
  surface.level = 1;
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 2; ++i) {
      const bool is_middle = i == 1 && j == 1;
      surface.positions.emplace_back(i, j, is_middle ? height : 0.0);
      surface.normals.emplace_back(0, 0, 1);
      surface.uvs.push_back(uv(surface.positions.back()));
    }
  for (const auto& quad : {std::array{0, 1, 4, 3}, std::array{1, 2, 5, 4}, std::array{4, 5, 8, 7},
                           std::array{3, 4, 7, 6}})
    surface.face_vertices.insert(surface.face_vertices.end(), quad.begin(), quad.end());
  surface.face_uvs = surface.face_vertices;
  return texture_slide(*blocks_of(surface, mesh), mesh);
}

PolygonMesh square(double across, double up) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  mesh.add_face(std::array{0, 1, 2, 3});
  mesh.uvs = {{0, 0}, {across, 0}, {across, up}, {0, up}};
  mesh.face_uvs = {0, 1, 2, 3};
  return mesh;
}

TEST(TextureSlide, IsNothingWhereTheTextureIsTheInputs) {
  const TextureSlide slide =
      slide_of(square(1, 0.5), 0, [](const glm::dvec3& p) { return glm::dvec2(p.x / 2, p.y / 4); });
  EXPECT_LT(slide.largest, 1e-15);
  EXPECT_LT(slide.largest_distance, 1e-15);
}

// The middle lies over that of the face, and its texture by 0.1 of u and 0.2 of v beside it: that
// is 0.2 and 0.8 along a face whose texture is half as wide as it, and a quarter as high.
TEST(TextureSlide, IsWhatTheTextureLacks) {
  const auto moved = [](const glm::dvec3& p) {
    const bool is_middle = p.x == 1 && p.y == 1;
    return glm::dvec2(p.x / 2, p.y / 4) + (is_middle ? glm::dvec2(0.1, 0.2) : glm::dvec2(0));
  };
  const TextureSlide slide = slide_of(square(1, 0.5), 0, moved);
  EXPECT_NEAR(slide.largest, std::hypot(0.1, 0.2), 1e-15);
  EXPECT_NEAR(slide.largest_distance, std::hypot(0.2, 0.8), 1e-14);
  // The middle is one corner of each quad, which are alike.
  EXPECT_NEAR(slide.rms, slide.largest / 2, 1e-15);
  EXPECT_NEAR(slide.rms_distance, slide.largest_distance / 2, 1e-14);
  EXPECT_EQ(slide.face, 0);
  // Seen from above it is the same.
  EXPECT_NEAR(slide_of(square(1, 0.5), 0.3, moved).largest, std::hypot(0.1, 0.2), 1e-15);
}

// Where all of the texture lies on a line there is no way across it.
TEST(TextureSlide, HasNoDistanceWhereTheTextureHasNoArea) {
  const TextureSlide slide =
      slide_of(square(1, 0), 0, [](const glm::dvec3& p) { return glm::dvec2(p.x / 2, 0.3); });
  EXPECT_NEAR(slide.largest, 0.3, 1e-15);
  EXPECT_EQ(slide.largest_distance, 0);
  EXPECT_EQ(slide.face, -1);
}

// Faces without texture coordinates do not count.
TEST(TextureSlide, LeavesOutFacesWithoutATexture) {
  PolygonMesh mesh = square(1, 1);
  mesh.face_uvs[2] = -1;
  const TextureSlide slide = slide_of(mesh, 0, [](const glm::dvec3&) { return glm::dvec2(9); });
  EXPECT_EQ(slide.largest, 0);
  EXPECT_EQ(slide.rms, 0);
}

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
