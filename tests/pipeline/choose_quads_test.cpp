// Whether triangles are joined to quads: where they look like halves of some, and the surface is
// better for it.
#include "planish/pipeline/fit_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/surface/evaluate.h"
#include "support/cut_quads.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

using test::cut_quads;

FittedMesh fitted(const PolygonMesh& mesh, QuadChoice quads, MeshFitOptions options = {},
                  int threads = 0) {
  options.quads = quads;
  return fit_mesh(mesh, "mesh", *make_cpu_backend({.thread_count = threads}), options);
}

// Whether a surface of such faces was made.
bool tries(const FittedMesh& fit, CandidateFaces faces) {
  return fit.choice && std::ranges::any_of(fit.choice->candidates, [&](const Candidate& candidate) {
           return candidate.faces == faces;
         });
}

RawVector<glm::dvec3> points_of(const FittedMesh& fit) {
  return evaluate(fit.mesh, fit.fit, *make_cpu_backend(), fit.evaluate_options(1)).positions;
}

// Of a torus of radii 1 and 0.4, in degrees.
double worst_normal(const FittedMesh& fit) {
  const SurfaceMesh surface =
      evaluate(fit.mesh, fit.fit, *make_cpu_backend(), fit.evaluate_options(2));
  double least = 1;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const glm::dvec3& p = surface.positions[i];
    const glm::dvec3 middle = glm::normalize(glm::dvec3(p.x, p.y, 0));
    least = std::min(least, glm::dot(glm::normalize(p - middle), glm::dvec3(surface.normals[i])));
  }
  return std::acos(least) * 180 / std::numbers::pi;
}

TEST(ChooseQuads, JoinsHalvesWhereTheSurfaceIsBetter) {
  const PolygonMesh mesh = cut_quads(test::torus(32, 16, 1, 0.4));
  const FittedMesh chosen = fitted(mesh, QuadChoice::Auto);
  EXPECT_TRUE(chosen.pairs_triangles);
  EXPECT_EQ(chosen.paired_count, 512);
  EXPECT_EQ(chosen.mesh.face_count(), 512);
  EXPECT_EQ(chosen.choice->best().faces, CandidateFaces::Quads);
  EXPECT_THAT(chosen.choice->faces_reason, testing::HasSubstr("--quads off"));
  EXPECT_EQ(points_of(chosen), points_of(fitted(mesh, QuadChoice::On)));
  const FittedMesh triangles = fitted(mesh, QuadChoice::Off, {.refine = RefineChoice::Off});
  EXPECT_EQ(triangles.paired_count, 0);
  EXPECT_EQ(triangles.mesh.face_count(), 1024);
  EXPECT_LT(worst_normal(chosen), 0.2 * worst_normal(triangles));
}

TEST(ChooseQuads, LeavesOtherTrianglesAsTheyAre) {
  for (const PolygonMesh& mesh :
       {test::icosphere(2), test::icosphere(3), test::jittered(test::icosphere(3), 0.03, 5)}) {
    const FittedMesh chosen = fitted(mesh, QuadChoice::Auto);
    EXPECT_FALSE(chosen.pairs_triangles);
    ASSERT_TRUE(tries(chosen, CandidateFaces::Quads)) << "of so few it costs little";
    EXPECT_NE(chosen.choice->best().faces, CandidateFaces::Quads);
    EXPECT_EQ(points_of(chosen), points_of(fitted(mesh, QuadChoice::Off)));
  }
  EXPECT_FALSE(tries(fitted(test::torus(24, 12, 1, 0.4), QuadChoice::Auto), CandidateFaces::Quads));
}

TEST(ChooseQuads, MakesNoSecondFitForAFewHalves) {
  const PolygonMesh sheet = cut_quads(test::grid(
      4, 4, [](double x, double y) { return glm::dvec3(x, y, 0.1 * std::sin(x) * std::cos(y)); }));
  for (const int fans : {200, 400}) {
    const PolygonMesh meshes[] = {test::bipyramid(fans), sheet};
    const PolygonMesh mesh = merged_meshes(meshes).mesh;
    EXPECT_EQ(fitted(mesh, QuadChoice::On).paired_count, 16);
    const bool is_compared = 32 > 0.05 * mesh.face_count();
    EXPECT_EQ(tries(fitted(mesh, QuadChoice::Auto), CandidateFaces::Quads), is_compared) << fans;
  }
}

