#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "planish/core/error.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/statistics.h"
#include "planish/solve/backend.h"
#include "support/calls.h"
#include "support/cut_quads.h"
#include "support/files.h"
#include "support/meshes.h"

namespace planish {
namespace {

// How dense a mesh is: level 1 is enough where its own faces show the surface.

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

namespace fs = std::filesystem;
using testing::HasSubstr;

class FitFilePlaces : public testing::Test {
 protected:
  FitFilePlaces() { write_mesh(input_, FileFormat::Obj, test::cube()); }

  [[nodiscard]] std::string refusal(const fs::path& output, const fs::path& cage) const {
    return test::message_of(ErrorCode::InvalidArgument, [&] {
      FitFileOptions options;
      options.cage = cage;
      (void)fit_file(input_, output, options);
    });
  }
  static std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  fs::path input_ = folder_ / "a.obj";
};

TEST_F(FitFilePlaces, TheInputIsNeverWritten) {
  const std::string before = bytes_of(input_);
  fs::create_symlink(input_, folder_ / "soft.obj");
  fs::create_hard_link(input_, folder_ / "hard.obj");
  for (const char* name : {"a.obj", "./a.obj", "soft.obj", "hard.obj"}) {
    EXPECT_THAT(refusal(folder_ / name, {}), HasSubstr("is the input itself")) << name;
    EXPECT_THAT(refusal(folder_ / "b.glb", folder_ / name), HasSubstr("is the input itself"))
        << name;
  }
  EXPECT_EQ(bytes_of(input_), before);
  EXPECT_FALSE(fs::exists(folder_ / "b.glb"));
}

// Nor is what it names, by whatever name.
TEST_F(FitFilePlaces, WhatTheInputNamesIsNeverWritten) {
  (void)fit_file(input_, folder_ / "s.gltf", {.settings = settings_of({{"levels", "1"}})});
  fs::rename(folder_ / "s.bin", folder_ / "b.bin");
  std::string text = bytes_of(folder_ / "s.gltf");
  text.replace(text.find("s.bin"), 5, "b.bin");
  std::ofstream(folder_ / "s.gltf") << text;
  fs::create_hard_link(folder_ / "b.bin", folder_ / "hard.bin");
  std::ofstream(folder_ / "y.mtl") << "newmtl wood\n# mine\nmap_Kd oak.png\n";
  std::ifstream given(input_);
  std::ofstream(folder_ / "x.obj") << "mtllib y.mtl\nusemtl wood\n" << given.rdbuf();
  const std::string buffer = bytes_of(folder_ / "b.bin"), library = bytes_of(folder_ / "y.mtl");
  const auto refused = [](const std::function<void()>& work) {
    EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument, work),
                HasSubstr("is read with the input"));
  };
  int told = 0;
  FitFileOptions options;
  options.callbacks.progress = [&](std::string_view, double) { ++told; };
  for (const char* name : {"b.gltf", "hard.gltf"})
    refused([&] { (void)fit_file(folder_ / "s.gltf", folder_ / name, options); });
  refused([&] { (void)fit_file(folder_ / "x.obj", folder_ / "y.obj", options); });
  options.cage = folder_ / "y.obj";
  refused([&] { (void)fit_file(folder_ / "x.obj", folder_ / "z.glb", options); });
  EXPECT_EQ(told, 0) << "before the work";
  // Nor where only the writer knows what was read.
  const FileMaterials materials = read_materials(
      {.bytes = {}, .name = "x.obj", .path = folder_ / "x.obj"}, FileFormat::Obj, true, true);
  refused([&] {
    write_mesh(folder_ / "y.obj", FileFormat::Obj, read_mesh(folder_ / "x.obj").mesh,
               {.header = {},
                .subdivision = {},
                .is_z_up = false,
                .materials = {&materials.library, folder_}});
  });
  fs::create_hard_link(folder_ / "y.mtl", folder_ / "w.glb");
  const FittedMesh fitted = fit_mesh(test::cube(), "cube", *make_cpu_backend());
  InputFiles inputs;
  inputs.add(folder_ / "s.gltf");
  refused([&] {
    (void)write_fitted_surface(folder_ / "b.gltf", fitted, *make_cpu_backend(),
                               {.inputs = &inputs});
  });
  inputs.add(folder_ / "x.obj");
  refused([&] {
    write_mesh(folder_ / "y.obj", FileFormat::Obj, read_mesh(folder_ / "x.obj").mesh,
               {.inputs = &inputs});
  });
  EXPECT_EQ(bytes_of(folder_ / "b.bin"), buffer);
  EXPECT_EQ(bytes_of(folder_ / "y.mtl"), library);
}

