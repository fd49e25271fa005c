// What a dry run says against what a run then does.
#include <sys/resource.h>

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <regex>
#include <sstream>

#include "cli/needs.h"
#include "planish/core/words.h"
#include "planish/job/forecast.h"
#include "planish/job/job_text.h"
#include "support/cut_quads.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string obj_of(const PolygonMesh& mesh) {
  std::ostringstream obj;
  obj.precision(9);
  for (const glm::dvec3& p : mesh.positions) obj << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    obj << 'f';
    for (const std::int32_t v : mesh.face(f)) obj << ' ' << v + 1;
    obj << '\n';
  }
  return obj.str();
}

// "  would write  a.glb  (level 2, 96 quads, about 4.4 KiB)" -> bytes.
double forecast_bytes(const std::string& text, const std::string& name) {
  const std::regex line("would write  " + name + "  \\(.*about ([0-9.]+) (B|KiB|MiB|GiB)\\)");
  std::smatch found;
  if (!std::regex_search(text, found, line)) return -1;
  double bytes = std::stod(found[1]);
  for (const char* unit : {"B", "KiB", "MiB", "GiB"}) {
    if (found[2] == unit) return bytes;
    bytes *= 1024;
  }
  return -1;
}

// Whoever runs it gets no files.
TEST_F(Forecasts, OfADryRunNothingIsLeft) {
  write("torus.obj", torus_obj(24));
  const std::string text = fit({"torus.obj", "-o", "a.glb", "--cage", "c.obj", "--dry-run"}).out;
  EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"});
  EXPECT_THAT(text, AllOf(HasSubstr("  memory       at most about "), HasSubstr("  time         "),
                          HasSubstr("would end with exit code 0")));
}

