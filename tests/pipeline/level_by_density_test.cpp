// How dense a mesh is: level 1 is enough where its own faces show the surface.
#include "planish/mesh/mesh_density.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <optional>
#include <span>

#include "planish/files/mesh_file.h"
#include "planish/mesh/merged_meshes.h"
#include "planish/pipeline/fit_file.h"
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
    options.mesh.method = InterpolationMethod::Progressive;
    options.level = level;
    return fit_file(in, out, options).face_count;
  };
  EXPECT_EQ(fit(test::torus(200, 100, 1, 0.4), {}), 4 * 20'000);
  EXPECT_EQ(fit(test::torus(200, 100, 1, 0.4), 2), 16 * 20'000);
  EXPECT_EQ(fit(test::torus(20, 10, 1, 0.4), {}), 16 * 200);
}

}  // namespace
}  // namespace planish
