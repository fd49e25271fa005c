#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/choice.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "support/cut_quads.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Whether triangles are joined to quads: where they look like halves of some, and the surface is
// better for it.

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
      options.fit.method = method;
      EXPECT_TRUE(verify_cage(cage, mesh, options).confirmed);
      options.fit.quads = fit.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
      EXPECT_TRUE(verify_cage(cage, mesh, options).confirmed);
      options.fit.quads = fit.pairs_triangles ? QuadChoice::Off : QuadChoice::On;
      EXPECT_THROW((void)verify_cage(cage, mesh, options), Error) << "of other faces";
      options.fit.quads = QuadChoice::Auto;
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

double folds_of(const PolygonMesh& mesh, const Fit& fitted, Backend& backend) {
  double area = 0;
  for (const int level : {1, 2, 3}) {
    const SurfaceMesh surface = evaluate(mesh, fitted, backend, {.level = level});
    area = std::max(area, surface_quality(surface, mesh).folded_area_elsewhere);
  }
  return area;
}

double fair_folds(const PolygonMesh& mesh, Backend& backend) {
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  return folds_of(mesh, fit(mesh, backend, options), backend);
}

std::vector<std::pair<std::int32_t, std::int32_t>> edges_of(const PolygonMesh& mesh) {
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const CreaseEdge& crease : mesh.creases) edges.emplace_back(crease.v0, crease.v1);
  return edges;
}

// Two finely drawn bands along three quarters of a circle above each other, and quads between.
PolygonMesh arc_plate(int n) {
  PolygonMesh mesh = test::prism(n);
  const int half = n / 2;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int i = v % n;
    const bool is_outer = i < half;
    const double along = static_cast<double>(is_outer ? i : n - 1 - i) / (half - 1);
    const double angle = 1.5 * std::numbers::pi * along, radius = is_outer ? 1 : 0.7;
    mesh.positions[v].x = radius * std::cos(angle);
    mesh.positions[v].y = radius * std::sin(angle);
  }
  return mesh;
}

// The finer one folds by 2e-4 of the area at level 3, for which 5 % of its creases are too many.
TEST(FoundCreases, StayAroundFinelyDrawnPlates) {
  const auto backend = make_cpu_backend();
  for (const int corners : {1000, 10'000}) {
    const FittedMesh fitted = fit_mesh(arc_plate(corners), "plate", *backend);
    EXPECT_EQ(fitted.mesh.creases.size(), 2u * static_cast<unsigned>(corners) + 4);
    EXPECT_EQ(fitted.rounded_count, 0);
    const SurfaceQuality quality =
        surface_quality(evaluate(fitted.mesh, fitted.fit, *backend, {.level = 1}), fitted.mesh);
    EXPECT_LT(quality.rms_normal_deviation, 0.5) << corners;
    EXPECT_EQ(quality.folded_area, 0) << corners;
  }
}

TEST(FoundCreases, AreTakenBackWhereTheyFoldTheSurface) {
  const auto backend = make_cpu_backend({Precision::Double});
  int taken_back = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const PolygonMesh given = test::jittered(test::icosphere(2), 0.25, seed);
    PolygonMesh mesh = given;
    const auto prepared = prepare_mesh(mesh, "ball");
    const FoundCreases found = add_features(mesh, prepared, {.every = 30});
    const PolygonMesh all = mesh;
    const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, {});
    const double area = folds_of(mesh, creased.fit, *backend);
    EXPECT_LE(area, fair_folds(given, *backend)) << seed;
    EXPECT_LE(area, fair_folds(all, *backend)) << seed;
    taken_back += creased.found.edges.size() < found.edges.size();
    // What is left alone says which tags there are.
    PolygonMesh again = given;
    add_tags(again, creased.found);
    EXPECT_EQ(edges_of(again), edges_of(mesh));
    EXPECT_EQ(again.corners.size(), mesh.corners.size());
  }
  EXPECT_GT(taken_back, 0);
}

