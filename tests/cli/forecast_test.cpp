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

using command::give_back_array;
using command::hold_arrays_within;
using command::take_large_array;
using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

using Forecasts = FolderTest;

constexpr std::size_t kMiB = std::size_t{1} << 20;

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

// No process that this one starts has more address space, for as long as this lives.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(rlim_t bytes) {
    EXPECT_EQ(::getrlimit(RLIMIT_AS, &before_), 0);
    rlimit small = before_;
    small.rlim_cur = bytes;
    EXPECT_EQ(::setrlimit(RLIMIT_AS, &small), 0);
  }
  ~AddressSpaceLimit() { EXPECT_EQ(::setrlimit(RLIMIT_AS, &before_), 0); }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;

 private:
  rlimit before_{};
};

// Texture coordinates with seams, groups and creases, in every format.
TEST_F(Forecasts, VerticesAreThoseOfTheFile) {
  const std::string all = " -o a.glb -o a.gltf -o a.ply -o a.stl -o a.obj -o a.off -o a.usda";
  const std::string fields = " --attributes error,fold,curvature";
  for (const std::string& flags : {"mapped_cube.obj --levels 3 --creases use" + all,
                                   std::string("mapped_cube.obj --levels 0 -o a.glb -o a.stl"),
                                   "mapped_cube.obj --levels 2 -o a.glb -o a.usda" + fields,
                                   "bearing_block.obj --levels 2" + all,
                                   std::string("icosphere.obj --levels 1 --scheme loop -o a.stl"),
                                   "goblet.obj --levels 1 -o a.glb -o a.ply" + fields}) {
    const std::string line = "fit " PLANISH_SCENES "/" + flags;
    const std::string text = run(line + " -f --dry-run").out;
    for (const json& output : report_of(line)["outputs"]) {
      const std::string vertices = counted(output["vertices"].get<std::int64_t>(), "vertex");
      EXPECT_THAT(text, ContainsRegex(output["path"].get<std::string>() + "  \\(level ., " +
                                      vertices + ", "))
          << line;
    }
  }
}

TEST_F(Forecasts, CagesAreThoseOfTheMethod) {
  write("torus.obj", torus_obj(64));
  EXPECT_THAT(run("fit torus.obj --cage a.ply --dry-run").out,
              HasSubstr("a.ply  (control cage, 4,096 vertices, 4,096 faces)"));
  // That of the fair method is its mesh of level 1.
  EXPECT_THAT(run("fit torus.obj --cage a.obj --interpolation fair --dry-run").out,
              HasSubstr("a.obj  (control cage, 16,384 vertices, 16,384 faces)"));
}

TEST_F(Needs, OfEveryFormatAndItsAttributes) {
  write("torus.obj", torus_obj(300));  // 1.4 million rows at level 2
  const std::string fields = " --attributes error,deviation,fold,curvature";
  for (const std::string& what :
       {std::string("a.glb"), std::string("a.stl"), std::string("a.obj"), std::string("a.usda"),
        "a.glb" + fields, "a.ply" + fields, std::string("a.glb --compress meshopt")})
    expect_enough("torus.obj --interpolation progressive -o " + what);
}

// Fits of both methods; of triangles, of which some are plainly halves of quads, some may be, and
// others are made to be.
TEST_F(Needs, OfTrianglesByWhatIsTried) {
  write("halves.obj", obj_of(cut_quads(torus(300, 200, 1.0, 0.4))));
  write("ball.obj", obj_of(icosphere(6)));
  write("part.obj", obj_of(cut_quads(flat_grid(250, 200))));
  for (const std::string input : {"halves.obj", "ball.obj", "part.obj"})
    for (const char* flags : {"", " --quads off", " --quads on", " --interpolation fair",
                              " --interpolation progressive"})
      expect_enough(input + " -o a.glb --levels 0" + flags);
}

// Surfaces that leave vertices are made and measured one after another, beside the best so far.
TEST_F(Needs, OfVerticesThatMayBeLeft) {
  PolygonMesh mesh = torus(300, 120, 1.0, 0.4);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  for (glm::dvec3& p : mesh.positions) p *= 1 + noise(random);
  write("scan.obj", obj_of(mesh));
  for (const std::string flags :
       {"", " --interpolation progressive", " --interpolation fair", " --scheme catmull-clark"})
    for (const char* within : {" --within 1e-3", " --within auto"})
      expect_enough("scan.obj -o a.glb --levels 0 --refine off" + flags + within);
}

