#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>
#include <vector>

#include "cli/needs.h"
#include "files/gltf/asset_sample.h"
#include "large_arrays.h"
#include "planish/core/words.h"
#include "planish/job/forecast.h"
#include "planish/job/job_text.h"
#include "planish/surface/memory_need.h"
#include "support/cut_quads.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// What a dry run says against what a run then does.

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

// Whoever runs it gets no files.
TEST_F(Forecasts, OfADryRunNothingIsLeft) {
  write("torus.obj", torus_obj(24));
  const std::string text = fit({"torus.obj", "-o", "a.glb", "--cage", "c.obj", "--dry-run"}).out;
  EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"});
  EXPECT_THAT(text, AllOf(HasSubstr("  memory       at most about "), HasSubstr("  time         "),
                          HasSubstr("would end with exit code 0")));
}

// Texture coordinates with seams, groups and creases, in every format.
TEST_F(Forecasts, VerticesAreThoseOfTheFile) {
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
    }
  }
}

TEST_F(Forecasts, CagesAreThoseOfTheMethod) {
  write("torus.obj", torus_obj(64));
  const std::string text = fit({"torus.obj", "--cage", "a.ply", "--dry-run"}).out;
  EXPECT_THAT(text, HasSubstr("a.ply  (control cage, 4,096 vertices, 4,096 faces)"));
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

// How far an asset of several meshes is, and what of memory it takes.

using nlohmann::json;
using testing::ContainsRegex;

// Meshes are held together, whatever rides on them, and so are their surfaces.
TEST_F(Needs, OfAllMeshesOfAnAsset) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(40, 30, 1.0, 0.4);
  write("many.glb", large_asset(std::vector<PolygonMesh>(6, ring)));
  write("small.glb", large_asset(std::vector<PolygonMesh>(30, small)));
  write("skins.glb", large_asset({ring, ring}, {{.joints = 40}, {.targets = 8}}));
  // Weights of joints take more by one method than by the other: what is left open is enough for
  // either.
  for (const auto& [input, method] : {std::pair{"many.glb", "auto"},
                                      {"small.glb", "auto"},
                                      {"skins.glb", "auto"},
                                      {"skins.glb", "progressive"},
                                      {"skins.glb", "fair"}})
    for (const std::vector<std::string>& how : {std::vector<std::string>{"--levels", "1"},
                                                {"--levels", "2"},
                                                {"--compress", "meshopt"},
                                                {"--chord-error", "1e-4"}}) {
      std::vector<std::string> arguments{input, "-o", "a.glb", "--interpolation", method};
      arguments.insert(arguments.end(), how.begin(), how.end());
      expect_enough(arguments, input != std::string("skins.glb") || method != std::string("auto"));
    }
}

// A limit that each mesh would keep by itself, before anything is fitted.
TEST_F(Needs, OfAllMeshesAreRefusedTogether) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4);
  write("one.glb", large_asset({ring}));
  write("many.glb", large_asset(std::vector<PolygonMesh>(12, ring)));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit small = before;
  small.rlim_cur = rlim_t{3} << 30;
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &small), 0);
  const std::vector<std::string> how{"-o", "a.glb", "--levels", "5", "--dry-run"};
  std::vector<std::string> one{"one.glb"}, many{"many.glb"};
  one.insert(one.end(), how.begin(), how.end());
  many.insert(many.end(), how.begin(), how.end());
  const ProcessResult fits = fit(one), refused = fit(many);
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(fits.exit_code, 0) << fits.out;
  EXPECT_EQ(refused.exit_code, 6) << refused.out;
  EXPECT_THAT(refused.out, ContainsRegex("level 5 of 12 meshes needs about .* --levels [0-4] "
                                         "fits"));
}