TEST(FoundCreases, StayWhereNothingFolds) {
  const auto backend = make_cpu_backend({Precision::Double});
  PolygonMesh mesh = test::cube();
  const FoundCreases found = add_features(mesh, prepare_mesh(mesh, "cube"));
  const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, {});
  EXPECT_EQ(mesh.creases.size(), 12u);
  EXPECT_EQ(creased.found.edges.size(), 12u);
  EXPECT_EQ(creased.fit.sharp_edge_count, 12);
}

TEST(FoundCreases, LeaveGivenTagsAlone) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1}};
  const auto prepared = prepare_mesh(mesh, "cube");
  FoundCreases found = add_features(mesh, prepared);
  EXPECT_EQ(mesh.creases.size(), 12u);
  const std::vector<std::int32_t> smooth{0};
  leave_smooth(mesh, found, smooth);
  EXPECT_EQ(mesh.creases.size(), 10u) << "of three at the vertex one is the file's";
  EXPECT_EQ(found.edges.size(), 9u);
}

TEST(FoundCreases, GiveTheWarningsOfTheFitThatIsTaken) {
  const auto backend = make_cpu_backend({Precision::Double});
  int folded = 0;
  for (const double amount : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    PolygonMesh mesh = test::jittered(test::icosphere(2), amount, 1);
    const FoundCreases found;
    std::vector<Warning> warnings;
    FitOptions options;
    options.callbacks.warning = [&](const Warning& warning) { warnings.push_back(warning); };
    const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, options);
    const std::int64_t left = creased.fit.fair->flagged_edges + creased.fit.fair->flagged_faces;
    ASSERT_EQ(warnings.size(), left > 0 ? 1u : 0u) << amount;
    if (left == 0) continue;
    ++folded;
    EXPECT_EQ(warnings[0].code, "folds-left");
    EXPECT_EQ(warnings[0].count, left);
  }
  EXPECT_GT(folded, 0) << "else nothing was tested";
}

}  // namespace
}  // namespace planish

namespace planish::test {
namespace {

// Which surface is taken where something is left open, by what, and what is said of it.

using testing::HasSubstr;

// A device on which fair nets go wrong: all of their points are in one place.
class MissingBackend final : public Backend, public FairBuilder {
 public:
  [[nodiscard]] DeviceDescription description() const override { return host_->description(); }
  std::unique_ptr<Solve> make_solve(const SummedView& masks) override {
    return host_->make_solve(masks);
  }
  [[nodiscard]] std::uint64_t peak_device_bytes() const override { return 0; }
  FairNet build_fair_net(const FairTopology& topology, std::span<const glm::dvec3>,
                         const FairOptions&) override {
    FairNet net;
    net.state.resize(static_cast<std::size_t>(topology.state_size));
    return net;
  }

