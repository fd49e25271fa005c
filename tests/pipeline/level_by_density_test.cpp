// How dense a mesh is: level 1 is enough where its own faces show the surface.
#include "planish/mesh/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/mesh/mesh_parts.h"
#include "support/cut_quads.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

MeshDensity density_of(const PolygonMesh& mesh) { return mesh_density(mesh, MeshTopology(mesh)); }

TEST(MeshDensity, OfManyFacesThatTurnByLittle) {
  const MeshDensity density = density_of(test::torus(200, 100, 1, 0.4));
  EXPECT_EQ(density.vertex_count, 20'000);
  EXPECT_EQ(density.even_share, 1);
  EXPECT_TRUE(density.is_dense());
  EXPECT_EQ(density.level(), 1);
}

TEST(MeshDensity, SmallMeshesAreNot) {
  EXPECT_EQ(density_of(test::torus(199, 100, 1, 0.4)).level(), 2);
  EXPECT_EQ(density_of(test::flat_grid(3, 3)).level(), 2);
}

// Long strips, of which 16 go around: each turns by 22.5 degrees to the next.
TEST(MeshDensity, ManyFacesThatTurnAreNot) {
  const MeshDensity density = density_of(test::torus(1250, 16, 1, 0.4));
  EXPECT_EQ(density.even_share, 0);
  EXPECT_EQ(density.level(), 2);
}

// A small ball of few faces is little of the area.
TEST(MeshDensity, CoarsePartsCountByTheirArea) {
  std::array<PolygonMesh, 2> parts{test::torus(200, 100, 1, 0.4), test::icosphere(1)};
  for (glm::dvec3& p : parts[1].positions) p *= 0.3;
  const MeshDensity density = density_of(merged_meshes(parts).mesh);
  EXPECT_LT(density.even_share, 1);
  EXPECT_EQ(density.level(), 1);
}

// Whoever joins halves of quads gets the same level.
TEST(MeshDensity, IsTheSameOfHalvesOfQuads) {
  const PolygonMesh quads = test::torus(400, 60, 1, 0.4);
  EXPECT_EQ(density_of(quads).level(), 1);
  EXPECT_EQ(density_of(test::cut_quads(quads)).level(), 1);
}

TEST(MeshDensity, FacesWithoutAreaAreNoTurn) {
  PolygonMesh mesh = test::torus(200, 100, 1, 0.4);
  const std::span<const std::int32_t> face = mesh.face(0);
  for (const std::int32_t v : {face[1], face[2], face[3]})
    mesh.positions[v] = mesh.positions[face[0]];
  EXPECT_GT(density_of(mesh).even_share, 0.99);
}

// Where nobody names a level, the mesh does: the file is that of the level it settles.
TEST(LevelByDensity, FilesHaveTheLevelOfTheirMesh) {
  const test::TemporaryFolder folder;
  const auto fit = [&](const PolygonMesh& mesh, std::optional<int> level) {
    const std::filesystem::path in = folder.path() / "in.ply", out = folder.path() / "out.ply";
    write_mesh(in, FileFormat::Ply, mesh);
    FitFileOptions options;
    options.settings.interpolation = InterpolationChoice::Progressive;
    if (level) options.settings.set_levels({*level});
    return fit_file(in, out, options).face_count;
  };
  EXPECT_EQ(fit(test::torus(200, 100, 1, 0.4), {}), 4 * 20'000);
  EXPECT_EQ(fit(test::torus(200, 100, 1, 0.4), 2), 16 * 20'000);
  EXPECT_EQ(fit(test::torus(20, 10, 1, 0.4), {}), 16 * 200);
}

std::vector<Warning> warnings_of_file(const PolygonMesh& mesh, const char* output,
                                      FitFileOptions options) {
  const test::TemporaryFolder folder;
  const std::filesystem::path in = folder.path() / "in.ply";
  write_mesh(in, FileFormat::Ply, mesh);
  std::vector<Warning> told;
  options.settings.interpolation = InterpolationChoice::Progressive;
  options.settings.creases.chooses = false;
  options.callbacks.warning = [&](const Warning& warning) { told.push_back(warning); };
  const FileFit done = fit_file(in, folder.path() / output, options);
  EXPECT_EQ(done.fitted.warnings.size(), told.size());
  return told;
}

// As the command: a large file of a level that nobody named.
TEST(FileWarnings, ALargeFileThatNobodyAskedForIsNamed) {
  const PolygonMesh strips = test::torus(1500, 16, 1, 0.4);
  const std::vector<Warning> told = warnings_of_file(strips, "out.obj", {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "large-output");
  EXPECT_THAT(told[0].message,
              testing::ContainsRegex("out.obj: is [0-9.]+ MiB, [0-9]+ times the input; --levels 1 "
                                     "writes about a quarter of that"));
  EXPECT_TRUE(
      warnings_of_file(strips, "out.obj", {.settings = settings_of({{"levels", "2"}})}).empty());
}

TEST(FileWarnings, AFitThatMissesItsToleranceIsNamed) {
  FitFileOptions options;
  options.settings.max_iterations = 1;
  const std::vector<Warning> told =
      warnings_of_file(test::torus(20, 10, 1, 0.4), "out.glb", options);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "not-converged");
  EXPECT_THAT(told[0].message,
              testing::AllOf(testing::HasSubstr("in.ply: not converged (iteration-limit)"),
                             testing::HasSubstr(" after 1 iteration, the tolerance 1e-06;"),
                             testing::HasSubstr("raise --max-iterations or --tolerance")));
}

// A vertex beyond its neighbour: faces beside it lie upside down.
TEST(FileWarnings, AFoldedSurfaceIsNamedWithItsPlace) {
  PolygonMesh mesh = test::flat_grid(8, 8);
  mesh.positions[40].x += 1.7;
  const std::vector<Warning> told = warnings_of_file(mesh, "out.glb", {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "folded-area");
  EXPECT_THAT(told[0].message,
              testing::AllOf(testing::HasSubstr("of the surface is folded (turned by more than 90 "
                                                "degrees from its face)"),
                             testing::HasSubstr("; first at face "),
                             testing::HasSubstr("--interpolation fair is made for such meshes")));
  EXPECT_GE(told[0].first, 0);
}

}  // namespace
}  // namespace planish
