// Which surface is taken where something is left open, by what, and what is said of it.
#include "planish/pipeline/choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "support/cut_quads.h"
#include "support/delaunay_sphere.h"
#include "support/meshes.h"
#include "support/primal_meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

// A device on which fair nets go wrong: all of their points are in one place.
class MissingBackend final : public Backend, public FairBuilder {
 public:
  [[nodiscard]] DeviceDescription description() const override { return host_->description(); }
  std::unique_ptr<Solve> make_solve(const SummedView& masks) override {
    return host_->make_solve(masks);
  }
  std::unique_ptr<DevicePoints> upload(std::span<const glm::dvec3> points) override {
    return host_->upload(points);
  }
  std::unique_ptr<DevicePoints> allocate(std::int32_t count) override {
    return host_->allocate(count);
  }
  std::vector<glm::dvec3> download(const DevicePoints& points) override {
    return host_->download(points);
  }
  void apply(const StencilView<double>& table, const DevicePoints& source, DevicePoints& target,
             std::int32_t first_target) override {
    host_->apply(table, source, target, first_target);
  }
  void apply_limit(const StencilView<double>& table, const DevicePoints& source,
                   std::span<glm::dvec3> positions, std::span<glm::vec3> normals) override {
    host_->apply_limit(table, source, positions, normals);
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