 private:
  std::unique_ptr<Backend> host_ = make_cpu_backend();
};

// Of the mesh's own faces, round: only the method is left open.
MeshFitOptions only_method() {
  MeshFitOptions options;
  options.chooses_creases = false;
  options.quads = QuadChoice::Off;
  options.refine = RefineChoice::Off;
  return options;
}

FittedMesh best_method(const PolygonMesh& mesh, Backend& backend,
                       const MeshFitOptions& options = only_method()) {
  return fit_mesh(mesh, "mesh", backend, options);
}

const Candidate* made(const FittedMesh& fitted, InterpolationMethod method) {
  return fitted.choice->of(CandidateFaces::Given, method);
}

TEST(Choice, CostsAreOfOneTable) {
  const PartFigures good{.bending = 10};
  const auto with = [&](const auto& change) {
    PartFigures other = good;
    change(other);
    return other.cost() - good.cost();
  };
  EXPECT_NEAR(with([](PartFigures& p) { p.bending = 11; }), std::log(1.1), 1e-6);
  EXPECT_EQ(with([](PartFigures& p) { p.folded_area = 9e-6; }), 0) << "folds of so little are none";
  EXPECT_NEAR(with([](PartFigures& p) { p.folded_area = 1e-3; }), 10, 1e-9);
  EXPECT_GT(with([](PartFigures& p) { p.folded_area = 1e-4, p.bending = 5; }), 0);
  EXPECT_LT(with([](PartFigures& p) { p.doubt = 0.03, p.bending = 9; }), 0);
  EXPECT_GT(with([](PartFigures& p) { p.doubt = 0.04, p.bending = 9; }), 0);
  const Candidate one{.converged = true, .parts = {good}},
      two{.converged = true, .parts = {good, good}};
  EXPECT_DOUBLE_EQ(two.cost(), 2 * one.cost());
  Candidate missed{.converged = false, .parts = {PartFigures{.bending = 1e-9}}};
  EXPECT_GT(missed.cost(), one.cost());
}

Candidate bending(double amount) {
  return {.converged = true, .parts = {PartFigures{.bending = amount}}, .bending = amount};
}

TEST(Choice, TheFirstOfThoseThatAreAlikeIsTaken) {
  Choice choice;
  EXPECT_TRUE(enter(choice, bending(10)));
  EXPECT_FALSE(enter(choice, bending(10 * (1 - 1e-12)))) << "rounding decides nothing";
  EXPECT_TRUE(enter(choice, bending(9.9)));
  EXPECT_EQ(choice.taken, 2u);
  Choice flat;
  enter(flat, bending(1e-12));
  EXPECT_FALSE(enter(flat, bending(0))) << "both are flat";
}

TEST(Choice, TakesFairWhereProgressiveFolds) {
  const auto backend = make_cpu_backend();
  const FittedMesh best = best_method(delaunay_sphere(600, 1), *backend);
  EXPECT_EQ(best.options.method, InterpolationMethod::Fair);
  ASSERT_TRUE(best.fit.fair.has_value());
  EXPECT_GT(made(best, InterpolationMethod::Progressive)->folded_area, 1e-4);
  EXPECT_LT(made(best, InterpolationMethod::Fair)->folded_area, 1e-5);
  EXPECT_THAT(best.choice->reason, HasSubstr("fair: progressive folds"));
}

TEST(Choice, TakesTheFirstWhereBothAreAlike) {
  const auto backend = make_cpu_backend();
  const FittedMesh best = best_method(torus(24, 12, 1, 0.4), *backend);
  EXPECT_EQ(best.options.method, InterpolationMethod::Fair) << "it passes to rounding";
  EXPECT_EQ(best.choice->reason, "fair: progressive bends as much");
}

// Flat triangles of a coarse ellipsoid, on which fair is farther off by far.
TEST(Choice, TakesProgressiveWhereItBendsLess) {
  const auto backend = make_cpu_backend();
  const PolygonMesh coarse = icosphere(0);
  const glm::dvec3 axis =
      glm::normalize(coarse.positions[coarse.face(0)[0]] + coarse.positions[coarse.face(0)[1]]);
  PolygonMesh mesh = icosphere(1);
  for (glm::dvec3& p : mesh.positions) p -= 0.7 * glm::dot(p, axis) * axis;
  const FittedMesh best = best_method(mesh, *backend);
  EXPECT_EQ(best.options.method, InterpolationMethod::Progressive);
  EXPECT_FALSE(best.fit.fair.has_value());
  EXPECT_THAT(best.choice->reason, HasSubstr("progressive: it bends "));
}

// A flat disc of needles around hubs beside its middle: at level 1 the progressive surface looks
// whole, at level 2 it is folded.
TEST(Choice, LooksBetweenThePlacesOfLevelOne) {
  constexpr int kSides = 40;
  PolygonMesh mesh;
  for (const double z : {-0.04, 0.04}) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.3 * std::sin(5.3 * i * i)) / kSides;
      mesh.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    }
  }
  mesh.positions.emplace_back(0.55, -0.3, -0.04);
  mesh.positions.emplace_back(0.165, -0.5, 0.04);
  for (int i = 0; i < kSides; ++i) {
    const int next = (i + 1) % kSides;
    mesh.add_face(std::array{i, next, kSides + next});
    mesh.add_face(std::array{i, kSides + next, kSides + i});
    mesh.add_face(std::array{2 * kSides, next, i});
    mesh.add_face(std::array{2 * kSides + 1, kSides + i, kSides + next});
  }
  const auto backend = make_cpu_backend({Precision::Double});
  const Fit progressive = fit(mesh, *backend, {});
  EXPECT_LT(surface_quality(evaluate(mesh, progressive, *backend, {.level = 1}), mesh)
                .folded_area_elsewhere,
            kSoundFoldedArea);
  const FittedMesh best = best_method(mesh, *backend);
  EXPECT_EQ(best.options.method, InterpolationMethod::Fair);
  EXPECT_GT(made(best, InterpolationMethod::Progressive)->folded_area, kSoundFoldedArea);
}

