// What a dry run says against what a run then does.
#include <sys/resource.h>

#include <gmock/gmock.h>

#include <filesystem>
#include <regex>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Forecasts : public FolderTest {
 protected:
  [[nodiscard]] ProcessResult fit(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"fit", "--device", "cpu"});
    return run_planish(arguments, {.input = {}, .environment = {}, .folder = path("")});
  }
};

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

TEST_F(Forecasts, SizesAreThoseOfTheFiles) {
  write("torus.obj", torus_obj(24));
  std::vector<std::string> arguments{"torus.obj", "--levels", "3", "--cage", "cage.obj"};
  const std::vector<std::string> files{"a.glb", "a.ply", "b.obj", "a.off"};
  for (const std::string& file : files) arguments.insert(arguments.end(), {"-o", file});
  std::vector<std::string> dry = arguments;
  dry.emplace_back("--dry-run");
  const std::string text = fit(dry).out;
  EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"});
  ASSERT_EQ(fit(arguments).exit_code, 0);
  for (const std::string& file : files) {
    const auto bytes = static_cast<double>(std::filesystem::file_size(path(file)));
    const double allowed = file.ends_with(".glb") || file.ends_with(".ply") ? 0.03 : 0.15;
    EXPECT_NEAR(forecast_bytes(text, file), bytes, allowed * bytes) << file << "\n" << text;
  }
  EXPECT_THAT(text, AllOf(HasSubstr("  memory       at most about "), HasSubstr("  time         "),
                          HasSubstr("would end with exit code 0")));
}

// Texture coordinates with seams, groups, colours and creases, in every format that has them.
TEST_F(Forecasts, SizesCountWhatAMeshCarries) {
  struct Case {
    const char *scene, *levels;
    std::vector<std::string> files, flags;
  };
  const std::vector<std::string> with_fields{"a.glb", "a.ply", "a.usda"};
  const std::vector<std::string> all{"a.glb", "a.gltf", "a.ply", "a.obj",
                                     "a.off", "a.stl",  "a.usda"};
  const std::vector<std::string> fields{"--attributes", "error,fold,curvature"};
  for (const Case& c :
       {Case{"mapped_cube.obj", "3", all, {}}, Case{"mapped_cube.obj", "0", {"a.glb", "a.stl"}, {}},
        Case{"mapped_cube.obj", "2", with_fields, fields}, Case{"bearing_block.obj", "2", all, {}},
        Case{"icosphere.obj", "1", {"a.stl"}, {"--scheme", "loop"}},
        Case{"goblet.obj", "1", with_fields, fields}}) {
    std::vector<std::string> arguments{std::string(PLANISH_SCENES) + "/" + c.scene, "-f",
                                       "--levels", c.levels};
    arguments.insert(arguments.end(), c.flags.begin(), c.flags.end());
    for (const std::string& file : c.files) arguments.insert(arguments.end(), {"-o", file});
    std::vector<std::string> dry = arguments;
    dry.emplace_back("--dry-run");
    const std::string text = fit(dry).out;
    const ProcessResult run = fit(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    for (const std::string& file : c.files) {
      auto bytes = static_cast<double>(std::filesystem::file_size(path(file)));
      if (file == "a.gltf") bytes += static_cast<double>(std::filesystem::file_size(path("a.bin")));
      // Numbers in text are counted at their full length, those of planes and cubes are shorter.
      const bool is_text = file == "a.obj" || file == "a.off" || file == "a.usda";
      const double forecast = forecast_bytes(text, file), header = 512;
      EXPECT_GT(forecast, (is_text ? 0.88 : 0.97) * bytes - header)
          << c.scene << " level " << c.levels << ", " << file;
      EXPECT_LT(forecast, (is_text ? 1.35 : 1.03) * bytes + header)
          << c.scene << " level " << c.levels << ", " << file;
    }
  }
}

TEST_F(Forecasts, CagesHaveNoNormals) {
  write("torus.obj", torus_obj(64));
  for (const std::string file : {"a.obj", "a.ply", "a.off", "a.usda"}) {
    const std::string text = fit({"torus.obj", "--cage", file, "--dry-run"}).out;
    ASSERT_EQ(fit({"torus.obj", "--cage", file}).exit_code, 0);
    const auto bytes = static_cast<double>(std::filesystem::file_size(path(file)));
    EXPECT_NEAR(forecast_bytes(text, file), bytes, (file == "a.ply" ? 0.03 : 0.15) * bytes) << file;
  }
}

// "  memory       at most about 340.0 MiB" holds, and is not far off.
TEST_F(Forecasts, MemoryIsEnoughForEveryFormatAndItsAttributes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers hold memory of their own";
#endif
  write("torus.obj", torus_obj(300));  // 1.4 million rows at level 2
  const std::string fields = "error,deviation,fold,curvature";
  for (const std::vector<std::string>& what : {std::vector<std::string>{"a.glb"},
                                               {"a.stl"},
                                               {"a.obj"},
                                               {"a.usda"},
                                               {"a.glb", "--attributes", fields},
                                               {"a.ply", "--attributes", fields},
                                               {"a.glb", "--compress", "meshopt"}}) {
    std::vector<std::string> arguments{"torus.obj", "-f",     "--levels",        "2",
                                       "--report",  "r.json", "--interpolation", "progressive",
                                       "-o"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    std::vector<std::string> dry = arguments;
    dry.emplace_back("--dry-run");
    const std::string text = fit(dry).out;
    std::smatch found;
    ASSERT_TRUE(std::regex_search(text, found, std::regex("at most about ([0-9.]+) (MiB|GiB)")))
        << text;
    const double forecast = std::stod(found[1]) * (found[2] == "GiB" ? 1024.0 : 1.0) * 1024 * 1024;
    ASSERT_EQ(fit(arguments).exit_code, 0);
    const double peak = read_json("r.json")["memory"]["host_peak_bytes"].get<double>();
    EXPECT_LE(peak, forecast) << what.front() << " " << what.back();
    EXPECT_GE(peak, 0.25 * forecast) << what.front() << " " << what.back();
  }
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
