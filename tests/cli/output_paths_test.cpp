#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "files/gltf/surfaces.h"
#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/job/staged_files.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish::command {
namespace {

// Files that come to an output's place while the job runs.

namespace fs = std::filesystem;
using testing::HasSubstr;

class StagedFilesTest : public testing::Test {
 protected:
  void put(const fs::path& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  [[nodiscard]] std::string text_of(const fs::path& name) const {
    std::ifstream file(folder_ / name);
    return file ? std::string(std::istreambuf_iterator<char>(file), {}) : "none";
  }
  static std::string refusal(StagedFiles& staged) {
    return test::message_of(ErrorCode::UnwritableOutput, [&] { staged.commit(); });
  }
  // A document with one tile.
  void stage_tiles(StagedFiles& staged) const {
    const fs::path document = staged.stage_with_folder(folder_ / "t.json", folder_ / "t");
    std::ofstream(document) << "ours";
    fs::create_directories(document.parent_path() / "t");
    std::ofstream(document.parent_path() / "t" / "0.glb") << "ours";
  }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(StagedFilesTest, AppearTogetherOrNotAtAll) {
  for (const bool overwrites : {false, true}) {
    put("b", "somebody's");
    {
      StagedFiles staged(overwrites);
      staged.write(folder_ / "a", "ours");
      staged.write(folder_ / "b", "ours");
      staged.write(folder_ / "c", "ours");
      if (overwrites) {
        staged.commit();
      } else {
        EXPECT_EQ(refusal(staged),
                  (folder_ / "b").string() + " exists by now; --force overwrites it");
      }
    }
    const std::string others = overwrites ? "ours" : "none";
    EXPECT_EQ(text_of("a"), others);
    EXPECT_EQ(text_of("b"), overwrites ? "ours" : "somebody's");
    EXPECT_EQ(text_of("c"), others);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), overwrites ? 3 : 1);
  }
}

TEST_F(StagedFilesTest, LinksAreNotReplacedEither) {
  fs::create_symlink(folder_ / "nowhere", folder_ / "a");
  StagedFiles staged(false);
  staged.write(folder_ / "a", "ours");
  EXPECT_THAT(refusal(staged), HasSubstr("a exists by now"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "a"));
}

TEST_F(StagedFilesTest, ATileSetReplacesNothingUnasked) {
  put("t/mine.txt", "somebody's");
  StagedFiles staged(false);
  stage_tiles(staged);
  EXPECT_THAT(refusal(staged), HasSubstr("t exists by now; --force"));
  EXPECT_EQ(text_of("t/mine.txt"), "somebody's");
  EXPECT_EQ(text_of("t.json"), "none");
}

TEST_F(StagedFilesTest, AFolderGoesWithItsDocument) {
  put("t.json", "somebody's");
  fs::create_directory(folder_ / "t");  // an empty one is in nobody's way
  {
    StagedFiles staged(false);
    stage_tiles(staged);
    EXPECT_THAT(refusal(staged), HasSubstr("t.json exists by now; --force"));
  }
  EXPECT_EQ(text_of("t.json"), "somebody's");
  EXPECT_EQ(text_of("t/0.glb"), "none");
  {
    StagedFiles staged(true);
    stage_tiles(staged);
    staged.commit();
  }
  EXPECT_EQ(text_of("t.json"), "ours");
  EXPECT_EQ(text_of("t/0.glb"), "ours");
}

// Buffers of a .gltf behind the first: put in place with it, and removed with it.

class FurtherBuffers : public testing::Test {
 protected:
  // As a job does; returns how many buffers there are.
  std::size_t put(std::uint64_t buffer_bytes, bool overwrites) const {
    StagedFiles staged(overwrites);
    const PlannedOutput planned{
        .path = folder_ / "a b.gltf", .format = FileFormat::Gltf, .fineness = {}};
    const fs::path target = staged.stage(planned.path);
    GltfOptions options;
    options.buffer_bytes = buffer_bytes;
    const GltfFile written = write_gltf(target, test::wavy_grid(30, 20), options);
    (void)staged.stage(folder_ / "a b.bin");
    stage_further_buffers(planned, target, staged);
    staged.commit();
    return written.buffer_count;
  }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.insert(entry.path().filename());
    return found;
  }
  void write(const char* name) const { std::ofstream(folder_ / name) << "somebody's"; }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(FurtherBuffers, ComeWithTheDocument) {
  EXPECT_EQ(put(20000, false), 2u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin"}));
}

TEST_F(FurtherBuffers, OfTheReplacedDocumentGo) {
  EXPECT_EQ(put(10000, false), 4u);
  write("a b-9.bin");
  write("a b-x.bin");
  EXPECT_EQ(put(20000, true), 2u);
  EXPECT_EQ(names(),
            (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin", "a b-9.bin", "a b-x.bin"}));
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-9.bin", "a b-x.bin"}));
}

TEST_F(FurtherBuffers, OfNobodyKnownStay) {
  write("a b-2.bin");
  // Not named so by the document that is replaced.
  std::ofstream(folder_ / "a b.gltf")
      << R"({"buffers": [{"uri": "a b.bin"}, {"uri": "a b-2.bin"}]})";
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_TRUE(fs::exists(folder_ / "a b-2.bin"));
  std::ofstream(folder_ / "a b.gltf") << "no JSON";
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_TRUE(fs::exists(folder_ / "a b-2.bin"));
}

TEST_F(FurtherBuffers, AreNotReplacedUnasked) {
  write("a b-2.bin");
  try {
    (void)put(20000, false);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnwritableOutput);
  }
  EXPECT_EQ(names(), (std::set<std::string>{"a b-2.bin"}));
}

}  // namespace
}  // namespace planish::command

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

// No file that is read is ever written, whatever flags say; and nothing that has no end is read.

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Not;

class InputHarm : public FolderTest {
 protected:
  InputHarm() {
    write("cube.obj", cube_obj());
    EXPECT_EQ(run_planish({"fit", path("cube.obj"), "-o", path("a.gltf"), "--levels", "1", "-q"})
                  .exit_code,
              0);
    fs::rename(path("a.bin"), path("b.bin"));
    std::string text = read("a.gltf");
    text.replace(text.find("a.bin"), 5, "b.bin");
    write("a.gltf", text);
    write("wood.png", AssetSample::image());
    write("y.mtl", "newmtl wood\n# mine\nKd 1 0 0\nmap_Kd wood.png\n");
    std::string obj = cube_obj();
    obj.insert(obj.find("f "), "usemtl wood\n");
    write("x.obj", "mtllib y.mtl\n" + obj);
  }