TEST(Choice, SparesTheFairFitWhereFacesAreFollowedClosely) {
  const auto backend = make_cpu_backend();
  const FittedMesh best = best_method(icosphere(5), *backend);
  EXPECT_EQ(best.options.method, InterpolationMethod::Progressive);
  EXPECT_LT(best.chosen_quality()->rms_normal_deviation, kChoiceWeights.close_degrees);
  EXPECT_EQ(made(best, InterpolationMethod::Fair), nullptr);
  EXPECT_FALSE(made(best, InterpolationMethod::Progressive)->is_measured());
  EXPECT_THAT(best.choice->reason, HasSubstr("progressive: it does not fold"));
}

TEST(Choice, TakesFairWhereProgressiveDoesNotConverge) {
  const auto backend = make_cpu_backend();
  MeshFitOptions options = only_method();
  options.fit.max_iterations = 0;
  const FittedMesh best = best_method(icosphere(5), *backend, options);
  EXPECT_EQ(best.options.method, InterpolationMethod::Fair);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_EQ(best.choice->reason, "fair: progressive misses the tolerance");
}

TEST(Choice, TakesProgressiveWhereADevicesFairNetMissesTheTolerance) {
  MissingBackend backend;
  const FittedMesh best = best_method(torus(24, 12, 1, 0.4), backend);
  EXPECT_EQ(best.choice->reason, "progressive: fair misses the tolerance");
  EXPECT_EQ(best.options.method, InterpolationMethod::Progressive);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_FALSE(best.fit.fair.has_value());
}

// The figures that decide are those of the surfaces themselves.
TEST(Choice, ItsFiguresAreThoseOfBothSurfaces) {
  const auto backend = make_cpu_backend();
  const PolygonMesh mesh = icosphere(2);
  const FittedMesh best = best_method(mesh, *backend);
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    const SurfaceMesh surface =
        evaluate(mesh, fit(mesh, *backend, options), *backend, {.level = 2});
    EXPECT_NEAR(made(best, method)->bending, surface_quality(surface, mesh).bending, 1e-4);
  }
}

// Where the file has level 1 the choice is measured there, and the report's figures with it.
TEST(Choice, OfADenseMeshIsMeasuredAtLevelOne) {
  const auto backend = make_cpu_backend();
  PolygonMesh mesh = cut_quads(torus(200, 110, 1, 0.4));
  // So uneven that progressive folds.
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    glm::dvec3& p = mesh.positions[v];
    const double k = static_cast<double>(v),
                 along = std::atan2(p.y, p.x) + 0.008 * std::sin(37.7 * k * k),
                 around =
                     std::atan2(p.z, std::hypot(p.x, p.y) - 1) + 0.016 * std::sin(91.3 * k * k);
    const double radius = 1 + 0.4 * std::cos(around);
    p = {radius * std::cos(along), radius * std::sin(along), 0.4 * std::sin(around)};
  }
  const FittedMesh best = best_method(mesh, *backend);
  ASSERT_TRUE(best.density.is_dense());
  ASSERT_EQ(best.options.method, InterpolationMethod::Fair);
  const SurfaceQuality of_level_one =
      surface_quality(evaluate(best.mesh, best.fit, *backend, best.evaluate_options(1)), best.mesh);
  EXPECT_NEAR(made(best, InterpolationMethod::Fair)->bending, of_level_one.bending, 1e-4);
  ASSERT_NE(best.chosen_quality(), nullptr);
  EXPECT_EQ(best.chosen_quality()->bending, made(best, InterpolationMethod::Fair)->bending);
}

PolygonMesh shifted(PolygonMesh mesh, double by) {
  for (glm::dvec3& p : mesh.positions) p.x += by;
  return mesh;
}

