#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "support/file_size_limit.h"

namespace planish::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class OutputPaths : public FolderTest {
 protected:
  // Expects an error before any work: the folder holds what it held.
  void expect_refused(std::vector<std::string> arguments, int exit_code, const std::string& part) {
    const auto before = names();
    arguments.insert(arguments.begin(), {"fit", cube_});
    const ProcessResult result = run_planish(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(part));
    EXPECT_EQ(names(), before);
  }

  std::string cube_ = write("cube.obj", cube_obj());
};

TEST_F(OutputPaths, AnExistingOutputNeedsForce) {
  write("cube.glb", "precious");
  expect_refused({"-o", path("cube.glb")}, 7, "exists; --force overwrites it");
  EXPECT_EQ(read("cube.glb"), "precious");
  EXPECT_EQ(run_planish({"fit", cube_, "-o", path("cube.glb"), "--force"}).exit_code, 0);
  EXPECT_EQ(read("cube.glb").substr(0, 4), "glTF");
}

TEST_F(OutputPaths, AFailedRunLeavesTheOldFile) {
  write("old.glb", "precious");
  const std::string bad = write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  EXPECT_EQ(run_planish({"fit", bad, "-o", path("old.glb"), "-f"}).exit_code, 3);
  EXPECT_EQ(read("old.glb"), "precious");
}

TEST_F(OutputPaths, TheInputIsNeverWritten) {
  expect_refused({"-o", cube_, "-f"}, 2, "is the input itself");
  std::filesystem::create_symlink(cube_, path("link.obj"));
  expect_refused({"--cage", path("link.obj"), "-f"}, 2, "is the input itself");
}

TEST_F(OutputPaths, NothingIsWrittenTwice) {
  expect_refused({"-o", path("a.obj"), "--cage", path("a.obj")}, 2, "is written twice");
  expect_refused({"-o", path("a.obj"), "-o", path("./a.obj")}, 2, "is written twice");
  expect_refused({"-o", "-", "--report", "-"}, 2, "stdout can take one thing only");
}

TEST_F(OutputPaths, TheCompanionOfAGltfCounts) {
  write("a.bin", "precious");
  expect_refused({"-o", path("a.gltf")}, 7, "a.bin exists");
}

TEST_F(OutputPaths, UnknownExtensionsAreRefused) {
  expect_refused(
      {"-o", path("a.fbx")}, 2,
      "a surface is written as .glb, .gltf, .obj, .ply, .off, .stl, .usda, .json or .step");
  expect_refused({"--cage", path("a.glb")}, 2, "a cage is written as .obj, .ply, .off or .usda");
  expect_refused({"-o", path("newdir")}, 2, "; a folder ends with a slash, as " + path("newdir/"));
}

TEST_F(OutputPaths, WhatTheDiskRefusesIsAnOutputErrorWhateverItIs) {
  expect_refused({"-o", path("missing/a.glb")}, 7, "there is no folder");
  std::filesystem::create_directory(path("folder.json"));
  expect_refused({"-o", path("a.glb"), "--report", path("folder.json")}, 7, "is a folder");
}

TEST_F(OutputPaths, ANameThatNoFileSystemTakesIsRefusedAtOnce) {
  const std::string stem(251, 'a');
  EXPECT_EQ(run_planish({"fit", cube_, "-o", path(stem + ".glb")}).exit_code, 0);
  EXPECT_EQ(read(stem + ".glb").substr(0, 4), "glTF");
  expect_refused({"-o", path(stem + "a.glb")}, 7, "no file name is longer than 255 bytes");
}

TEST_F(OutputPaths, FormatsOfOthersAreToldHowToGetThere) {
  expect_refused({"-o", path("a.fbx")}, 2, "from a .glb \"assimp export ");
  expect_refused({"-o", path("a.usdz")}, 2, "Blender converts it");
}

TEST_F(OutputPaths, AFolderThatTakesNoFilesIsAnOutputError) {
  expect_refused({"-o", "/proc/planish_test.glb"}, 7, "/proc");
}