// A box of twelve triangles has its edges kept sharp, and as six squares, too, which are a ball
// else. All is flat: fewer faces, on which texture coordinates run straight.
TEST(ChooseQuads, JoinsWhatIsFlat) {
  PolygonMesh box = cut_quads(test::cube());
  for (const glm::dvec3& p : box.positions) box.uvs.emplace_back(p.x + 0.3 * p.z, p.y + 0.7 * p.z);
  box.face_uvs = box.face_vertices;
  for (const QuadChoice quads : {QuadChoice::Auto, QuadChoice::On}) {
    const FittedMesh chosen = fitted(box, quads);
    EXPECT_TRUE(chosen.pairs_triangles);
    EXPECT_EQ(chosen.mesh.creases.size(), 12u);
    const SurfaceMesh surface = evaluate(chosen.mesh, chosen.fit, *make_cpu_backend());
    ASSERT_EQ(surface.face_uvs.size(), surface.face_vertices.size());
    for (std::size_t c = 0; c < surface.face_uvs.size(); ++c) {
      const glm::dvec3& p = surface.positions[surface.face_vertices[c]];
      const glm::dvec2& uv = surface.uvs[surface.face_uvs[c]];
      EXPECT_NEAR(uv.x, p.x + 0.3 * p.z, 1e-6);
      EXPECT_NEAR(uv.y, p.y + 0.7 * p.z, 1e-6);
    }
  }
  EXPECT_THAT(fitted(box, QuadChoice::Auto).choice->faces_reason, testing::HasSubstr("flat"));
}

TEST(ChooseQuads, CagesOfBothMethodsAreVerified) {
  const PolygonMesh mesh = cut_quads(test::torus(24, 12, 1, 0.4));
  const PolygonMesh ball = test::icosphere(1);
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    for (const QuadChoice quads : {QuadChoice::Auto, QuadChoice::Off}) {
      const FittedMesh fit = fitted(mesh, quads, {.method = method});
      EXPECT_EQ(fit.pairs_triangles, quads == QuadChoice::Auto);
      const PolygonMesh cage = control_cage(fit.mesh, fit.fit, fit.options.sharp);
      VerifyOptions options;
      options.method = method;
      EXPECT_TRUE(verify_cage(cage, mesh, options).confirmed);
      options.quads = fit.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
      EXPECT_TRUE(verify_cage(cage, mesh, options).confirmed);
      options.quads = fit.pairs_triangles ? QuadChoice::Off : QuadChoice::On;
      EXPECT_THROW((void)verify_cage(cage, mesh, options), Error) << "of other faces";
      options.quads = QuadChoice::Auto;
      EXPECT_THROW((void)verify_cage(cage, ball, options), Error) << "of another mesh";
    }
  }
}

// Two triangles that turn by 20 degrees.
TEST(ChooseQuads, WhatMayBeFoundSharpIsNeverJoined) {
  const PolygonMesh ridge = test::make_mesh(
      {{0, 0, 0}, {0, 1, 0}, {-0.5, 0.5, -0.0882}, {0.5, 0.5, -0.0882}}, {{0, 1, 2}, {1, 0, 3}});
  EXPECT_EQ(fitted(ridge, QuadChoice::On, {.chooses_creases = false}).paired_count, 1);
  EXPECT_EQ(fitted(ridge, QuadChoice::On, {.crease_degrees = 15}).paired_count, 0);
}

TEST(ChooseQuads, IsTheSameForAnyNumberOfThreads) {
  for (const PolygonMesh& mesh : {test::jittered(cut_quads(test::torus(40, 20, 1, 0.4)), 0.005, 3),
                                  cut_quads(test::cube())}) {
    const FittedMesh one = fitted(mesh, QuadChoice::Auto, {}, 1);
    const FittedMesh three = fitted(mesh, QuadChoice::Auto, {}, 3);
    EXPECT_EQ(one.choice->faces_reason, three.choice->faces_reason);
    ASSERT_EQ(one.choice->candidates.size(), three.choice->candidates.size());
    for (std::size_t i = 0; i < one.choice->candidates.size(); ++i)
      EXPECT_EQ(one.choice->candidates[i].bending, three.choice->candidates[i].bending);
    EXPECT_EQ(one.mesh.face_vertices, three.mesh.face_vertices);
    EXPECT_EQ(points_of(one), points_of(three));
  }
}

// A cut grid says what its triangles are by itself; parts, flat or sharp everywhere, do not.
TEST(ChooseQuads, MakesOneSurfaceOfPlainHalves) {
  const FittedMesh plain = fitted(cut_quads(test::torus(32, 16, 1, 0.4)), QuadChoice::Auto);
  EXPECT_TRUE(plain.pairs_triangles);
  EXPECT_FALSE(tries(plain, CandidateFaces::Given));
  const FittedMesh part = fitted(cut_quads(test::cube()), QuadChoice::Auto);
  EXPECT_TRUE(tries(part, CandidateFaces::Quads) && tries(part, CandidateFaces::Given));
}

