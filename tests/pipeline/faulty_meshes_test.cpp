// Every function that takes a mesh refuses one that nobody has checked, with an Error.
#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "planish/mesh/mesh_parts.h"
#include "planish/planish.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "support/calls.h"
#include "support/files.h"
#include "support/mesh_catalogue.h"
#if PLANISH_HAS_VULKAN
#include "planish/vulkan/embed.h"
#endif

namespace planish {
namespace {

using Kind = MeshProblemKind;
using Action = std::function<void(const PolygonMesh&)>;

bool is_mended(Kind kind) {
  return kind == Kind::UnknownCreaseEdge || kind == Kind::UnknownCornerVertex ||
         kind == Kind::UnknownHole;
}

// Each fault is refused with its words; those that repair() mends are mended where it may.
void expect_refused(const std::string& what, const Action& action, ErrorCode code,
                    bool repairs = false) {
  EXPECT_NO_THROW(action(test::laden_cube())) << what;
  for (const test::FaultyMesh& faulty : test::faulty_meshes()) {
    SCOPED_TRACE(what + ": " + faulty.name);
    if (repairs && is_mended(faulty.kind)) {
      EXPECT_NO_THROW(action(faulty.mesh));
      continue;
    }
    EXPECT_NE(test::message_of(code, [&] { action(faulty.mesh); }), "no error");
  }
}

TEST(FaultyMeshes, AreFoundByCheck) {
  EXPECT_TRUE(check(test::laden_cube()).empty());
  for (const test::FaultyMesh& faulty : test::faulty_meshes()) {
    const std::vector<MeshProblem> problems = check(faulty.mesh);
    ASSERT_FALSE(problems.empty()) << faulty.name;
    EXPECT_EQ(problems.front().kind, faulty.kind) << faulty.name << problems.front().message;
  }
}

TEST(FaultyMeshes, AreRefusedByFits) {
  const auto backend = make_cpu_backend();
  const auto refused = [&](const std::string& what, const Action& action, bool repairs = false) {
    expect_refused(what, action, ErrorCode::UnusableMesh, repairs);
  };
  refused("fit", [&](const PolygonMesh& mesh) { (void)fit(mesh, *backend); });
  refused("fit, fair", [&](const PolygonMesh& mesh) {
    FitOptions options;
    options.method = InterpolationMethod::Fair;
    (void)fit(mesh, *backend, options);
  });
  refused(
      "fit_mesh", [&](const PolygonMesh& mesh) { (void)fit_mesh(mesh, "a", *backend, {}); }, true);
  refused("fit_mesh without repair", [&](const PolygonMesh& mesh) {
    (void)fit_mesh(mesh, "a", *backend, {.repairs = false});
  });
  refused("fit_mesh, welded", [&](const PolygonMesh& mesh) {
    MeshFitOptions options;
    options.weld = 0.0;
    options.repairs = false;
    (void)fit_mesh(mesh, "a", *backend, options);
  });
  refused(
      "repair", [](const PolygonMesh& mesh) { (void)repair(mesh); }, true);
  refused("verify_cage, the cage",
          [&](const PolygonMesh& mesh) { (void)verify_cage(mesh, test::laden_cube()); });
}

TEST(FaultyMeshes, AreRefusedByEvaluation) {
  const auto backend = make_cpu_backend();
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark}) {
    expect_refused(
        "evaluate",
        [&](const PolygonMesh& mesh) {
          (void)evaluate(mesh, *backend, {.level = 1, .scheme = scheme});
        },
        ErrorCode::UnusableMesh);
  }
  expect_refused(
      "limit_positions",
      [&](const PolygonMesh& mesh) { (void)limit_positions(mesh, LimitOptions{}); },
      ErrorCode::UnusableMesh);
  expect_refused(
      "SurfaceQueries",
      [&](const PolygonMesh& mesh) {
        const LimitSurface surface(
            std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{}));
        (void)SurfaceQueries(surface).closest({1, 2, 3});
      },
      ErrorCode::UnusableMesh);
}

// What has been prepared is not looked at again, but for what rides on it.
TEST(FaultyMeshes, AreRefusedBesideAFit) {
  const auto backend = make_cpu_backend();
  const PolygonMesh sound = test::laden_cube();
  FitOptions options;
  options.method = InterpolationMethod::Fair;  // which evaluates the mesh, not a cage of its own
  const Fit fitted = fit(sound, *backend, options);
  const SurfaceMesh surface = evaluate(sound, fitted, *backend, {.level = 1});
  for (const test::FaultyMesh& faulty : test::faulty_meshes()) {
    if (faulty.kind == Kind::IndexOutOfRange) continue;
    if (faulty.kind == Kind::UnknownCreaseEdge || faulty.kind == Kind::UnknownCornerVertex)
      continue;
    SCOPED_TRACE(faulty.name);
    EXPECT_THROW((void)evaluate(faulty.mesh, fitted, *backend, {.level = 1}), Error);
    if (faulty.kind != Kind::UnknownHole) continue;
    EXPECT_THROW((void)surface_quality(surface, faulty.mesh), Error);
    EXPECT_THROW((void)vertex_fields(surface, faulty.mesh, 1.0), Error);
    EXPECT_THROW((void)blocks_of(surface, faulty.mesh), Error);
  }
}

TEST(FaultyMeshes, AreRefusedByMeshTools) {
  const PolygonMesh cube = test::laden_cube();
  expect_refused(
      "merged_meshes",
      [&](const PolygonMesh& mesh) {
        (void)merged_meshes(std::array{cube, mesh});
      },
      ErrorCode::UnusableMesh);
  expect_refused(
      "find_features", [](const PolygonMesh& mesh) { (void)find_features(mesh); },
      ErrorCode::UnusableMesh);
  expect_refused(
      "with_convex_faces", [](const PolygonMesh& mesh) { (void)with_convex_faces(mesh); },
      ErrorCode::UnusableMesh);
  // They come back as they were.
  for (const test::FaultyMesh& faulty : test::faulty_meshes()) {
    const WeldedMesh welded = weld_vertices(PolygonMesh(faulty.mesh), 0);
    EXPECT_EQ(welded.mesh.face_vertices, faulty.mesh.face_vertices) << faulty.name;
    EXPECT_EQ(welded.mesh.colors.size(), faulty.mesh.colors.size()) << faulty.name;
    EXPECT_FALSE(check(welded.mesh).empty()) << faulty.name;
  }
}

TEST(FaultyMeshes, AreRefusedByWriters) {
  for (const FormatInfo& info : formats()) {
    if (!serves(info.format, FormatUse::WriteMesh)) continue;
    expect_refused(
        "write_mesh " + std::string(info.name),
        [&](const PolygonMesh& mesh) {
          const test::TemporaryFolder folder;
          write_mesh(folder.path() / "a", info.format, mesh);
        },
        ErrorCode::InvalidArgument);
  }
}

#if PLANISH_HAS_VULKAN
TEST(FaultyMeshes, AreRefusedByVulkanSystems) {
  expect_refused(
      "vulkan::System", [](const PolygonMesh& mesh) { const vulkan::System system(mesh); },
      ErrorCode::UnusableMesh);
}
#endif

}  // namespace
}  // namespace planish