  // Refused before any work, and every file is as it was.
  void expect_refused(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& parts) {
    const auto before = contents();
    const ProcessResult result = run_planish(arguments);
    EXPECT_EQ(result.exit_code, 2) << testing::PrintToString(arguments) << result.err;
    for (const std::string& part : parts)
      EXPECT_THAT(result.err, AllOf(HasSubstr(part), HasSubstr("choose another name")));
    EXPECT_EQ(contents(), before) << testing::PrintToString(arguments);
  }
  [[nodiscard]] std::vector<std::string> contents() const {
    std::vector<std::string> all;
    for (const std::string& name : names())
      all.push_back(name + "\n" + (fs::is_regular_file(path(name)) ? read(name) : ""));
    return all;
  }
};

TEST_F(InputHarm, BuffersAndMaterialsOfTheInputStay) {
  expect_refused({"fit", path("a.gltf"), "-o", path("b.gltf"), "-f"}, {"b.bin", "a.gltf"});
  expect_refused({"fit", path("x.obj"), "-o", path("y.obj"), "-f"}, {"y.mtl", "x.obj"});
  expect_refused({"fit", path("x.obj"), "-o", path("z.glb"), "--cage", path("y.obj"), "-f"},
                 {"y.mtl", "x.obj"});
  expect_refused({"fit", path("a.gltf"), "-o", path("b.gltf"), "-f", "--dry-run"},
                 {"b.bin", "a.gltf"});
  // Of other jobs, too: what one writes another reads.
  expect_refused({"fit", path("cube.obj"), path("a.gltf"), "-o", path("b.gltf"), "-f"}, {});
  write("scene.json", R"({"version": 1, "jobs": [
      {"name": "one", "input": "cube.obj", "outputs": [{"path": "b.gltf"}]},
      {"name": "two", "input": "a.gltf", "outputs": [{"path": "two.glb"}]}]})");
  expect_refused({"run", path("scene.json"), "-f"}, {"b.bin", "a.gltf"});
  write("report.json", R"({"version": 1, "jobs": [
      {"name": "one", "input": "cube.obj", "outputs": [{"path": "c.glb"}]}]})");
  expect_refused({"run", path("report.json"), "--report", path("report.json"), "-f"},
                 {"report.json is the input itself"});
  expect_refused({"fit", path("cube.obj"), "--source", path("a.gltf"), "-o", path("b.gltf"), "-f"},
                 {"b.bin", "a.gltf"});
}

