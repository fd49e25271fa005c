// What happens to a mesh that anybody made: warnings, numbers of the file, where it lies.
#include "planish/pipeline/fit_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/verify_cage.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Every face with corners of its own: nothing is joined before it is welded.
PolygonMesh with_faces_apart(const PolygonMesh& mesh) {
  PolygonMesh apart = mesh;
  apart.positions.clear();
  for (std::int32_t& v : apart.face_vertices) {
    apart.positions.push_back(mesh.positions[v]);
    v = static_cast<std::int32_t>(apart.positions.size()) - 1;
  }
  return apart;
}

PolygonMesh together(const PolygonMesh& a, const PolygonMesh& b) {
  PolygonMesh mesh = a;
  for (std::int32_t face = 0; face < b.face_count(); ++face) {
    for (const std::int32_t v : b.face(face)) mesh.face_vertices.push_back(v + a.vertex_count());
    mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
  }
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  return mesh;
}

// Both methods have meshes of their own, each mended.
TEST(FitMesh, TellsAWarningOfBothMeshesOnce) {
  PolygonMesh mesh = test::jittered(test::icosphere(2), 0.3, 1);
  std::swap(mesh.face_vertices[1], mesh.face_vertices[2]);
  std::vector<Warning> heard;
  MeshFitOptions options;
  options.crease_degrees = 60;
  options.fit.callbacks.warning = [&](const Warning& warning) { heard.push_back(warning); };
  const FittedMesh fitted = fit_mesh(mesh, "ball", *make_cpu_backend(), options);
  ASSERT_EQ(fitted.options.method, InterpolationMethod::Fair);
  const auto mended = std::ranges::count_if(
      heard, [](const Warning& warning) { return warning.message.starts_with("ball: "); });
  EXPECT_EQ(mended, 1) << heard.front().message;
  ASSERT_EQ(fitted.warnings.size(), heard.size());
  for (std::size_t i = 0; i < heard.size(); ++i)
    EXPECT_EQ(fitted.warnings[i].message, heard[i].message);
}

TEST(MakeReady, NamesVerticesOfTheFileWhereItWelds) {
  PolygonMesh second = test::cube();
  for (glm::dvec3& p : second.positions) p += glm::dvec3(2);
  PolygonMesh first = test::cube();
  for (glm::dvec3& p : first.positions) p -= glm::dvec3(9);
  const PolygonMesh mesh = with_faces_apart(together(together(first, test::cube()), second));
  ReadyMesh ready = make_ready(PolygonMesh(mesh), {.weld = 1e-6});
  ASSERT_TRUE(ready.prepared);
  EXPECT_EQ(ready.mesh.vertex_count(), 24);
  ASSERT_EQ(ready.changes.size(), 1u);
  EXPECT_THAT(ready.changes[0].code, ::testing::StartsWith("non-manifold"));
  ASSERT_GE(ready.changes[0].first, 0);
  EXPECT_EQ(mesh.positions[ready.changes[0].first], glm::dvec3(1)) << "where the cubes touch";
  for (std::int32_t v = 0; v < 24; ++v)
    EXPECT_EQ(mesh.positions[ready.source_vertices[v]], ready.mesh.positions[v]);
}

TEST(FitExtras, SayTheLargestErrorAndWhetherItConverged) {
  Interpolation result;
  result.error = {3e-4, 1e-4};
  result.iterations = 17;
  for (const bool converged : {false, true}) {
    result.converged = converged;
    FileExtras extras = fit_extras({.tolerance = 2e-3}, "use", result);
    const auto value = [&](std::string_view key) {
      return std::ranges::find(extras, key, [](const auto& entry) { return entry.first; })->second;
    };
    EXPECT_EQ(std::get<double>(value("max_error")), 3e-4);
    EXPECT_EQ(std::get<double>(value("tolerance")), 2e-3);
    EXPECT_EQ(std::get<std::int64_t>(value("iterations")), 17);
    EXPECT_EQ(std::get<bool>(value("converged")), converged);
    EXPECT_EQ(std::get<std::string>(value("creases")), "use");
  }
}

// Surfaces and the cage take what the fit found, but for another pose or where it was not kept.
TEST(Fit, FindsOnceWhatIsSharp) {
  const auto backend = make_cpu_backend();
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    options.sharp.boundary = BoundaryRule::EdgeAndCorner;
    PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(5), 0.2, 5);
    mesh.positions.push_back({7, 8, 9});  // of no face
    const Fit found = fit(mesh, *backend, options);
    const auto surface = fitted_surface(mesh, found, {.sharp = options.sharp});
    EXPECT_EQ(&surface->patches().features(), found.features.get());
    const UsedPart used = used_part(mesh, found.prepared);
    const SharpFeatures again = find_sharp_features(used.mesh, *used.prepared->topology,
                                                    used.mesh.positions, options.sharp);
    EXPECT_EQ(found.features->vertex_kinds, again.vertex_kinds);
    EXPECT_EQ(found.features->corner_sectors, again.corner_sectors);
    std::vector<glm::dvec3> pose = mesh.positions;
    for (glm::dvec3& p : pose) p.x *= -30;
    EXPECT_NE(&fitted_surface(mesh, found, {.sharp = options.sharp, .rest_positions = pose})
                   ->patches()
                   .features(),
              found.features.get());
    Fit restored = found;  // as from an archive
    restored.features = nullptr;
    const PolygonMesh cage = control_cage(mesh, found, options.sharp);
    EXPECT_EQ(cage.face_vertices, control_cage(mesh, restored, options.sharp).face_vertices);
    EXPECT_EQ(fitted_surface(mesh, restored, {.sharp = options.sharp})
                  ->patches()
                  .features()
                  .corner_sectors,
              again.corner_sectors);
  }
}

// check() refuses such a cage of the progressive method; one of the fair method has more vertices
// than the mesh and comes as it is.
TEST(VerifyCage, ConfirmsNothingThatIsNoNumber) {
  const PolygonMesh given = test::cube();
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  const PolygonMesh cage =
      control_cage(given, fit(given, *make_cpu_backend(), options), options.sharp);
  const auto verified = [&](const PolygonMesh& other) {
    return verify_cage(other, given, {.method = InterpolationMethod::Fair});
  };
  EXPECT_TRUE(verified(cage).confirmed);
  for (std::int32_t v = 0; v < cage.vertex_count(); ++v) {
    PolygonMesh wrong = cage;
    wrong.positions[v].y = std::numeric_limits<double>::quiet_NaN();
    const Verification found = verified(wrong);
    EXPECT_FALSE(found.confirmed) << v;
    EXPECT_EQ(found.error.max, std::numeric_limits<double>::infinity()) << v;
  }
}

TEST(StorageOrigin, IsTheCentreFromTenDiagonalsOn) {
  const glm::dvec3 way(0.6, 0, -0.8);
  for (const double diagonal : {1e-3, 1.0, 1e5})
    for (const double away : {0.0, 1.0, 9.99, 10.01, 50.0, 1e4}) {
      Placement placement;
      placement.diagonal = diagonal;
      placement.centre = away * diagonal * way;
      EXPECT_EQ(storage_origin(placement), away > 10 ? placement.centre : glm::dvec3(0))
          << diagonal << ", " << away;
    }
}

}  // namespace
}  // namespace planish
