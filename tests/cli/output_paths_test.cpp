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
  void put(const fs::path& name, const std::string& text = "somebody's") const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  [[nodiscard]] std::string text_of(const fs::path& name) const {
    std::ifstream file(folder_ / name);
    return file ? std::string(std::istreambuf_iterator<char>(file), {}) : "none";
  }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.insert(entry.path().filename());
    return found;
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
    put("b");
    StagedFiles staged(overwrites);
    for (const char* name : {"a", "b", "c"}) staged.write(folder_ / name, "ours");
    if (overwrites) {
      staged.commit();
    } else {
      EXPECT_EQ(refusal(staged),
                (folder_ / "b").string() + " exists by now; --force overwrites it");
    }
    const std::string others = overwrites ? "ours" : "none";
    EXPECT_EQ(text_of("a"), others);
    EXPECT_EQ(text_of("b"), overwrites ? "ours" : "somebody's");
    EXPECT_EQ(text_of("c"), others);
  }
  EXPECT_EQ(names(), (std::set<std::string>{"a", "b", "c"}));
}

TEST_F(StagedFilesTest, LinksAreNotReplacedEither) {
  fs::create_symlink(folder_ / "nowhere", folder_ / "a");
  StagedFiles staged(false);
  staged.write(folder_ / "a", "ours");
  EXPECT_THAT(refusal(staged), HasSubstr("a exists by now"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "a"));
}

TEST_F(StagedFilesTest, ATileSetReplacesNothingUnasked) {
  put("t/mine.txt");
  StagedFiles staged(false);
  stage_tiles(staged);
  EXPECT_THAT(refusal(staged), HasSubstr("t exists by now; --force"));
  EXPECT_EQ(text_of("t/mine.txt"), "somebody's");
  EXPECT_EQ(text_of("t.json"), "none");
}

TEST_F(StagedFilesTest, AFolderGoesWithItsDocument) {
  put("t.json");
  fs::create_directory(folder_ / "t");  // an empty one is in nobody's way
  {
    StagedFiles staged(false);
    stage_tiles(staged);
    EXPECT_THAT(refusal(staged), HasSubstr("t.json exists by now; --force"));
  }
  EXPECT_EQ(text_of("t.json"), "somebody's");
  EXPECT_EQ(text_of("t/0.glb"), "none");
  StagedFiles staged(true);
  stage_tiles(staged);
  staged.commit();
  EXPECT_EQ(text_of("t.json"), "ours");
  EXPECT_EQ(text_of("t/0.glb"), "ours");
}

// Buffers of a .gltf behind the first: put in place with it, and removed with it.