TEST_F(InputHarm, FilesAreTheSameByWhateverName) {
  fs::create_symlink("b.bin", path("soft.bin"));
  fs::create_hard_link(path("b.bin"), path("hard.bin"));
  for (const char* name : {"soft", "hard"})
    expect_refused({"fit", path("a.gltf"), "-o", path(std::string(name) + ".gltf"), "-f"},
                   {std::string(name) + ".bin", "a.gltf"});
  // As where case is folded: another name of the same file.
  fs::create_hard_link(path("cube.obj"), path("CUBE.OBJ"));
  expect_refused({"fit", path("CUBE.OBJ"), "-o", path("cube.obj"), "-f"}, {"cube.obj", "CUBE.OBJ"});
  fs::create_directory_symlink(".", path("here"));
  expect_refused({"fit", path("a.gltf"), "-o", path("here/b.gltf"), "-f"}, {"b.bin", "a.gltf"});
  // Reports, pages and answers are outputs like others.
  fs::create_hard_link(path("b.bin"), path("r.json"));
  fs::create_hard_link(path("wood.png"), path("p.html"));
  expect_refused({"fit", path("a.gltf"), "-o", path("c.glb"), "--report", path("r.json"), "-f"},
                 {"r.json", "a.gltf"});
  expect_refused({"fit", path("x.obj"), "--page", path("p.html"), "-f"}, {"p.html", "x.obj"});
  write("q.xyz", "0 0 0\n");
  fs::create_hard_link(path("q.xyz"), path("q.json"));
  expect_refused({"query", path("cube.obj"), "--points", path("q.xyz"), "-o", path("q.json"), "-f"},
                 {"q.json", "q.xyz"});
}