// Once from 0 to 1 through all of them, and never in a large step.
TEST_F(Forecasts, ProgressRisesThroughAllMeshes) {
  // Large enough that loops go in many pieces.
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(60, 40, 1.0, 0.4);
  write("many.glb", large_asset({ring, small, ring, ring}, {{}, {.joints = 6}, {}, {}}));
  for (const std::vector<std::string>& how : {std::vector<std::string>{"--levels", "2"},
                                              {"--levels", "1", "--compress", "meshopt"},
                                              {"--levels", "2,1", "--lods", "msft"}}) {
    std::vector<std::string> arguments{"many.glb", "-o", "a.glb", "-f", "--progress", "json"};
    arguments.insert(arguments.end(), how.begin(), how.end());
    std::istringstream lines(fit(arguments).err);
    std::vector<double> shares{0};
    std::vector<double> fitting;
    for (std::string line; std::getline(lines, line);) {
      const json entry = json::parse(line, nullptr, false);
      if (entry.is_discarded() || !entry.contains("share")) continue;
      shares.push_back(entry["share"]);
      if (entry["step"] == "stencils") fitting.push_back(shares.back());
    }
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_GE(shares.back(), 0.999) << how.back();
    double largest = 0;
    for (std::size_t i = 1; i < shares.size(); ++i)
      largest = std::max(largest, shares[i] - shares[i - 1]);
    EXPECT_LE(largest, 0.15) << how.back();
    // Each fit begins further on than the one before.
    ASSERT_GE(fitting.size(), 4U);
    EXPECT_GT(fitting.back(), fitting.front() + 0.05);
  }
}

// What --memory and --temporary promise: the same bytes in less memory, and nothing that is left.

using command::give_back_array;
using command::hold_arrays_within;
using command::NoRoomForArray;
using command::take_large_array;

constexpr std::size_t kMiB = std::size_t{1} << 20;

class MemoryBudget : public Forecasts {
 protected:
  [[nodiscard]] double peak_of(const std::vector<std::string>& arguments) const {
    const ProcessResult run = fit(arguments, true);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.peak_bytes;
  }
};

std::size_t resident_bytes() {
  std::size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST_F(MemoryBudget, BytesAreThoseOfAJobWithout) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers hold memory of their own";
#endif
  write("torus.obj", torus_obj(900));
  const double without = peak_of({"torus.obj", "-o", "a.ply", "--levels", "0"});
  const double within = peak_of({"torus.obj", "-o", "b.ply", "--levels", "0", "--memory", "256M"});
  EXPECT_GT(without, 300 * kMiB);
  EXPECT_LT(within, 256 * kMiB);
  EXPECT_EQ(read("a.ply"), read("b.ply"));
  EXPECT_EQ(names(), (std::vector<std::string>{"a.ply", "b.ply", "torus.obj"}));
}