TEST_F(FitFilePlaces, FormatsThatAreNotWrittenAreRefusedBeforeTheWork) {
  int told = 0;
  FitFileOptions options;
  options.callbacks.progress = [&](std::string_view, double) { ++told; };
  const auto message = [&](const char* name) {
    return test::message_of(ErrorCode::InvalidArgument,
                            [&] { (void)fit_file(input_, folder_ / name, options); });
  };
  EXPECT_THAT(
      message("o.foo"),
      HasSubstr("o.foo: a surface is written as .glb, .gltf, .obj, .ply, .off, .stl, .usda"));
  EXPECT_EQ(test::message_of(ErrorCode::InvalidArgument, [&] { (void)fit_file(input_, "-"); }),
            "output: a file is wanted; one of that name is \"./-\"");
  EXPECT_EQ(told, 0);
}

TEST_F(FitFilePlaces, TexturesOfOtherFoldersComeWhereTheyAreWanted) {
  fs::create_directory(folder_ / "model");
  std::ofstream(folder_ / "oak.png") << test::AssetSample::image();
  std::ofstream(folder_ / "model/box.mtl") << "newmtl wood\nmap_Kd ../oak.png\n";
  std::ifstream given(input_);
  std::ofstream(folder_ / "model/box.obj") << "mtllib box.mtl\nusemtl wood\n" << given.rdbuf();
  std::vector<std::string> codes;
  FitFileOptions options;
  options.callbacks.warning = [&](const Warning& warning) {
    codes.push_back(warning.code);
    EXPECT_THAT(warning.message, HasSubstr("--textures anywhere"));
  };
  (void)fit_file(folder_ / "model/box.obj", folder_ / "b.glb", options);
  EXPECT_EQ(codes, std::vector<std::string>{"left-out-textures"});
  EXPECT_THAT(bytes_of(folder_ / "b.glb"), testing::Not(HasSubstr("image/png")));
  options.settings.textures = FileReach::Anywhere;
  (void)fit_file(folder_ / "model/box.obj", folder_ / "b.glb", options);
  EXPECT_EQ(codes.size(), 1u);
  EXPECT_THAT(bytes_of(folder_ / "b.glb"), HasSubstr("image/png"));
}

// Who reads files by the library is told what the command tells.
TEST_F(FitFilePlaces, WhatIsOddAboutTheMeshIsTold) {
  const PolygonMesh cube = test::cube();
  PolygonMesh turned;
  turned.positions = cube.positions;
  for (std::int32_t f = 0; f < cube.face_count(); ++f) {
    std::vector<std::int32_t> face(cube.face(f).begin(), cube.face(f).end());
    std::ranges::reverse(face);
    turned.add_face(face);
  }
  turned.positions.insert(turned.positions.begin(), glm::dvec3(5, 5, 5));
  for (std::int32_t& vertex : turned.face_vertices) ++vertex;
  write_mesh(input_, FileFormat::Obj, turned);
  const auto warnings_of = [&](const FitFileOptions& options) {
    std::vector<std::pair<std::string, std::int64_t>> found;
    FitFileOptions own = options;
    std::size_t told = 0;
    own.callbacks.warning = [&](const Warning&) { ++told; };
    const FileFit done = fit_file(input_, folder_ / "b.ply", own);
    for (const Warning& warning : done.fitted.warnings)
      found.emplace_back(warning.code, warning.first);
    EXPECT_EQ(told, found.size());
    return found;
  };
  using Found = std::vector<std::pair<std::string, std::int64_t>>;
  EXPECT_EQ(warnings_of({}), (Found{{"unused-vertices", 0}, {"inside-out", 0}}));
  // Each face has corners of its own, and a vertex that none has comes first.
  PolygonMesh torn;
  torn.positions.emplace_back(5, 5, 5);
  for (std::int32_t f = 0; f < cube.face_count(); ++f) {
    std::vector<std::int32_t> face;
    for (const std::int32_t v : cube.face(f)) {
      face.push_back(torn.vertex_count());
      torn.positions.push_back(cube.positions[v]);
    }
    torn.add_face(face);
  }
  write_mesh(input_, FileFormat::Obj, torn);
  const Found found = warnings_of({});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].first, "torn-vertices");
  EXPECT_GT(found[0].second, 0);
  EXPECT_EQ(found[1].first, "unused-vertices");
  FitFileOptions welded;
  welded.settings.weld = 0;
  EXPECT_EQ(warnings_of(welded), (Found{{"unused-vertices", 0}}));
}