TEST_F(Needs, OfPagesAndTiles) {
  write("torus.obj", torus_obj(100));
  for (const std::string input : {"torus.obj", PLANISH_SCENES "/rocker_arm_scan.obj"})
    for (const char* outputs :
         {" --page a.html", " --page a.html -o a.glb", " -o a.json --levels 3"})
      expect_enough(input + outputs);
}

TEST_F(Needs, OfErrorsByHowTheMeshBends) {
  write("torus.obj", torus_obj(48));
  for (const std::string fineness : {"--chord-error 1e-3", "--chord-error 1e-5", "--angle 1"})
    expect_enough("torus.obj -o a.glb " + fineness);
  for (const std::string errors : {"1e-3", "1e-4", "1e-3,1e-4"})
    expect_enough(PLANISH_SCENES "/rocker_arm_scan.obj -o a.glb --chord-error " + errors);
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
  expect_enough("cloud.xyz -o a.glb");
  expect_enough("cloud.xyz -o a.glb --tolerance-mesh 0");
  std::string header = "ply\nformat ascii 1.0\nelement vertex 518400\n";
  for (const char* name : {"x", "y", "z", "quality", "time", "angle"})
    header += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"})
    header += std::string("property uchar ") + name + "\n";
  write("large.ply", header + "end_header\n" + torus_cloud(720, " 1 2 3 90 80 70"));
  expect_enough("large.ply -o a.glb --tolerance-mesh 1e-3");
  // How many triangles an error takes is known once there is a mesh.
  EXPECT_THAT(run("fit cloud.xyz -o b.glb --chord-error 1e-3 --dry-run").out,
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

TEST_F(Forecasts, ARunThatNeedsMoreMemoryThanThereIsNamesTheLevelThatFits) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve more address space than a limit would leave";
#endif
  // 100,489 quads are 4.1e8 at level 6; values of vertices need the whole surface, 21 GB.
  write("large.obj", torus_obj(317));
  {
    const AddressSpaceLimit limit(rlim_t{8} << 30);
    run("fit large.obj -o a.glb --levels 6 --attributes error", 6);
  }
  EXPECT_THAT(said_, ContainsRegex("level 6 needs about .* of memory where .* are free; --levels "
                                   "[0-5] fits"));
  EXPECT_EQ(names(), std::vector<std::string>{"large.obj"});
  // By blocks it fits.
  EXPECT_THAT(run("fit large.obj -o a.gltf --levels 6 --dry-run").out,
              ContainsRegex("memory       at most about [12].[0-9] GiB"));
}

TEST_F(Forecasts, MoreCornersThanIndicesReachAreRefusedFirst) {
  for (const int side : {500, 750}) {  // 1.0e9 and 2.3e9 quads at level 6
    write("large.obj", torus_obj(side));
    run("fit large.obj -o a.gltf --levels 6", 6);
    EXPECT_THAT(said_, HasSubstr("more than 32-bit indices reach; take fewer levels"));
    EXPECT_EQ(names(), std::vector<std::string>{"large.obj"});
  }
}

TEST_F(Forecasts, ATerminalIsToldTheNextStep) {
  write("cube.obj", cube_obj());
  const ProcessResult shown =
      run("fit cube.obj -o a.glb", 0, {.terminal = true, .environment = {"TERM=xterm"}});
  EXPECT_THAT(shown.out, HasSubstr("next: open a.glb"));
  run("fit cube.obj -o b.glb");
  EXPECT_THAT(said_, Not(HasSubstr("next:")));
}

// How far an asset of several meshes is, and what of memory it takes.

// Meshes are held together, whatever rides on them, and so are their surfaces.
TEST_F(Needs, OfAllMeshesOfAnAsset) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(40, 30, 1.0, 0.4);
  write("many.glb", large_asset(std::vector<PolygonMesh>(6, ring)));
  write("small.glb", large_asset(std::vector<PolygonMesh>(30, small)));
  write("skins.glb", large_asset({ring, ring}, {{.joints = 40}, {.targets = 8}}));
  // Weights of joints take more by one method than by the other: what is left open is enough for
  // either.
  for (const std::string input :
       {"many.glb", "small.glb", "skins.glb", "skins.glb --interpolation progressive",
        "skins.glb --interpolation fair"})
    for (const char* how :
         {" --levels 1", " --levels 2", " --compress meshopt", " --chord-error 1e-4"})
      expect_enough(input + " -o a.glb" + how, input != "skins.glb");
}