// A barrel of 16 staves whose lid lies a little below its rim, its axis along z.
PolygonMesh barrel() {
  constexpr int kStaves = 16;
  const std::vector<glm::dvec2> profile{{0.4, 0},   {0.5, 0.3},  {0.55, 0.6}, {0.5, 0.9},
                                        {0.4, 1.2}, {0.35, 1.2}, {0.35, 1.15}};
  const auto rings = static_cast<int>(profile.size());
  PolygonMesh mesh;
  for (const glm::dvec2& at : profile)
    for (int i = 0; i < kStaves; ++i) {
      const double angle = 2 * std::numbers::pi * i / kStaves;
      mesh.positions.emplace_back(at.x * std::cos(angle), at.x * std::sin(angle), at.y);
    }
  mesh.positions.emplace_back(0, 0, 0);
  mesh.positions.emplace_back(0, 0, 1.15);
  for (int i = 0; i < kStaves; ++i) {
    const int next = (i + 1) % kStaves, last = (rings - 1) * kStaves;
    mesh.add_face(std::array{rings * kStaves, next, i});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      const int below = ring * kStaves, above = below + kStaves;
      mesh.add_face(std::array{below + i, below + next, above + next});
      mesh.add_face(std::array{below + i, above + next, above + i});
    }
    mesh.add_face(std::array{last + i, last + next, rings * kStaves + 1});
  }
  return mesh;
}

// 48 vertices say so, every one, and what the rim bends does not count.
TEST(ChooseQuads, AllOfAFewVerticesAreEnough) {
  const FittedMesh chosen = fitted(barrel(), QuadChoice::Auto);
  EXPECT_TRUE(chosen.pairs_triangles);
  EXPECT_FALSE(tries(chosen, CandidateFaces::Given));
  // It has the mirror symmetry of the quads, which their diagonals have not.
  const auto leaves_its_image = [](const FittedMesh& fit) {
    const RawVector<glm::dvec3> points = points_of(fit);
    double farthest = 0;
    for (const glm::dvec3& p : points) {
      double nearest = 1;
      for (const glm::dvec3& q : points)
        nearest = std::min(nearest, glm::distance(p, glm::dvec3(q.x, -q.y, q.z)));
      farthest = std::max(farthest, nearest);
    }
    return farthest;
  };
  EXPECT_LT(leaves_its_image(chosen), 1e-5);
  EXPECT_GT(leaves_its_image(fitted(barrel(), QuadChoice::Off)), 1e-2);
}

// Quads that fold are no cure: where they are plainly meant, the triangles' surface is made too.
TEST(ChooseQuads, TriesTrianglesWherePlainQuadsFold) {
  PolygonMesh mesh = cut_quads(test::torus(24, 12, 1, 0.4));
  // A spike, far out of its neighbours' planes.
  mesh.positions[5] *= 3.0;
  const FittedMesh chosen =
      fitted(mesh, QuadChoice::Auto, {.method = InterpolationMethod::Progressive});
  EXPECT_TRUE(tries(chosen, CandidateFaces::Given));
  const Candidate* const quads =
      chosen.choice->of(CandidateFaces::Quads, InterpolationMethod::Progressive);
  ASSERT_NE(quads, nullptr);
  EXPECT_GT(quads->folded_area, 1e-5);
}

// Both fits are of a mesh that repair has to mend, which is told of once.
TEST(ChooseQuads, TellsWarningsOnceAndNumbersOfTheFile) {
  PolygonMesh mesh = cut_quads(test::torus(24, 12, 1, 0.4));
  std::swap(mesh.face_vertices[1], mesh.face_vertices[2]);
  std::vector<std::string> heard;
  MeshFitOptions options;
  options.fit.callbacks.warning = [&](const Warning& w) { heard.push_back(w.message); };
  const FittedMesh fit = fitted(mesh, QuadChoice::Auto, options);
  EXPECT_TRUE(fit.pairs_triangles);
  EXPECT_EQ(heard.size(), 1u);
  EXPECT_EQ(fit.warnings.size(), 1u);
  ASSERT_EQ(std::ssize(fit.source_faces), 288);
  for (const std::int32_t face : fit.source_faces) EXPECT_LT(face, 576);
}

// Loop and Catmull-Clark have no measured choice.
TEST(ChooseQuads, IsOfDooSabinAlone) {
  MeshFitOptions options;
  options.fit.scheme = Scheme::CatmullClark;
  const PolygonMesh mesh = cut_quads(test::torus(12, 8, 1, 0.4));
  EXPECT_EQ(fitted(mesh, QuadChoice::Auto, options).paired_count, 0);
  EXPECT_EQ(fitted(mesh, QuadChoice::On, options).paired_count, 96);
}

}  // namespace
}  // namespace planish