// By as much as its numbers are off, in every format of single precision, and in no other.
TEST_F(FitFilePlaces, NumbersThatLoseWhatTheFitKeepsAreTold) {
  const glm::dvec3 far(1e5, -2e5, 3e5);
  PolygonMesh mesh = test::torus(12, 8, 2, 1);
  for (glm::dvec3& p : mesh.positions) p += far;
  write_mesh(input_, FileFormat::Obj, mesh);
  for (const char* name : {"b.stl", "b.ply", "b.glb", "b.obj", "b.off", "b.usda"}) {
    FitFileOptions options;
    options.settings.set_levels({1});
    const FileFit done = fit_file(input_, folder_ / name, options);
    const auto found = std::ranges::find(done.fitted.warnings, "rounded-output", &Warning::code);
    const bool is_usd = std::string(name) == "b.usda";  // which is not read
    const bool is_single = is_usd || std::string(name) == "b.stl";
    EXPECT_EQ(found != done.fitted.warnings.end(), is_single) << name;
    if (!is_single || is_usd || found == done.fitted.warnings.end()) continue;
    // The file's own vertices: the nearest one to each that was given.
    const MeshFile written = read_mesh(folder_ / name);
    double largest = 0;
    for (const glm::dvec3& p : mesh.positions) {
      double nearest = 1e300;
      for (const glm::dvec3& q : written.mesh.positions)
        nearest = std::min(nearest, glm::distance(p, q));
      largest = std::max(largest, nearest);
    }
    const double diagonal = done.fitted.fit.placement.diagonal;
    EXPECT_GT(largest, 1e-6 * diagonal);
    EXPECT_THAT(found->message,
                HasSubstr("leaves an error of " + short_number(largest / diagonal)));
  }
}

TEST_F(FitFilePlaces, AnAssetThatBecomesOneMeshForItsCageIsTold) {
  (void)fit_file(input_, folder_ / "s.glb", {.settings = settings_of({{"levels", "1"}})});
  FitFileOptions options;
  options.cage = folder_ / "c.obj";
  const FileFit done = fit_file(folder_ / "s.glb", folder_ / "b.glb", options);
  ASSERT_FALSE(done.fitted.warnings.empty());
  EXPECT_EQ(done.fitted.warnings[0].code, "merged-asset");
  EXPECT_THAT(done.fitted.warnings[0].message, HasSubstr("c.obj holds one mesh"));
}

TEST_F(FitFilePlaces, SurfaceAndCageAreTwoFiles) {
  EXPECT_THAT(refusal(folder_ / "b.ply", folder_ / "b.ply"), HasSubstr("is written twice"));
  EXPECT_THAT(refusal(folder_ / "b.ply", folder_ / "." / "b.ply"), HasSubstr("is written twice"));
  EXPECT_FALSE(fs::exists(folder_ / "b.ply"));
  FitFileOptions options;
  options.cage = folder_ / "d.obj";
  (void)fit_file(input_, folder_ / "b.ply", options);
  EXPECT_EQ(read_mesh(folder_ / "d.obj").mesh.face_count(), 6);
}

// Other formats hold a surface without faces.
TEST_F(FitFilePlaces, HolesAloneMakeNoGltfAndNoStep) {
  PolygonMesh holes = test::cube();
  holes.hole_faces = {0, 1, 2, 3, 4, 5};
  write_mesh(input_, FileFormat::Obj, holes);
  for (const char* name : {"b.glb", "b.gltf", "b.step"}) {
    EXPECT_THAT(refusal(folder_ / name, {}), HasSubstr("the surface has no face")) << name;
    EXPECT_FALSE(fs::exists(folder_ / name)) << name;
  }
  (void)fit_file(input_, folder_ / "b.ply");
  EXPECT_TRUE(fs::exists(folder_ / "b.ply"));
}

