// No file that is read is ever written, whatever flags say; and nothing that has no end is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "planish/files/mesh_file.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
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
