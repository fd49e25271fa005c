// What fit_file() gives besides files.
#include "planish/job/fit_file.h"

#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/verify_cage.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

using FitFile = FolderTest;

// A roof over two faces whose corners have the normals of their face, or of the vertex.
std::string roof_obj(bool is_split) {
  const std::string a = "1", b = is_split ? "2" : "1";
  return "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 3 0\nv 1 3 1\nv 2 3 0\nvn -1 0 1\nvn 1 0 1\nf 1//" + a +
         " 2//" + a + " 5//" + a + " 4//" + a + "\nf 2//" + b + " 3//" + b + " 6//" + b + " 5//" +
         b + "\n";
}

// Of meshes and of points; a name that is none, and a value, are refused by what they are called.
TEST(SettingsOf, NamesOfBothTablesAreTaken) {
  const Settings settings = settings_of({{"target_vertices", "100"}, {"polish", "3"}});
  EXPECT_EQ(settings.polish_steps, 3);
  EXPECT_EQ(settings.points.target_vertices, 100);
  const auto refusal = [](const char* name) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)settings_of({{name, "many"}}); });
  };
  EXPECT_EQ(refusal("polishing"), "polishing: there is no such option");
  EXPECT_THAT(refusal("polish"), HasSubstr("--polish: \"many\" is no whole number"));
  EXPECT_THAT(refusal("target_vertices"), HasSubstr("--target-vertices: \"many\""));
}

TEST_F(FitFile, SplitNormalsAreCreasesWhereAsked) {
  const std::string roof = write("roof.obj", roof_obj(true));
  FitFileOptions options;
  options.settings = settings_of({{"creases", "normals"}});
  const FileFit sharp = fit_file(roof, path("sharp.glb"), options);
  EXPECT_EQ(sharp.fitted.fit.sharp_edge_count, 7);  // the ridge beside the border
  EXPECT_EQ(sharp.fitted.creases(), "normals");
  EXPECT_TRUE(sharp.fitted.warnings.empty());
  FitFileOptions rounded;
  rounded.settings.creases.chooses = false;
  EXPECT_EQ(fit_file(roof, path("smooth.glb"), rounded).fitted.fit.sharp_edge_count, 6);
  const FileFit none = fit_file(write("smooth.obj", roof_obj(false)), path("none.glb"), options);
  ASSERT_EQ(none.fitted.warnings.size(), 1u);
  EXPECT_EQ(none.fitted.warnings[0].code, "no-split-normals");
}

TEST_F(FitFile, MendsWhatTheCommandMends) {
  // The second face is turned the wrong way round.
  const std::string input = write("turned.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\n"
                                  "f 1 2 3 4\nf 2 3 6 5\n");
  EXPECT_EQ(fit_file(input, path("mended.glb")).fitted.warnings.size(), 1u);
  FitFileOptions options;
  options.settings.repair = RepairChoice::None;
  const std::string message = message_of(ErrorCode::UnusableMesh,
                                         [&] { (void)fit_file(input, path("none.glb"), options); });
  EXPECT_THAT(message, HasSubstr("turned.obj: "));
  EXPECT_THAT(message, HasSubstr("repair() mends this"));
}

TEST_F(FitFile, ItsCageIsConfirmed) {
  const std::string input = write("plate.obj", bumpy_plate_obj(8));
  FitFileOptions options;
  options.cage = path("cage.obj");
  const FileFit done = fit_file(input, path("plate.glb"), options);
  EXPECT_EQ(done.fitted.options.method, InterpolationMethod::Fair) << "as without the cage";
  EXPECT_EQ(read("plate.glb"), (fit_file(input, path("alone.glb")), read("alone.glb")));
  const Verification found =
      verify_cage(read_mesh(path("cage.obj")).mesh, read_mesh(input).mesh, {});
  EXPECT_TRUE(found.confirmed) << found.error.max;
  EXPECT_EQ(found.vertex_count, 81);
  PolygonMesh moved = read_mesh(path("cage.obj")).mesh;
  moved.positions[3].z += 0.1;
  EXPECT_FALSE(verify_cage(moved, read_mesh(input).mesh, {}).confirmed);
}

TEST_F(FitFile, ErrorsNameTheRemedy) {
  const std::string input = write("plate.obj", bumpy_plate_obj(4));
  const std::string cloud = write("cloud.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                  "property float y\nproperty float z\nend_header\n0 0 0\n");
  const auto message = [&](ErrorCode code, const std::string& from, const std::string& to,
                           int level = 2) {
    FitFileOptions options;
    options.settings.set_levels({level});
    return message_of(code, [&] { (void)fit_file(from, to, options); });
  };
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, path("a.iges")),
              HasSubstr("is written as .glb, .gltf"));
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, input), HasSubstr("is the input itself"));
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, path("a.glb"), 9), HasSubstr("9"));
  EXPECT_THAT(message(ErrorCode::UnusableMesh, cloud, path("a.glb")), HasSubstr("cloud.ply"));
  EXPECT_THAT(message(ErrorCode::UnreadableInput, path("none.obj"), path("a.glb")),
              HasSubstr("none.obj"));
  EXPECT_FALSE(std::filesystem::exists(path("a.glb")));
}

}  // namespace
}  // namespace planish::test