TEST_F(FitFilePlaces, SaysWhatWasMadeWhateverTheFormat) {
  for (const char* name : {"b.step", "b.glb"}) {
    const FileFit done = fit_file(input_, folder_ / name);
    EXPECT_EQ(done.byte_count, fs::file_size(folder_ / name));
    EXPECT_GT(done.face_count, 0);
    EXPECT_GT(done.vertex_count, 0);
    EXPECT_EQ(done.step.has_value(), name == std::string("b.step"));
    EXPECT_EQ(done.fitted.mesh.face_count(), 6);
  }
}

// glTF is UTF-8: what is none stands as U+FFFD, and the material is found all the same.
TEST_F(FitFilePlaces, MaterialsOfAnyNameAreFound) {
  std::ofstream(folder_ / "box.mtl") << "newmtl caf\xE9\nKd 0.25 0.5 1\n";
  std::ifstream given(input_);
  std::ofstream(folder_ / "box.obj") << "mtllib box.mtl\nusemtl caf\xE9\n" << given.rdbuf();
  (void)fit_file(folder_ / "box.obj", folder_ / "b.gltf");
  std::ifstream made(folder_ / "b.gltf");
  const std::string text{std::istreambuf_iterator<char>(made), {}};
  EXPECT_THAT(text, HasSubstr("caf\xEF\xBF\xBD"));
  EXPECT_THAT(text, HasSubstr("baseColorFactor"));
}

// A cage has the materials of its mesh, with textures as seen from where it stands.
TEST_F(FitFilePlaces, ACageHasItsMaterials) {
  fs::create_directory(folder_ / "cages");
  std::ofstream(folder_ / "box.mtl") << "newmtl wood\nmap_Kd oak.png\n";
  std::ifstream given(input_);
  std::ofstream(folder_ / "box.obj") << "mtllib box.mtl\nusemtl wood\n" << given.rdbuf();
  FitFileOptions options;
  options.cage = folder_ / "cages" / "c.obj";
  (void)fit_file(folder_ / "box.obj", folder_ / "b.ply", options);
  std::ifstream made(folder_ / "cages" / "c.mtl");
  const std::string text{std::istreambuf_iterator<char>(made), {}};
  EXPECT_EQ(text, "newmtl wood\nmap_Kd ../oak.png\n");
}