#ifdef PLANISH_HAS_MESHER
TEST_F(MemoryBudget, PointsGiveTheSameMesh) {
  const ProcessResult made =
      fit({"--levels", "1", "-o", "points.ply", PLANISH_SCENES "/goblet.obj"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto reconstruct = [&](const std::string& output, std::vector<std::string> further) {
    further.insert(further.begin(), {"reconstruct", "points.ply", "-o", output});
    return run_planish(further, {.input = {}, .folder = path("")});
  };
  ASSERT_EQ(reconstruct("a.obj", {}).exit_code, 0);
  ASSERT_EQ(reconstruct("b.obj", {"--memory", "256M", "--temporary", "."}).exit_code, 0);
  EXPECT_EQ(read("a.obj"), read("b.obj"));
}
#endif

TEST_F(MemoryBudget, WhatIsKilledLeavesNothing) {
  const std::string input = write("torus.obj", torus_obj(450));
  std::filesystem::create_directory(path("temporary"));
  PlanishProcess process(
      {"fit", "--device", "cpu", input, "-o", path("a.ply"), "--levels", "4", "--memory", "256M",
       "--temporary", path("temporary"), "--progress", "json"},
      {});
  EXPECT_TRUE(process.wait_for_message("\"level\""));
  ::kill(process.id(), SIGKILL);
  EXPECT_EQ(process.finish().signal, SIGKILL);
  EXPECT_TRUE(std::filesystem::is_empty(path("temporary")));
}

TEST_F(MemoryBudget, WhatIsWrongIsSaid) {
  write("torus.obj", torus_obj(24));
  const auto said = [&](std::vector<std::string> arguments, int exit_code) {
    arguments.insert(arguments.begin(), {"torus.obj", "-o", "a.glb"});
    const ProcessResult result = fit(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return result.err;
  };
  EXPECT_THAT(said({"--memory", "much"}, 2), HasSubstr("--memory: \"much\" is no size of up to"));
  EXPECT_THAT(said({"--memory", "6T"}, 2), HasSubstr("such as 6G or 800M"));
  EXPECT_THAT(said({"--memory", "100M"}, 2),
              HasSubstr("--memory: 100.0 MiB are too little; the least that works is 256M"));
  EXPECT_THAT(said({"--temporary", "."}, 2), HasSubstr("--temporary: is the folder of --memory"));
  EXPECT_THAT(said({"--memory", "1G", "--temporary", "no/where"}, 7),
              AllOf(HasSubstr("--temporary: no/where: cannot create a file"),
                    HasSubstr("No such file or directory")));
}

TEST_F(MemoryBudget, TheOutputsFolderNeedNotBeThere) {
  write("torus.obj", torus_obj(24));
  const ProcessResult result = fit({"torus.obj", "-o", "new/folder/", "--memory", "256M"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(exists("new/folder/torus.glb"));
}

TEST_F(MemoryBudget, ADryRunTellsTheDisk) {
  write("torus.obj", torus_obj(300));
  const std::vector<std::string> job{"torus.obj", "-o", "a.glb", "--levels", "5", "--dry-run"};
  std::vector<std::string> within = job;
  within.insert(within.end(), {"--memory", "256M"});
  const double all = forecast_memory(fit(job).out);
  ASSERT_GT(all, 300 * kMiB);
  EXPECT_THAT(fit(within).out,
              ContainsRegex("memory       256.0 MiB, and at most about .* in a temporary file in "
                            ".*, which has .* free"));
}

// Of this process, which no other test shares.
TEST_F(MemoryBudget, ArraysLeaveMemoryAndKeepTheirContent) {
  const auto work = [&] {
    EXPECT_EQ(take_large_array(64 * kMiB), nullptr);
    const std::uint64_t before = available_memory_bytes();
    hold_arrays_within(resident_bytes() + 96 * kMiB, path(""));
    EXPECT_GT(available_memory_bytes(), before);
    constexpr std::size_t kCount = 8, kWords = 32 * kMiB / sizeof(std::uint64_t);
    std::vector<std::uint64_t*> arrays;
    for (std::size_t a = 0; a < kCount; ++a) {
      arrays.push_back(static_cast<std::uint64_t*>(take_large_array(32 * kMiB)));
      std::iota(arrays.back(), arrays.back() + kWords, a << 32);
    }
    ::usleep(50'000);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(resident_bytes(), 160 * kMiB);  // sanitizers hold a shadow of what was written, too
#endif
    for (std::size_t a = 0; a < kCount; ++a)
      for (std::size_t i = 0; i < kWords; ++i)
        if (arrays[a][i] != (a << 32) + i) return 1;
    for (std::uint64_t* const array : arrays)
      if (!give_back_array(array) || give_back_array(array)) return 2;
    // More than the disk has.
    const rlimit small{.rlim_cur = kMiB, .rlim_max = kMiB};
    ::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &small);
    try {
      (void)take_large_array(512 * kMiB);
      return 3;
    } catch (const std::bad_alloc&) {
      EXPECT_THAT(
          command::job_failure().message,
          AllOf(HasSubstr("--temporary: "), HasSubstr("cannot take room for 536870912 bytes"),
                HasSubstr("name a folder with more")));
    }
    return testing::Test::HasFailure() ? 4 : 0;
  };
  EXPECT_EXIT(std::_Exit(work()), testing::ExitedWithCode(0), "");
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace planish::test