TEST_F(InputHarm, FoldersOfTilesGoWithNothingThatIsRead) {
  ASSERT_EQ(run_planish({"fit", path("x.obj"), "-o", path("city.json"), "-q"}).exit_code, 0);
  ASSERT_TRUE(exists("city/images/0.png"));
  write("y.mtl", "newmtl wood\nmap_Kd city/images/0.png\n");
  const ProcessResult result = run_planish({"fit", path("x.obj"), "-o", path("city.json"), "-f"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, AllOf(HasSubstr("0.png is read with the input"), HasSubstr("x.obj")));
  EXPECT_TRUE(exists("city/images/0.png"));
}

TEST_F(InputHarm, OtherNamesAreWritten) {
  for (const char* output : {"c.gltf", "c.obj", "c.json"})
    for (int again = 0; again < 2; ++again) {
      const ProcessResult result =
          run_planish({"fit", path("a.gltf"), "-o", path(output), "-f", "-q"});
      EXPECT_EQ(result.exit_code, 0) << output << result.err;
    }
  EXPECT_EQ(read_mesh(path("c.gltf")).mesh.face_count(),
            2 * read_mesh(path("c.obj")).mesh.face_count());
}

TEST_F(InputHarm, WhatIsNamedIsNeitherWaitedForNorWithoutAnEnd) {
  ASSERT_EQ(mkfifo(path("fifo").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", path("zero"));
  for (const char* name : {"fifo", "zero", "/dev/zero"}) {
    write("y.mtl", std::string("newmtl wood\nmap_Kd ") + name + "\n");
    ProcessResult result =
        run_planish({"fit", path("x.obj"), "-o", path("z.glb"), "-f"}, {.measured = true});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("; the texture is left out"));
    EXPECT_LT(result.peak_bytes, 100e6);
    write("n.obj", std::string("mtllib ") + name + "\n" + cube_obj());
    result = run_planish({"fit", path("n.obj"), "-o", path("z.glb"), "-f"}, {.measured = true});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("its materials are not there: "));
    EXPECT_LT(result.peak_bytes, 100e6);
    std::string text = read("a.gltf");
    text.replace(text.find("b.bin"), 5, name);
    write("n.gltf", text);
    result = run_planish({"fit", path("n.gltf"), "-o", path("z.glb"), "-f"}, {.measured = true});
    EXPECT_EQ(result.exit_code, 3) << result.err;
    EXPECT_THAT(result.err, HasSubstr("it belongs to this file"));
    EXPECT_LT(result.peak_bytes, 100e6);
  }
}

TEST_F(InputHarm, ADeviceWithoutAnEndIsNoInput) {
  const ProcessResult result =
      run_planish({"fit", "/dev/zero", "-o", path("z.glb")}, {.measured = true});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("/dev/zero: is a device, and does not end after"));
  EXPECT_LT(result.peak_bytes, 300e6);
}

TEST_F(InputHarm, TexturesOfOtherFoldersComeWhereTheyAreWanted) {
  fs::create_directory(path("model"));
  std::string obj = read("x.obj");
  write("model/x.obj", obj);
  write("model/y.mtl", "newmtl wood\nmap_Kd ../wood.png\n");
  const auto fit = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", path("model/x.obj"), "-o", path("z.glb"), "-f"});
    const ProcessResult result = run_planish(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_THAT(fit({}), AllOf(HasSubstr("wood.png"), HasSubstr("--textures anywhere")));
  EXPECT_THAT(read("z.glb"), Not(HasSubstr("image/png")));
  EXPECT_THAT(fit({"--textures", "anywhere"}), Not(HasSubstr("wood.png")));
  EXPECT_THAT(read("z.glb"), HasSubstr("image/png"));
  fs::create_symlink("../wood.png", path("model/link.png"));
  write("model/y.mtl", "newmtl wood\nmap_Kd link.png\n");
  EXPECT_THAT(fit({}), HasSubstr("link.png: leads away from the folder of the file"));
  write("scene.json", R"({"version": 1, "defaults": {"textures": "anywhere"}, "jobs": [
      {"name": "one", "input": "model/x.obj", "outputs": [{"path": "s.glb"}]}]})");
  EXPECT_EQ(run_planish({"run", path("scene.json"), "-f"}).exit_code, 0);
  EXPECT_THAT(read("s.glb"), HasSubstr("image/png"));
  // Buffers alike, for all that reads files.
  fs::copy(path("a.gltf"), path("model/a.gltf"));
  fs::create_symlink("../b.bin", path("model/b.bin"));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"inspect", path("model/a.gltf")},
        {"query", path("model/a.gltf"), "--points", path("cube.obj")},
        {"fit", path("model/a.gltf"), "-o", path("z.glb"), "-f"}}) {
    const ProcessResult refused = run_planish(command);
    EXPECT_EQ(refused.exit_code, 3) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("--textures anywhere"));
    std::vector<std::string> wider = command;
    wider.insert(wider.end(), {"--textures", "anywhere"});
    EXPECT_EQ(run_planish(wider).exit_code, 0) << command[0];
  }
}

}  // namespace
}  // namespace planish::test