// Texture coordinates with seams, groups, colours and creases, in every format whose size is told;
// of the others the vertices and faces are.
TEST_F(Forecasts, SizesCountWhatAMeshCarries) {
  struct Case {
    const char *scene, *levels;
    std::vector<std::string> files, flags;
  };
  const std::vector<std::string> all{"a.glb", "a.gltf", "a.ply", "a.stl",
                                     "a.obj", "a.off",  "a.usda"};
  const std::vector<std::string> fields{"--attributes", "error,fold,curvature"};
  for (const Case& c :
       // A cube that stays one has coordinates of few digits.
       {Case{"mapped_cube.obj", "3", all, {"--creases", "use"}},
        Case{"mapped_cube.obj", "0", {"a.glb", "a.stl"}, {}},
        Case{"mapped_cube.obj", "2", {"a.glb", "a.usda"}, fields},
        Case{"bearing_block.obj", "2", all, {}},
        Case{"icosphere.obj", "1", {"a.stl"}, {"--scheme", "loop"}},
        Case{"goblet.obj", "1", {"a.glb", "a.ply"}, fields}}) {
    std::vector<std::string> arguments{std::string(PLANISH_SCENES) + "/" + c.scene,
                                       "-f",
                                       "--levels",
                                       c.levels,
                                       "--report",
                                       "r.json"};
    arguments.insert(arguments.end(), c.flags.begin(), c.flags.end());
    for (const std::string& file : c.files) arguments.insert(arguments.end(), {"-o", file});
    std::vector<std::string> dry = arguments;
    dry.emplace_back("--dry-run");
    const std::string text = fit(dry).out;
    const ProcessResult run = fit(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json outputs = read_json("r.json")["outputs"];
    for (std::size_t i = 0; i < c.files.size(); ++i) {
      const std::string& file = c.files[i];
      const auto vertices = outputs[i]["vertices"].get<std::int64_t>();
      EXPECT_THAT(text, testing::ContainsRegex(file + "  \\(level ., " +
                                               counted(vertices, "vertex") + ", "))
          << c.scene;
      auto bytes = static_cast<double>(std::filesystem::file_size(path(file)));
      if (file == "a.gltf") bytes += static_cast<double>(std::filesystem::file_size(path("a.bin")));
      const double forecast = forecast_bytes(text, file), header = 512;
      if (file == "a.obj" || file == "a.off" || file == "a.usda") {
        EXPECT_LT(forecast, 0) << text;
      } else {
        EXPECT_NEAR(forecast, bytes, 0.03 * bytes + header)
            << c.scene << " level " << c.levels << ", " << file;
      }
    }
  }
}

TEST_F(Forecasts, SizesOfPackedFilesAreEnough) {
  for (const std::string scene : {"goblet.obj", "rocker_arm_scan.obj", "mapped_cube.obj"}) {
    for (const std::string packing : {"meshopt", "quantize"}) {
      for (const std::string level : {"0", "2"}) {
        const std::vector<std::string> arguments{std::string(PLANISH_SCENES) + "/" + scene,
                                                 "-f",
                                                 "--levels",
                                                 level,
                                                 "--compress",
                                                 packing,
                                                 "-o",
                                                 "a.glb"};
        std::vector<std::string> dry = arguments;
        dry.emplace_back("--dry-run");
        const std::string text = fit(dry).out;
        EXPECT_THAT(text, HasSubstr(", at most about "));
        ASSERT_EQ(fit(arguments).exit_code, 0);
        const auto bytes = static_cast<double>(std::filesystem::file_size(path("a.glb")));
        const double forecast = forecast_bytes(text, "a.glb");
        EXPECT_GE(forecast, bytes) << scene << " " << packing << " " << level;
        EXPECT_LE(forecast, 2.6 * bytes) << scene << " " << packing << " " << level;
      }
    }
  }
}

TEST_F(Forecasts, CagesHaveNoNormals) {
  write("torus.obj", torus_obj(64));
  const std::string text = fit({"torus.obj", "--cage", "a.ply", "--dry-run"}).out;
  ASSERT_EQ(fit({"torus.obj", "--cage", "a.ply"}).exit_code, 0);
  const auto bytes = static_cast<double>(std::filesystem::file_size(path("a.ply")));
  EXPECT_NEAR(forecast_bytes(text, "a.ply"), bytes, 0.03 * bytes);
  EXPECT_THAT(text, HasSubstr("a.ply  (control cage, 4,096 vertices, 4,096 faces, about "));
  // That of the fair method is its mesh of level 1.
  EXPECT_THAT(fit({"torus.obj", "--cage", "a.obj", "--interpolation", "fair", "--dry-run"}).out,
              HasSubstr("a.obj  (control cage, 16,384 vertices, 16,384 faces)"));
}

TEST_F(Needs, OfEveryFormatAndItsAttributes) {
  write("torus.obj", torus_obj(300));  // 1.4 million rows at level 2
  const std::string fields = "error,deviation,fold,curvature";
  for (const std::vector<std::string>& what : {std::vector<std::string>{"a.glb"},
                                               {"a.stl"},
                                               {"a.obj"},
                                               {"a.usda"},
                                               {"a.glb", "--attributes", fields},
                                               {"a.ply", "--attributes", fields},
                                               {"a.glb", "--compress", "meshopt"}}) {
    std::vector<std::string> arguments{"torus.obj", "--interpolation", "progressive", "-o"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    expect_enough(arguments);
  }
}

// Fits of both methods; of triangles, of which some are plainly halves of quads, some may be, and
// others are made to be.
TEST_F(Needs, OfTrianglesByWhatIsTried) {
  write("halves.obj", obj_of(cut_quads(torus(300, 200, 1.0, 0.4))));
  write("ball.obj", obj_of(icosphere(6)));
  write("part.obj", obj_of(cut_quads(flat_grid(250, 200))));
  for (const std::string input : {"halves.obj", "ball.obj", "part.obj"}) {
    for (const std::vector<std::string>& flags : {std::vector<std::string>{},
                                                  {"--quads", "off"},
                                                  {"--quads", "on"},
                                                  {"--interpolation", "fair"},
                                                  {"--interpolation", "progressive"}}) {
      std::vector<std::string> arguments{input, "-o", "a.glb", "--levels", "0"};
      arguments.insert(arguments.end(), flags.begin(), flags.end());
      expect_enough(arguments);
    }
  }
}

// Surfaces that leave vertices are made and measured one after another, beside the best so far.
TEST_F(Needs, OfVerticesThatMayBeLeft) {
  PolygonMesh mesh = torus(300, 120, 1.0, 0.4);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  for (glm::dvec3& p : mesh.positions) p *= 1 + noise(random);
  write("scan.obj", obj_of(mesh));
  for (const std::vector<std::string>& flags : {std::vector<std::string>{},
                                                {"--interpolation", "progressive"},
                                                {"--interpolation", "fair"},
                                                {"--scheme", "catmull-clark"}}) {
    for (const std::string within : {"1e-3", "auto"}) {
      std::vector<std::string> arguments{"scan.obj", "-o",  "a.glb",    "--levels", "0",
                                         "--refine", "off", "--within", within};
      arguments.insert(arguments.end(), flags.begin(), flags.end());
      expect_enough(arguments);
    }
  }
}

TEST_F(Needs, OfPagesAndTiles) {
  write("torus.obj", torus_obj(100));
  const std::string scan = PLANISH_SCENES "/rocker_arm_scan.obj";
  for (const std::string& input : {std::string("torus.obj"), scan}) {
    expect_enough({input, "--page", "a.html"});
    expect_enough({input, "--page", "a.html", "-o", "a.glb"});
    expect_enough({input, "-o", "a.json", "--levels", "3"});
  }
}

TEST_F(Needs, OfErrorsByHowTheMeshBends) {
  write("torus.obj", torus_obj(48));
  expect_enough({"torus.obj", "-o", "a.glb", "--chord-error", "1e-3"});
  expect_enough({"torus.obj", "-o", "a.glb", "--chord-error", "1e-5"});
  expect_enough({"torus.obj", "-o", "a.glb", "--angle", "1"});
  const std::string scan = PLANISH_SCENES "/rocker_arm_scan.obj";
  expect_enough({scan, "-o", "a.glb", "--chord-error", "1e-3"});
  expect_enough({scan, "-o", "a.glb", "--chord-error", "1e-4"});
  expect_enough({scan, "-o", "a.glb", "--chord-error", "1e-3,1e-4"});
}

#ifdef PLANISH_HAS_MESHER
// side^2 points as text, each with the same further words.
std::string torus_cloud(int side, const std::string& further = {}) {
  std::string cloud;
  for (int i = 0; i < side * side; ++i) {
    const double u = 6.2832 * (i % side) / side, v = 6.2832 * (i / side) / side;
    const double r = 1 + 0.4 * std::cos(v);
    cloud += std::to_string(r * std::cos(u)) + " " + std::to_string(r * std::sin(u)) + " " +
             std::to_string(0.4 * std::sin(v)) + further + "\n";
  }
  return cloud;
}

TEST_F(Needs, OfPointsByTheirNumber) {
  write("cloud.xyz", torus_cloud(120));
  expect_enough({"cloud.xyz", "-o", "a.glb"});
  expect_enough({"cloud.xyz", "-o", "a.glb", "--tolerance-mesh", "0"});
  std::string header = "ply\nformat ascii 1.0\nelement vertex 518400\n";
  for (const char* name : {"x", "y", "z", "quality", "time", "angle"})
    header += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"})
    header += std::string("property uchar ") + name + "\n";
  write("large.ply", header + "end_header\n" + torus_cloud(720, " 1 2 3 90 80 70"));
  expect_enough({"large.ply", "-o", "a.glb", "--tolerance-mesh", "1e-3"});
  // How many triangles an error takes is known once there is a mesh.
  EXPECT_THAT(fit({"cloud.xyz", "-o", "a.glb", "--chord-error", "1e-3", "--dry-run"}).out,
              HasSubstr("memory       known once there is a mesh"));
}
#endif

// Where measurement chooses the method there are two fits.
TEST(ForecastOf, CountsTheFitsThatAreMade) {
  const ReadyFit ready = prepare_fit(torus(20, 20, 1.0, 0.4), "torus");
  Settings settings;
  settings.interpolation = InterpolationChoice::Progressive;
  const MeshNeed need{&ready, nullptr};
  const double one = forecast_of({&need, 1}, settings, {}, 0).seconds;
  settings.interpolation = InterpolationChoice::Auto;
  EXPECT_DOUBLE_EQ(forecast_of({&need, 1}, settings, {}, 0).seconds, 2 * one);
  settings.within.is_measured = true;
  EXPECT_GT(forecast_of({&need, 1}, settings, {}, 0).seconds, 4 * one);
  EXPECT_GT(one, 0);
}

TEST_F(Forecasts, AllBuffersOfALargeSurfaceAreNamed) {
  write("torus.obj", torus_obj(150));  // 22,500 quads: 92 million at level 6, 4.1 GiB of numbers
  const ProcessResult result = fit({"torus.obj", "--levels", "6", "-o", "a.gltf", "--dry-run"});
  for (const char* name : {"a.bin  (its", "a-2.bin  (further", "a-3.bin  (further",
                           "a-4.bin  (further", "a-5.bin  (further"})
    EXPECT_THAT(result.out, HasSubstr(std::string("would write  ") + name + " numbers)"));
  EXPECT_THAT(result.out, Not(HasSubstr("a-6.bin")));
  EXPECT_THAT(
      fit({"torus.obj", "--levels", "6", "-o", "a.gltf", "--compress", "meshopt", "--dry-run"}).out,
      Not(HasSubstr("a-2.bin")));
}

TEST_F(Forecasts, WhatWouldBeRefusedIsListedAndTheExitCodeComes) {
  write("cube.obj", cube_obj());
  write("a.bin", "precious");
  const ProcessResult result =
      fit({"cube.obj", "-o", "a.gltf", "-o", "b.glb", "--report", "missing/r.json", "--dry-run"});
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_THAT(result.out, AllOf(HasSubstr("would refuse a.bin exists; --force overwrites it"),
                                HasSubstr("would write  a.gltf"), HasSubstr("would write  b.glb"),
                                HasSubstr("would refuse missing/r.json: there is no folder"),
                                HasSubstr("would end with exit code 7")));
  EXPECT_EQ(fit({"cube.obj", "-o", "a.gltf", "-f", "--dry-run"}).exit_code, 0);
}

TEST_F(Forecasts, AMeshThatCannotBeUsedIsTold) {
  write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\n");
  const ProcessResult result = fit({"bad.obj", "-o", "a.glb", "--repair", "none", "--dry-run"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.out, HasSubstr("would end with exit code 4"));
}

TEST_F(Forecasts, ARunThatNeedsMoreMemoryThanThereIsNamesTheLevelThatFits) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve more address space than a limit would leave";
#endif
  // 100,489 quads are 4.1e8 at level 6; values of vertices need the whole surface, 21 GB.
  write("large.obj", torus_obj(317));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit small = before;
  small.rlim_cur = rlim_t{8} << 30;
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &small), 0);
  const ProcessResult result =
      fit({"large.obj", "-o", "a.glb", "--levels", "6", "--attributes", "error"});
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, testing::ContainsRegex(
                              "level 6 needs about .* of memory where .* are free; --levels [0-5] "
                              "fits"));
  EXPECT_EQ(names(), std::vector<std::string>{"large.obj"});
}