class FurtherBuffers : public StagedFilesTest {
 protected:
  // As a job does; returns how many buffers there are.
  std::size_t stage(std::uint64_t buffer_bytes, bool overwrites) const {
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
};

TEST_F(FurtherBuffers, ComeWithTheDocumentAndGoWithIt) {
  EXPECT_EQ(stage(20000, false), 2u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin"}));
  EXPECT_EQ(stage(10000, true), 4u);
  put("a b-9.bin");
  put("a b-x.bin");
  EXPECT_EQ(stage(20000, true), 2u);
  EXPECT_EQ(names(),
            (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin", "a b-9.bin", "a b-x.bin"}));
  EXPECT_EQ(stage(1 << 20, true), 1u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-9.bin", "a b-x.bin"}));
}

TEST_F(FurtherBuffers, OfNobodyKnownStay) {
  put("a b-2.bin");
  // Not named so by the document that is replaced.
  for (const char* document :
       {R"({"buffers": [{"uri": "a b.bin"}, {"uri": "a b-2.bin"}]})", "no JSON"}) {
    put("a b.gltf", document);
    EXPECT_EQ(stage(1 << 20, true), 1u);
    EXPECT_TRUE(fs::exists(folder_ / "a b-2.bin"));
  }
}

TEST_F(FurtherBuffers, AreNotReplacedUnasked) {
  put("a b-2.bin");
  EXPECT_NE(test::message_of(ErrorCode::UnwritableOutput, [&] { (void)stage(20000, false); }),
            "no error");
  EXPECT_EQ(names(), (std::set<std::string>{"a b-2.bin"}));
}

}  // namespace
}  // namespace planish::command

namespace planish::test {
namespace {

// Refusals stand in messages_test.cpp.

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class OutputPaths : public FolderTest {
 protected:
  std::string cube_ = write("cube.obj", cube_obj());
};

TEST_F(OutputPaths, AnExistingOutputIsReplacedByForceAndSuccessAlone) {
  write("old.glb", "precious");
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  run("fit bad.obj -o old.glb -f", 3);
  EXPECT_EQ(read("old.glb"), "precious");
  run("fit cube.obj -o old.glb --force");
  EXPECT_EQ(read("old.glb").substr(0, 4), "glTF");
}

TEST_F(OutputPaths, SeveralLevelsAreNumberedInTheirOrder) {
  run("fit cube.obj -o a.obj --levels 3,1");
  EXPECT_THAT(names(), ElementsAre("a_LOD0.obj", "a_LOD1.obj", "cube.obj"));
  // Level l of a cube has 6 * 4^l quads.
  EXPECT_EQ(read_mesh(path("a_LOD0.obj")).mesh.face_count(), 384);
  EXPECT_EQ(read_mesh(path("a_LOD1.obj")).mesh.face_count(), 24);
}

TEST_F(OutputPaths, ADryRunWritesNothing) {
  const std::string text = run("fit cube.obj -o a.glb --cage c.obj --report r.json --dry-run").out;
  EXPECT_THAT(names(), ElementsAre("cube.obj"));
  for (const char* part :
       {"8 vertices", "6 faces", "a.glb", "96 quads", "c.obj", "r.json",
        "  memory       at most about ", "  time         ", "would end with exit code 0"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST_F(OutputPaths, NamesAsLongAsTheyCanBeAreWritten) {
  const auto named = [](const std::string& extension) {
    return std::string(255 - extension.size(), 'n') + extension;
  };
  run("fit cube.obj -o " + named(".glb") + " -o " + named(".ply") + " --cage " + named(".obj") +
      " --report " + named(".r.json") + " --page " + named(".html"));
  EXPECT_EQ(names().size(), 6u);
  // A set of tiles over another one, both names at their longest.
  const std::string tiles = "fit cube.obj -o " + std::string(255 - 5, 't') + ".json";
  run(tiles);
  run(tiles + " -f");
  EXPECT_EQ(names().size(), 8u);
}

TEST_F(OutputPaths, WhatCannotBeWrittenIsNamedAsItWasAskedFor) {
  {
    const FileSizeLimit limit(1 << 10);
    for (const std::string name : {"a.glb", "a.obj", "a.gltf", "a.usda"}) {
      run("fit cube.obj -o " + name, 7);
      const std::string shown = name == "a.gltf" ? "a.bin" : name;
      EXPECT_THAT(said_, testing::ContainsRegex(": " + shown + ": cannot (write|take room)"));
      EXPECT_THAT(said_, Not(HasSubstr(".planish-")));
    }
    run("fit cube.obj --report r.json -o " + path("a.stl"), 7);
    EXPECT_THAT(said_, HasSubstr(path("a.stl") + ": cannot"));
  }
  EXPECT_THAT(names(), ElementsAre("cube.obj"));
}

// No file that is read is ever written, whatever flags say; and nothing that has no end is read.

class InputHarm : public FolderTest {
 protected:
  InputHarm() {
    write("cube.obj", cube_obj());
    run("fit cube.obj -o a.gltf --levels 1 -q");
    fs::rename(path("a.bin"), path("b.bin"));
    std::string text = read("a.gltf");
    write("a.gltf", text.replace(text.find("a.bin"), 5, "b.bin"));
    write("wood.png", AssetSample::image());
    write("y.mtl", "newmtl wood\n# mine\nKd 1 0 0\nmap_Kd wood.png\n");
    std::string obj = cube_obj();
    write("x.obj", "mtllib y.mtl\n" + obj.insert(obj.find("f "), "usemtl wood\n"));
  }

  struct Harm {
    const char *line, *file, *input;  // what would be written, and what is read with or as it
  };
  // Refused before any work, and every file is as it was.
  void expect_refused(const std::vector<Harm>& table) {
    const auto before = contents();
    for (const Harm& row : table) {
      run(row.line, 2);
      EXPECT_THAT(
          said_, AllOf(HasSubstr(row.file), HasSubstr(row.input), HasSubstr("choose another name")))
          << row.line;
      EXPECT_EQ(contents(), before) << row.line;
    }
  }
  [[nodiscard]] std::vector<std::string> contents() const {
    std::vector<std::string> all;
    for (const std::string& name : names())
      all.push_back(name + "\n" + (fs::is_regular_file(path(name)) ? read(name) : ""));
    return all;
  }
};

TEST_F(InputHarm, BuffersAndMaterialsOfTheInputStay) {
  write("scene.json", R"({"version": 1, "jobs": [
      {"name": "one", "input": "cube.obj", "outputs": [{"path": "b.gltf"}]},
      {"name": "two", "input": "a.gltf", "outputs": [{"path": "two.glb"}]}]})");
  write("report.json", R"({"version": 1, "jobs": [
      {"name": "one", "input": "cube.obj", "outputs": [{"path": "c.glb"}]}]})");
  expect_refused({
      {"fit a.gltf -o b.gltf -f", "b.bin", "a.gltf"},
      {"fit x.obj -o y.obj -f", "y.mtl", "x.obj"},
      {"fit x.obj -o z.glb --cage y.obj -f", "y.mtl", "x.obj"},
      {"fit a.gltf -o b.gltf -f --dry-run", "b.bin", "a.gltf"},
      {"fit cube.obj --source a.gltf -o b.gltf -f", "b.bin", "a.gltf"},
      // Of other jobs, too: what one writes another reads.
      {"run scene.json -f", "b.bin", "a.gltf"},
      {"run report.json --report report.json -f", "report.json is the input itself", ""},
  });
  run("fit cube.obj a.gltf -o b.gltf -f", 2);
}

TEST_F(InputHarm, FilesAreTheSameByWhateverName) {
  write("q.xyz", "0 0 0\n");
  fs::create_symlink("b.bin", path("soft.bin"));
  // As where case is folded: another name of the same file.
  for (const auto& [file, name] : {std::pair{"b.bin", "hard.bin"},
                                   {"cube.obj", "CUBE.OBJ"},
                                   {"b.bin", "r.json"},
                                   {"wood.png", "p.html"},
                                   {"q.xyz", "q.json"}})
    fs::create_hard_link(path(file), path(name));
  fs::create_directory_symlink(".", path("here"));
  expect_refused({
      {"fit a.gltf -o soft.gltf -f", "soft.bin", "a.gltf"},
      {"fit a.gltf -o hard.gltf -f", "hard.bin", "a.gltf"},
      {"fit CUBE.OBJ -o cube.obj -f", "cube.obj", "CUBE.OBJ"},
      {"fit a.gltf -o here/b.gltf -f", "b.bin", "a.gltf"},
      // Reports, pages and answers are outputs like others.
      {"fit a.gltf -o c.glb --report r.json -f", "r.json", "a.gltf"},
      {"fit x.obj --page p.html -f", "p.html", "x.obj"},
      {"query cube.obj --points q.xyz -o q.json -f", "q.json", "q.xyz"},
  });
}

TEST_F(InputHarm, FoldersOfTilesGoWithNothingThatIsRead) {
  run("fit x.obj -o city.json -q");
  ASSERT_TRUE(exists("city/images/0.png"));
  write("y.mtl", "newmtl wood\nmap_Kd city/images/0.png\n");
  run("fit x.obj -o city.json -f", 2);
  EXPECT_THAT(said_, AllOf(HasSubstr("0.png is read with the input"), HasSubstr("x.obj")));
  EXPECT_TRUE(exists("city/images/0.png"));
}

TEST_F(InputHarm, OtherNamesAreWritten) {
  for (const std::string output : {"c.gltf", "c.obj", "c.json"})
    for (int again = 0; again < 2; ++again) run("fit a.gltf -o " + output + " -f -q");
  EXPECT_EQ(read_mesh(path("c.gltf")).mesh.face_count(),
            2 * read_mesh(path("c.obj")).mesh.face_count());
}

TEST_F(InputHarm, WhatIsNamedIsNeitherWaitedForNorWithoutAnEnd) {
  ASSERT_EQ(mkfifo(path("fifo").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", path("zero"));
  const auto expect_small = [&](const std::string& input, int exit_code, const char* part,
                                double bytes = 100e6) {
    const ProcessResult result =
        run("fit " + input + " -o z.glb -f", exit_code, {.measured = true});
    EXPECT_THAT(said_, HasSubstr(part));
    EXPECT_LT(result.peak_bytes, bytes);
  };
  for (const std::string name : {"fifo", "zero", "/dev/zero"}) {
    write("y.mtl", "newmtl wood\nmap_Kd " + name + "\n");
    expect_small("x.obj", 0, "; the texture is left out");
    write("n.obj", "mtllib " + name + "\n" + cube_obj());
    expect_small("n.obj", 0, "its materials are not there: ");
    std::string text = read("a.gltf");
    write("n.gltf", text.replace(text.find("b.bin"), 5, name));
    expect_small("n.gltf", 3, "it belongs to this file");
  }
  expect_small("/dev/zero", 3, "/dev/zero: is a device, and does not end after", 300e6);
}

TEST_F(InputHarm, TexturesOfOtherFoldersComeWhereTheyAreWanted) {
  write("model/x.obj", read("x.obj"));
  write("model/y.mtl", "newmtl wood\nmap_Kd ../wood.png\n");
  const std::string fit = "fit model/x.obj -o z.glb -f";
  run(fit);
  EXPECT_THAT(said_, AllOf(HasSubstr("wood.png"), HasSubstr("--textures anywhere")));
  EXPECT_THAT(read("z.glb"), Not(HasSubstr("image/png")));
  run(fit + " --textures anywhere");
  EXPECT_THAT(said_, Not(HasSubstr("wood.png")));
  EXPECT_THAT(read("z.glb"), HasSubstr("image/png"));
  fs::create_symlink("../wood.png", path("model/link.png"));
  write("model/y.mtl", "newmtl wood\nmap_Kd link.png\n");
  run(fit);
  EXPECT_THAT(said_, HasSubstr("link.png: leads away from the folder of the file"));
  // Buffers alike, for all that reads files.
  fs::copy(path("a.gltf"), path("model/a.gltf"));
  fs::create_symlink("../b.bin", path("model/b.bin"));
  for (const std::string line : {"inspect model/a.gltf", "query model/a.gltf --points cube.obj",
                                 "fit model/a.gltf -o z.glb -f"}) {
    run(line, 3);
    EXPECT_THAT(said_, HasSubstr("--textures anywhere"));
    run(line + " --textures anywhere");
  }
}

}  // namespace
}  // namespace planish::test
