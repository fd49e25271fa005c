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
