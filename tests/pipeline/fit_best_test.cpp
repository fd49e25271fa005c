#include "planish/pipeline/fit_best.h"
#include "planish/pipeline/fit_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "planish/backend/cpu_backend.h"
#include "planish/fair/fair_builder.h"
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

TEST(FitBest, TakesFairWhereProgressiveFolds) {
  const auto backend = make_cpu_backend();
  const BestFit best = fit_best(delaunay_sphere(600, 1), *backend);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  ASSERT_TRUE(best.fit.fair.has_value());
  EXPECT_GT(best.progressive->folded_area_elsewhere, 1e-4);
  ASSERT_TRUE(best.fair.has_value());
  EXPECT_LT(best.fair->folded_area_elsewhere, 1e-5);
  EXPECT_THAT(best.reason, HasSubstr("fair: progressive folds"));
}

TEST(FitBest, TakesFairWhereBothAreAlike) {
  const auto backend = make_cpu_backend();
  const BestFit best = fit_best(torus(24, 12, 1, 0.4), *backend);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  EXPECT_EQ(best.progressive->folded_area, 0.0);
  EXPECT_THAT(best.reason, HasSubstr("not clearly nearer"));
}

// Flat triangles of a coarse ellipsoid, which itself tells that fair is farther off by far.
TEST(FitBest, TakesProgressiveWhereItIsClearlyBetter) {
  const auto backend = make_cpu_backend();
  const PolygonMesh coarse = icosphere(0);
  const glm::dvec3 axis =
      glm::normalize(coarse.positions[coarse.face(0)[0]] + coarse.positions[coarse.face(0)[1]]);
  PolygonMesh mesh = icosphere(1);
  for (glm::dvec3& p : mesh.positions) p -= 0.7 * glm::dot(p, axis) * axis;
  const BestFit best = fit_best(mesh, *backend);
  EXPECT_EQ(best.method, InterpolationMethod::Progressive);
  EXPECT_FALSE(best.fair_mesh.has_value());
  EXPECT_FALSE(best.fit.fair.has_value());
  EXPECT_LT(best.progressive->rms_normal_deviation,
            kClearlyBetter * best.fair->rms_normal_deviation);
  EXPECT_THAT(best.reason,
              HasSubstr("progressive: it does not fold, and its normals are clearly nearer"));
}

// A flat disc of needles around hubs beside its middle: at level 1 the progressive surface looks
// clearly better and whole, at level 2 it is folded.
TEST(FitBest, LooksBetweenThePlacesOfLevelOne) {
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
  const BestFit best = fit_best(mesh, *backend);
  EXPECT_LT(best.progressive->folded_area_elsewhere, kSoundFoldedArea);
  EXPECT_LT(best.progressive->rms_normal_deviation,
            kClearlyBetter * best.fair->rms_normal_deviation);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  EXPECT_THAT(best.reason, HasSubstr("of the area at level 2"));
}

TEST(FitBest, SparesTheFairFitWhereFacesAreFollowedClosely) {
  const auto backend = make_cpu_backend();
  int made = 0;
  const BestFit best = fit_best(icosphere(5), *backend, {}, [&] {
    ++made;
    return FairMesh{};
  });
  EXPECT_EQ(best.method, InterpolationMethod::Progressive);
  EXPECT_LT(best.progressive->rms_normal_deviation, kCloseDegrees);
  EXPECT_FALSE(best.fair.has_value());
  EXPECT_EQ(made, 0);
}

TEST(FitBest, TakesFairWhereProgressiveDoesNotConverge) {
  const auto backend = make_cpu_backend();
  FitOptions options;
  options.max_iterations = 0;
  const BestFit best = fit_best(icosphere(5), *backend, options);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_THAT(best.reason, HasSubstr("progressive did not converge"));
}

TEST(FitBest, TakesProgressiveWhereADevicesFairNetMissesTheTolerance) {
  MissingBackend backend;
  const PolygonMesh mesh = torus(24, 12, 1, 0.4);
  const BestFit best = fit_best(mesh, backend);
  EXPECT_EQ(best.reason, "progressive: fair misses the tolerance");
  EXPECT_EQ(best.method, InterpolationMethod::Progressive);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_FALSE(best.fit.fair.has_value());
  EXPECT_FALSE(best.fair_mesh.has_value());
}

// The figures that decide are those of the surfaces themselves, and the mesh is the caller's.
TEST(FitBest, ItsFiguresAreThoseOfBothSurfaces) {
  const auto backend = make_cpu_backend();
  const PolygonMesh mesh = icosphere(2);
  int made = 0;
  const BestFit best = fit_best(mesh, *backend, {}, [&] {
    ++made;
    return FairMesh{mesh, nullptr};
  });
  EXPECT_EQ(made, 1);
  const auto quality_of = [&](InterpolationMethod method) {
    FitOptions options;
    options.method = method;
    return surface_quality(evaluate(mesh, fit(mesh, *backend, options), *backend, {.level = 1}),
                           mesh);
  };
  EXPECT_NEAR(best.progressive->rms_normal_deviation,
              quality_of(InterpolationMethod::Progressive).rms_normal_deviation, 1e-6);
  EXPECT_NEAR(best.fair->rms_normal_deviation,
              quality_of(InterpolationMethod::Fair).rms_normal_deviation, 1e-6);
  EXPECT_EQ(best.mesh(mesh).face_vertices, mesh.face_vertices);
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
  EXPECT_THAT(fitted.reason->text, HasSubstr("12 edges kept sharp"));
  EXPECT_THAT(fitted.reason->text, HasSubstr("--creases use"));
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
    if (edges != 16) EXPECT_NEAR(fitted.chosen_quality()->rms_normal_deviation, 0, 1e-4);
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
TEST(FitBest, GivesOnlyTheWarningsOfTheFitThatIsTaken) {
  const auto backend = make_cpu_backend();
  PolygonMesh mesh = torus(8, 4, 1, 0.4);
  mesh.creases = {{mesh.face(0)[0], mesh.face(0)[1], 1}};  // semi-sharp: both fits warn
  FitOptions options;
  std::vector<std::string> codes;
  options.callbacks.warning = [&](const Warning& warning) { codes.push_back(warning.code); };
  const BestFit best = fit_best(mesh, *backend, options);
  ASSERT_TRUE(best.fair.has_value());
  EXPECT_EQ(codes, std::vector<std::string>{"semi-sharp-creases"});
}

// Two faces of 46,342 corners: limit masks without sums would have more entries than 2^31.
TEST(FitBest, TriesProgressiveWhateverTheFaces) {
  const auto backend = make_cpu_backend({Precision::Double});
  const PolygonMesh mesh = prism(46'342);
  const BestFit best = fit_best(mesh, *backend);
  EXPECT_TRUE(best.progressive);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  EXPECT_TRUE(best.fit.interpolation.converged);
  EXPECT_TRUE(fit(mesh, *backend, {}).interpolation.converged);
}

}  // namespace
}  // namespace planish::test