TEST_F(OutputPaths, SeveralLevelsAreNumberedInTheirOrder) {
  const ProcessResult result = run_planish({"fit", cube_, "-o", path("a.obj"), "--levels", "3,1"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names(), ElementsAre("a_LOD0.obj", "a_LOD1.obj", "cube.obj"));
  // Level l of a cube has 6 * 4^l quads.
  const auto faces = [&](const char* name) {
    const std::string text = read(name);
    std::size_t count = 0;
    for (std::size_t at = text.find("\nf "); at != std::string::npos;
         at = text.find("\nf ", at + 1)) {
      ++count;
    }
    return count;
  };
  EXPECT_EQ(faces("a_LOD0.obj"), 384u);
  EXPECT_EQ(faces("a_LOD1.obj"), 24u);
}

TEST_F(OutputPaths, SeveralLevelsDoNotFitStdout) {
  expect_refused({"-o", "-", "--levels", "1,2"}, 2, "stdout takes one level only");
}

TEST_F(OutputPaths, ADryRunWritesNothing) {
  const ProcessResult result =
      run_planish({"fit", cube_, "-o", path("a.glb"), "--cage", path("c.obj"), "--report",
                   path("r.json"), "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names(), ElementsAre("cube.obj"));
  for (const char* part : {"8 vertices", "6 faces", "a.glb", "96 quads", "c.obj", "r.json"}) {
    EXPECT_THAT(result.out, HasSubstr(part));
  }
}

TEST_F(OutputPaths, PipesAreNotReplacedByFiles) {
  ASSERT_EQ(::mkfifo(path("pipe.obj").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/null", path("null.glb"));
  for (const char* name : {"pipe.obj", "null.glb"}) {
    expect_refused({"-o", path(name)}, 7, "is a pipe or a device");
    expect_refused({"-o", path(name), "-f"}, 7, "\"-o -\" writes a GLB to stdout");
  }
  EXPECT_TRUE(std::filesystem::is_fifo(path("pipe.obj")));
  EXPECT_TRUE(std::filesystem::is_symlink(path("null.glb")));
}

TEST_F(OutputPaths, NamesAsLongAsTheyCanBeAreWritten) {
  const auto named = [&](const std::string& extension) {
    return path(std::string(255 - extension.size(), 'n') + extension);
  };
  const ProcessResult result =
      run_planish({"fit", cube_, "-o", named(".glb"), "-o", named(".ply"), "--cage", named(".obj"),
                   "--report", named(".r.json"), "--page", named(".html")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names().size(), 6u);
  // A set of tiles over another one, both names at their longest.
  const std::string folder(255 - 5, 't');
  for (const char* force : {"-v", "-f"}) {
    const ProcessResult tiles =
        run_planish({"fit", cube_, "-o", path(folder + ".json"), force, "--device", "cpu"});
    EXPECT_EQ(tiles.exit_code, 0) << tiles.err;
  }
  EXPECT_EQ(names().size(), 8u);
}

TEST_F(OutputPaths, WhatCannotBeWrittenIsNamedAsItWasAskedFor) {
  {
    const FileSizeLimit limit(1 << 10);
    for (const char* name : {"a.glb", "a.obj", "a.gltf", "a.usda"}) {
      const ProcessResult result =
          run_planish({"fit", cube_, "-o", name, "--device", "cpu"},
                      {.input = {}, .environment = {}, .folder = path("")});
      EXPECT_EQ(result.exit_code, 7);
      const std::string shown = std::string(name) == "a.gltf" ? "a.bin" : name;
      EXPECT_THAT(result.err, testing::ContainsRegex(": " + shown + ": cannot (write|take room)"));
      EXPECT_THAT(result.err, testing::Not(HasSubstr(".planish-")));
    }
    const ProcessResult result =
        run_planish({"fit", cube_, "-o", path("a.stl"), "--report", path("r.json")});
    EXPECT_THAT(result.err, HasSubstr(path("a.stl") + ": cannot"));
  }
  EXPECT_THAT(names(), ElementsAre("cube.obj"));
}

}  // namespace
}  // namespace planish::test