// Halves of quads, uneven triangles and quads, each of which is best with other faces.
TEST(Choice, IsOfEachPartWhateverElseIsInTheFile) {
  const auto backend = make_cpu_backend();
  const PolygonMesh alone[] = {cut_quads(torus(24, 12, 1, 0.4)),
                               shifted(delaunay_sphere(300, 2), 3),
                               shifted(torus(24, 12, 1, 0.4), 6)};
  const CandidateFaces faces[] = {CandidateFaces::Quads, CandidateFaces::Refined,
                                  CandidateFaces::Given};
  std::int64_t added = 0;
  for (int i = 0; i < 3; ++i) {
    const FittedMesh fitted = fit_mesh(alone[i], "part", *backend);
    EXPECT_EQ(fitted.choice->best().faces, faces[i]) << i;
    added += std::ssize(fitted.added_vertices);
  }
  std::array<int, 3> order{0, 1, 2};
  do {
    const PolygonMesh all[] = {alone[order[0]], alone[order[1]], alone[order[2]]};
    const FittedMesh fitted = fit_mesh(merged_meshes(all).mesh, "all", *backend);
    ASSERT_EQ(fitted.choice->best().faces, CandidateFaces::Mixed) << fitted.choice->faces_reason;
    ASSERT_EQ(fitted.choice->best().parts.size(), 3u);
    for (int p = 0; p < 3; ++p)
      EXPECT_EQ(fitted.choice->best().parts[p].faces, faces[order[p]]) << p;
    EXPECT_EQ(fitted.paired_count, 288);
    EXPECT_EQ(std::ssize(fitted.added_vertices), added);
    // Each given vertex is passed, and each face has its source.
    const SurfaceMesh surface =
        evaluate(fitted.mesh, fitted.fit, *backend, fitted.evaluate_options(0));
    for (std::size_t v = 0; v < merged_meshes(all).mesh.positions.size(); ++v)
      EXPECT_LT(glm::distance(surface.positions[v], merged_meshes(all).mesh.positions[v]), 1e-9);
    ASSERT_EQ(std::ssize(fitted.source_faces), fitted.mesh.face_count());
    for (std::int32_t f = 0; f < fitted.mesh.face_count(); ++f) {
      const glm::dvec3& own = fitted.mesh.positions[fitted.mesh.face(f)[0]];
      const PolygonMesh given = merged_meshes(all).mesh;
      const glm::dvec3& source = given.positions[given.face(fitted.source_faces[f])[0]];
      EXPECT_LT(std::abs(own.x - source.x), 1.5) << "of another part";
    }
  } while (std::ranges::next_permutation(order).found);
}

// A box: flat faces in triangles, whose rims alone turn.
TEST(Features, AreKeptWithoutAFlag) {
  const auto backend = make_cpu_backend();
  PolygonMesh box;
  for (const auto& face : faces_of(cube())) {
    box.add_face(std::array{face[0], face[1], face[2]});
    box.add_face(std::array{face[0], face[2], face[3]});
  }
  box.positions = cube().positions;
  const FittedMesh fitted = fit_mesh(box, "box", *backend);
  EXPECT_TRUE(fitted.finds_features);
  EXPECT_EQ(fitted.creases(), "auto");
  EXPECT_EQ(fitted.mesh.creases.size(), 12u);
  EXPECT_NEAR(fitted.chosen_quality()->rms_normal_deviation, 0, 1e-4);
  EXPECT_THAT(fitted.choice->reason, HasSubstr("12 edges kept sharp"));
  EXPECT_THAT(fitted.choice->reason, HasSubstr("--creases use"));
  MeshFitOptions none;
  none.chooses_creases = false;
  EXPECT_TRUE(fit_mesh(box, "box", *backend, none).mesh.creases.empty());
  PolygonMesh tagged = box;
  tagged.creases = {{fitted.mesh.creases.front()}};
  EXPECT_EQ(fit_mesh(tagged, "box", *backend).mesh.creases.size(), 1u) << "who tags has chosen";
}