TEST_F(Forecasts, WhatFitsByBlocksIsNotRefused) {
  // Its surface as a whole would take 21 GB.
  write("large.obj", torus_obj(317));
  const ProcessResult result = fit({"large.obj", "-o", "a.gltf", "--levels", "6", "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::ContainsRegex("memory       at most about [12].[0-9] GiB"));
}

TEST_F(Forecasts, MoreCornersThanIndicesReachAreRefusedFirst) {
  // 250,000 quads are 1.0e9 at level 6.
  write("large.obj", torus_obj(500));
  const ProcessResult result = fit({"large.obj", "-o", "a.gltf", "--levels", "6"});
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("more than 32-bit indices reach; take fewer levels"));
  EXPECT_EQ(names(), std::vector<std::string>{"large.obj"});
}

TEST_F(Forecasts, VerboseSaysMoreThanTheDefault) {
  write("torus.obj", torus_obj(12));
  const std::string text =
      fit({"torus.obj", "-o", "a.glb", "-v", "--interpolation", "progressive"}).err;
  for (const char* part : {"threads ", "bound ", "errors ", "memory "})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(fit({"torus.obj", "-o", "b.glb"}).err, Not(HasSubstr("bound ")));
}

TEST_F(Forecasts, FlagsWithoutEffectAreTold) {
  write("torus.obj", torus_obj(12));
  const std::string text = fit({"torus.obj", "-o", "a.glb", "--interpolation", "fair", "--solver",
                                "cg", "--spacing", "even"})
                               .err;
  EXPECT_THAT(text, HasSubstr("warning: torus.obj: without effect here: --solver, --spacing"));
  EXPECT_THAT(
      fit({"torus.obj", "-o", "b.glb", "--solver", "cg", "--interpolation", "progressive"}).err,
      Not(HasSubstr("without effect")));
  // Told by what is chosen.
  EXPECT_THAT(fit({"torus.obj", "-o", "c.glb", "--solver", "cg"}).err,
              HasSubstr("without effect here: --solver (the input is a mesh, the method fair)"));
}

TEST_F(Forecasts, ATerminalIsToldTheNextStep) {
  write("cube.obj", cube_obj());
  const ProcessResult result = run_planish(
      {"fit", "cube.obj", "-o", "a.glb"},
      {.input = {}, .terminal = true, .environment = {"TERM=xterm"}, .folder = path("")});
  EXPECT_THAT(result.out, HasSubstr("next: open a.glb"));
  EXPECT_THAT(fit({"cube.obj", "-o", "b.glb"}).err, Not(HasSubstr("next:")));
}

}  // namespace
}  // namespace planish::test
