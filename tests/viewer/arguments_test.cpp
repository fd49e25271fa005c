// The viewer as a process: what it refuses, and what a run off-screen leaves.
#include "viewer/arguments.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cli/planish_process.h"
#include "viewer/fixture.h"

namespace planish::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

void expect_error(const std::vector<std::string>& arguments, int code, const std::string& part) {
  const test::ProcessResult result = test::run_planish(arguments);
  EXPECT_EQ(result.exit_code, code) << part;
  EXPECT_THAT(result.err, AllOf(StartsWith("planish-viewer: error: "), HasSubstr(part)));
}

TEST(ViewerArguments, HelpHasExamples) {
  const test::ProcessResult result = test::run_planish({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:"), HasSubstr("--headless")));
}

TEST(ViewerArguments, WhatIsWrongIsNamed) {
  expect_error({"--no-such-flag"}, 2, "--no-such-flag");
  expect_error({"--png", "a.png"}, 2, "--headless");
  expect_error({"--headless", "--frames", "0"}, 2, "--frames");
  expect_error({"--script", "a.txt"}, 2, "--headless");
  expect_error({"--headless", "--script", "a.txt", "--frames", "2"}, 2, "--frames");
  expect_error({"--headless", "--edit"}, 2, "--edit");
  expect_error({"--headless", "--iterations", "65"}, 2, "--iterations");
  expect_error({"--headless", "--level", "-1"}, 2, "--level");
  expect_error({"--headless", "--size", "10x10"}, 2, "--size 10x10");
  expect_error({"--headless", "--size", "100"}, 2, "--size 100");
  expect_error({"--headless", "--view", "nan,0"}, 2, "--view nan,0");
  expect_error({"--headless", "--view", "0,90"}, 2, "--view 0,90");
  expect_error({"--headless", "--scene", "missing.obj"}, 3, "missing.obj");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.obj", "--job", "goblet"}, 2,
               "--job goblet");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.json", "--job", "cup"}, 2, "cup");
  const auto points = std::filesystem::temp_directory_path() / "planish_viewer_points.xyz";
  std::ofstream(points) << "0 0 0\n1 0 0\n0 1 0\n";
  expect_error({"--headless", "--scene", points.string()}, 2, "planish reconstruct");
  std::filesystem::remove(points);
}

class ViewerProcess : public ViewerTest {};

TEST_F(ViewerProcess, Tessellates) {
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", PLANISH_SCENES "/cube_with_windows.obj",
                         "--tessellate", "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("tessellated on"), HasSubstr("validation: 0 messages")));
}

TEST_F(ViewerProcess, DrawsManyAtTheLevelsThatTheyNeed) {
  const std::string scene = PLANISH_SCENES "/cube_with_windows.obj";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", scene, "--instances", "50", "--frames", "2",
                         "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("50 of cube_with_windows on"), HasSubstr(" at level 1\n"),
                                HasSubstr(" off screen\n"), HasSubstr("validation: 0 messages")));
  expect_error({"--scene", scene, "--instances", "50"}, 2, "--instances requires --headless");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.obj", "--instances", "60000"}, 6,
               "choose fewer, or a smaller mesh");
}

TEST_F(ViewerProcess, WritesAPicture) {
  const auto path = std::filesystem::temp_directory_path() / "planish_viewer_test.png";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", PLANISH_SCENES "/cube_with_holes.obj", "--frames",
                         "5", "--size", "64x48", "--heat", "--validate", "--png", path.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("5 frames"), HasSubstr("validation: 0 messages")));
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(bytes, StartsWith("\x89PNG"));
  std::filesystem::remove(path);
}

// A cube cut at its seams, by the fair method.
TEST_F(ViewerProcess, DrawsSquaresByTextureCoordinates) {
  const std::string scene = PLANISH_SCENES "/mapped_cube.obj";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", scene, "--texture", "--frames", "3", "--size",
                         "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("validation: 0 messages"));
  expect_error({"--headless", "--scene", PLANISH_SCENES "/torus.obj", "--texture"}, 2,
               "--texture: torus has no texture coordinates");
}

TEST_F(ViewerProcess, DrawsAScriptOfMoves) {
  const auto folder = std::filesystem::temp_directory_path() / "planish_viewer_script";
  std::filesystem::create_directories(folder);
  const std::string script = (folder / "moves.txt").string(), mesh = (folder / "a.obj").string();
  std::ofstream(script) << "vertices 0\nradius 0.5\nmove 0 0 0.2 3\npicture "
                        << (folder / "a.png").string() << "\nsave mesh " << mesh << '\n';
  const std::string scene = PLANISH_SCENES "/torus.obj";
  const test::ProcessResult result = test::run_planish(
      {"--headless", "--scene", scene, "--script", script, "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  // Within the tolerance of 1e-6.
  EXPECT_THAT(
      result.out,
      AllOf(ContainsRegex("5 steps, 4 frames; the surface is within [0-9.]+e-(0[7-9]|[1-9][0-9]) "),
            HasSubstr("validation: 0 messages")));
  EXPECT_TRUE(std::filesystem::exists(mesh));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
  expect_error({"--headless", "--scene", scene, "--script", "missing.txt"}, 3, "missing.txt");
  std::ofstream(script) << "vertices 99999\n";
  expect_error({"--headless", "--scene", scene, "--script", script, "--size", "64x48"}, 2,
               script + ":1: there is no vertex 99999");
  std::ofstream(script) << "jump\n";
  expect_error({"--headless", "--scene", scene, "--script", script}, 2, script + ":1: 'jump'");
  std::filesystem::remove_all(folder);
}

TEST_F(ViewerProcess, SaysThatAPictureCannotBeWritten) {
  expect_error({"--headless", "--scene", PLANISH_SCENES "/cube.obj", "--size", "64x48", "--png",
                "/no/such/folder/a.png"},
               7, "/no/such/folder");
}

TEST_F(ViewerProcess, DevicesThatAreNotThereAreNamed) {
  expect_error({"--headless", "--scene", PLANISH_SCENES "/cube.obj", "--device", "abacus"}, 6,
               "'abacus'");
}

}  // namespace
}  // namespace planish::testing