// In polygons and in triangles.
TEST(Features, OfPrismsAndSolidsAreTheirEdges) {
  const auto backend = make_cpu_backend();
  for (const auto& [mesh, edges] : {std::pair{prism(6), 18u},
                                    {as_triangles(prism(6)), 18u},
                                    {prism(8), 16u},
                                    {as_triangles(prism(8)), 16u},
                                    {cube(), 12u},
                                    {bipyramid(4), 12u}}) {
    const FittedMesh fitted = fit_mesh(mesh, "mesh", *backend);
    EXPECT_EQ(fitted.mesh.creases.size(), edges);
    if (edges != 16) {
      EXPECT_NEAR(fitted.chosen_quality()->rms_normal_deviation, 0, 1e-4);
    }
  }
}

TEST(Features, RoundShapesHaveNone) {
  const auto backend = make_cpu_backend();
  for (const PolygonMesh& mesh :
       {icosphere(0), icosphere(2), torus(24, 12, 1, 0.4), jittered(icosphere(3), 0.02, 1)}) {
    const FittedMesh fitted = fit_mesh(mesh, "mesh", *backend);
    EXPECT_TRUE(fitted.mesh.creases.empty()) << mesh.vertex_count();
    EXPECT_TRUE(fitted.mesh.corners.empty()) << mesh.vertex_count();
  }
}

// A ball of 24 by 9 faces with a bore along its axis.
PolygonMesh bored_ball() {
  constexpr int kAround = 24, kRings = 10;
  PolygonMesh mesh;
  for (int ring = 0; ring < kRings; ++ring) {
    const double latitude = 1.16 - 2.32 * ring / (kRings - 1);
    for (int i = 0; i < kAround; ++i) {
      const double around = 2 * std::numbers::pi * i / kAround;
      mesh.positions.emplace_back(std::cos(latitude) * std::cos(around),
                                  std::cos(latitude) * std::sin(around), std::sin(latitude));
    }
  }
  for (int ring = 0; ring < kRings; ++ring) {
    for (int i = 0; i < kAround; ++i) {
      const int above = ring * kAround, below = (ring + 1) % kRings * kAround;
      const int next = (i + 1) % kAround;
      mesh.add_face(std::array{above + i, below + i, below + next, above + next});
    }
  }
  return mesh;
}

// Its faces turn by 15 degrees, in sum more than the rims do. A dent changes nothing far from it.
TEST(Features, AreRimsOfABallWithABore) {
  const auto backend = make_cpu_backend();
  PolygonMesh ball = bored_ball();
  for (const double dent : {1.0, 1.08}) {
    ball.positions[5 * 24] *= dent;
    for (const PolygonMesh& mesh : {ball, as_triangles(ball)}) {
      const FittedMesh fitted = fit_mesh(mesh, "ball", *backend);
      EXPECT_EQ(fitted.mesh.creases.size(), 48u) << dent;
    }
  }
}

// A fit that is not taken has nothing to warn of.
TEST(Choice, GivesOnlyTheWarningsOfTheFitThatIsTaken) {
  const auto backend = make_cpu_backend();
  PolygonMesh mesh = torus(8, 4, 1, 0.4);
  mesh.creases = {{mesh.face(0)[0], mesh.face(0)[1], 1}};  // semi-sharp: both fits warn
  MeshFitOptions options = only_method();
  options.fit.obeys_semi_sharp = false;
  std::vector<std::string> codes;
  options.fit.callbacks.warning = [&](const Warning& warning) { codes.push_back(warning.code); };
  const FittedMesh best = best_method(mesh, *backend, options);
  EXPECT_EQ(best.choice->candidates.size(), 2u);
  EXPECT_EQ(codes, std::vector<std::string>{"semi-sharp-creases"});
}

// Two faces of 46,342 corners: limit masks without sums would have more entries than 2^31.
TEST(Choice, TriesProgressiveWhateverTheFaces) {
  const auto backend = make_cpu_backend({Precision::Double});
  const PolygonMesh mesh = prism(46'342);
  const FittedMesh best = best_method(mesh, *backend);
  ASSERT_TRUE(made(best, InterpolationMethod::Progressive));
  EXPECT_TRUE(made(best, InterpolationMethod::Progressive)->converged);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_TRUE(fit(mesh, *backend, {}).interpolation.converged);
}

}  // namespace
}  // namespace planish::test