// A limit that each mesh would keep by itself, before anything is fitted.
TEST_F(Needs, OfAllMeshesAreRefusedTogether) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4);
  write("one.glb", large_asset({ring}));
  write("many.glb", large_asset(std::vector<PolygonMesh>(12, ring)));
  const AddressSpaceLimit limit(rlim_t{3} << 30);
  run("fit one.glb -o a.glb --levels 5 --dry-run");
  EXPECT_THAT(run("fit many.glb -o a.glb --levels 5 --dry-run", 6).out,
              ContainsRegex("level 5 of 12 meshes needs about .* --levels [0-4] fits"));
}

// Once from 0 to 1 through all of them, and never in a large step.
TEST_F(Forecasts, ProgressRisesThroughAllMeshes) {
  // Large enough that loops go in many pieces.
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(60, 40, 1.0, 0.4);
  write("many.glb", large_asset({ring, small, ring, ring}, {{}, {.joints = 6}, {}, {}}));
  for (const std::string how :
       {"--levels 2", "--levels 1 --compress meshopt", "--levels 2,1 --lods msft"}) {
    SCOPED_TRACE(how);
    run("fit many.glb -o a.glb -f --progress json " + how);
    std::vector<double> shares{0};
    std::vector<double> fitting;
    for (const std::string& line : lines_of(said_)) {
      const json entry = json::parse(line, nullptr, false);
      if (entry.is_discarded() || !entry.contains("share")) continue;
      shares.push_back(entry["share"]);
      if (entry["step"] == "stencils") fitting.push_back(shares.back());
    }
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_GE(shares.back(), 0.999);
    double largest = 0;
    for (std::size_t i = 1; i < shares.size(); ++i)
      largest = std::max(largest, shares[i] - shares[i - 1]);
    EXPECT_LE(largest, 0.15);
    // Each fit begins further on than the one before.
    ASSERT_GE(fitting.size(), 4U);
    EXPECT_GT(fitting.back(), fitting.front() + 0.05);
  }
}

// What --memory and --temporary promise: the same bytes in less memory, and nothing that is left.

using MemoryBudget = FolderTest;

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
  const std::string line = "fit torus.obj --levels 0 -o ";
  EXPECT_GT(run(line + "a.ply", 0, {.measured = true}).peak_bytes, 300 * kMiB);
  EXPECT_LT(run(line + "b.ply --memory 256M", 0, {.measured = true}).peak_bytes, 256 * kMiB);
  EXPECT_EQ(read("a.ply"), read("b.ply"));
  EXPECT_EQ(names(), (std::vector<std::string>{"a.ply", "b.ply", "torus.obj"}));
}

#ifdef PLANISH_HAS_MESHER
TEST_F(MemoryBudget, PointsGiveTheSameMesh) {
  run("fit --levels 1 -o points.ply " PLANISH_SCENES "/goblet.obj");
  run("reconstruct points.ply -o a.obj");
  run("reconstruct points.ply -o b.obj --memory 256M --temporary .");
  EXPECT_EQ(read("a.obj"), read("b.obj"));
}
#endif

TEST_F(MemoryBudget, WhatIsKilledLeavesNothing) {
  write("torus.obj", torus_obj(450));
  std::filesystem::create_directory(path("temporary"));
  PlanishProcess process(
      words_of("fit torus.obj -o a.ply --levels 4 --memory 256M --temporary temporary --progress "
               "json"),
      {.folder = path("")});
  EXPECT_TRUE(process.wait_for_message("\"level\""));
  ::kill(process.id(), SIGKILL);
  EXPECT_EQ(process.finish().signal, SIGKILL);
  EXPECT_TRUE(std::filesystem::is_empty(path("temporary")));
}

TEST_F(MemoryBudget, TheOutputsFolderNeedNotBeThere) {
  write("torus.obj", torus_obj(24));
  run("fit torus.obj -o new/folder/ --memory 256M");
  EXPECT_TRUE(exists("new/folder/torus.glb"));
}

TEST_F(MemoryBudget, ADryRunTellsTheDisk) {
  write("torus.obj", torus_obj(300));
  const std::string line = "fit torus.obj -o a.glb --levels 5 --dry-run";
  ASSERT_GT(forecast_memory(run(line).out), 300 * kMiB);
  EXPECT_THAT(run(line + " --memory 256M").out,
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