// Properties of vertices: at given vertices as they are, linear between, also where repair copies
// vertices (two cubes that share one) and drops some that no face names.
TEST_F(FitFilePlaces, PropertiesOfVerticesComeOut) {
  const PolygonMesh cube = test::cube();
  std::ostringstream text;
  const int count = 2 * cube.vertex_count();  // one that no face names, and one that two cubes have
  text << "ply\nformat ascii 1.0\nelement vertex " << count
       << "\nproperty float quality\nproperty double x\nproperty double y\nproperty double z\n"
          "property int error\nelement face 12\nproperty list uchar int vertex_indices\n"
          "end_header\n9 50 0 0 0\n";
  std::vector<glm::dvec3> points(cube.positions);
  for (std::size_t v = 1; v < cube.positions.size(); ++v)
    points.push_back(2.0 * cube.positions[0] - cube.positions[v]);
  const auto value = [](const glm::dvec3& p) { return 3 * p.x - p.y + 10 * p.z + 7; };
  for (const glm::dvec3& p : points)
    text << value(p) << " " << p.x << " " << p.y << " " << p.z << " 5\n";
  for (int side = 0; side < 2; ++side) {
    for (std::int32_t f = 0; f < cube.face_count(); ++f) {
      text << cube.face_size(f);
      std::vector<std::int32_t> face(cube.face(f).begin(), cube.face(f).end());
      if (side == 1) std::ranges::reverse(face);
      for (const std::int32_t v : face)
        text << " " << 1 + (side == 0 || v == 0 ? v : cube.vertex_count() - 1 + v);
      text << "\n";
    }
  }
  input_ = folder_ / "a.ply";
  std::ofstream(input_, std::ios::binary) << text.str();
  FitFileOptions options;
  options.settings.set_levels({0});
  const FileFit fit = fit_file(input_, folder_ / "b.ply", options);
  ASSERT_FALSE(fit.fitted.source_vertices.empty());
  const MeshFile level_0 = read_mesh(folder_ / "b.ply");
  ASSERT_EQ(level_0.mesh.attributes.size(), 2u);
  EXPECT_EQ(level_0.mesh.attributes[0].name, "quality");
  EXPECT_EQ(level_0.mesh.attributes[1].name, "error");
  EXPECT_GE(level_0.mesh.positions.size(), 16u);
  for (std::size_t v = 0; v < level_0.mesh.positions.size(); ++v)
    EXPECT_NEAR(level_0.mesh.attributes[0].values[v], value(level_0.mesh.positions[v]), 1e-5) << v;
  options.settings.set_levels({1});
  (void)fit_file(input_, folder_ / "c.ply", options);
  const MeshFile level_1 = read_mesh(folder_ / "c.ply");
  // A vertex in the middle of a face has the mean of its corners, whose sum is linear in them.
  const auto& values = level_1.mesh.attributes[0].values;
  const auto [least, most] = std::ranges::minmax(values);
  EXPECT_EQ(std::ranges::count(values, 50), 0);
  EXPECT_GE(least, std::ranges::min(level_0.mesh.attributes[0].values));
  EXPECT_LE(most, std::ranges::max(level_0.mesh.attributes[0].values));
  const auto face = level_1.mesh.face(0);
  const float middle = values[face[2]], first = values[face[0]];
  EXPECT_NEAR(values[face[1]] + values[face[3]], first + middle, 1e-4);
  EXPECT_THAT(level_1.mesh.attributes[1].values, testing::Each(5));
  (void)fit_file(input_, folder_ / "c.glb", options);
  EXPECT_THAT(bytes_of(folder_ / "c.glb"), HasSubstr("\"_QUALITY\""));
  (void)fit_file(input_, folder_ / "c.usda", options);
  EXPECT_THAT(bytes_of(folder_ / "c.usda"), HasSubstr("float[] primvars:quality = ["));
  // Whatever the scheme: a given vertex keeps what it has.
  options.settings.scheme = Scheme::CatmullClark;
  options.settings.interpolation = InterpolationChoice::Progressive;
  (void)fit_file(input_, folder_ / "d.ply", options);
  const MeshFile other = read_mesh(folder_ / "d.ply");
  ASSERT_EQ(other.mesh.attributes.size(), 2u);
  for (std::size_t v = 0; v < 16; ++v)
    EXPECT_NEAR(other.mesh.attributes[0].values[v], value(other.mesh.positions[v]), 1e-4) << v;
  // What the format has no place for is told.
  std::vector<std::string> codes;
  options.callbacks.warning = [&](const Warning& w) { codes.push_back(w.code); };
  (void)fit_file(input_, folder_ / "d.stl", options);
  EXPECT_THAT(codes, testing::Contains("lost-attributes"));
}

// What the surface has and its format has not is told once.
TEST_F(FitFilePlaces, WhatAFormatCannotHoldIsTold) {
  PolygonMesh mesh = test::cube();
  mesh.colors.assign(8, glm::vec4(1));
  mesh.groups = {{"a", ""}, {"b", ""}};
  mesh.face_groups = {0, 0, 0, 1, 1, 1};
  mesh.uvs = {{0, 0}};
  mesh.face_uvs.assign(24, 0);
  write_mesh(input_, FileFormat::Obj, mesh);
  const auto warnings_of = [&](const char* output) {
    std::vector<std::string> warnings;
    FitFileOptions options;
    options.settings.set_levels({1});
    options.callbacks.warning = [&](const Warning& warning) {
      EXPECT_EQ(warning.code, "lost-attributes");
      warnings.push_back(warning.message);
    };
    (void)fit_file(input_, folder_ / output, options);
    return warnings;
  };
  using testing::ElementsAre;
  for (const char* output : {"a.glb", "b.obj", "a.usda"})
    EXPECT_THAT(warnings_of(output), testing::IsEmpty()) << output;
  EXPECT_THAT(warnings_of("a.stl"),
              ElementsAre(HasSubstr("a.obj: .stl holds no texture coordinates, colours or groups, "
                                    "which the input has; .glb, .gltf, .obj, .usda and .json do")));
  EXPECT_THAT(warnings_of("a.ply"),
              ElementsAre(HasSubstr("a.obj: .ply holds no groups, which the input "
                                    "has; .glb, .gltf, .obj, .usda and "
                                    ".json do")));
}

}  // namespace
}  // namespace planish
