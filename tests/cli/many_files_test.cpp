// fit of several inputs: files and folders in, a folder of surfaces out.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

namespace fs = std::filesystem;

class ManyFiles : public FolderTest {
 protected:
  ManyFiles() {
    write("cube.obj", cube_obj());
    write("scans/plate.obj", bumpy_plate_obj(4));
    write("scans/torus.off", off_of_a_torus());
    write("scans/notes.txt", "not a mesh");
  }
  [[nodiscard]] ProcessResult fit(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"fit", "--device", "cpu"});
    return run_planish(arguments, {.input = {}, .environment = {}, .folder = path("")});
  }
  [[nodiscard]] std::vector<std::string> names_in(const std::string& folder) const {
    std::vector<std::string> result;
    for (const auto& entry : fs::directory_iterator(path(folder)))
      result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  static std::string off_of_a_torus() {
    return "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  }
};

TEST_F(ManyFiles, GoIntoAFolderUnderTheirNames) {
  const ProcessResult result = fit({"cube.obj", "scans/", "-o", "out/", "--report", "all.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb", "plate.glb", "torus.glb"));
  EXPECT_THAT(result.err, AllOf(HasSubstr("name "), HasSubstr("cube "), HasSubstr("plate ")));
  const auto report = read_json("all.json");
  EXPECT_EQ(report["schema"], "planish.batch/1");
  ASSERT_EQ(report["jobs"].size(), 3u);
  EXPECT_EQ(report["jobs"][1]["input"]["path"], "scans/plate.obj");
  EXPECT_EQ(report["jobs"][1]["outputs"][0]["path"], "out/plate.glb");
}

TEST_F(ManyFiles, OneThatFailsDoesNotStopTheOthers) {
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  const ProcessResult result =
      fit({"bad.obj", "cube.obj", "-o", "out", "--report", "all.json", "-j", "2"});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb"));
  EXPECT_THAT(result.err, AllOf(HasSubstr("error: bad.obj:2: "), HasSubstr("1 of 2 jobs failed")));
  const auto report = read_json("all.json");
  EXPECT_EQ(report["exit_code"], 8);
  EXPECT_EQ(report["jobs"][0]["exit_code"], 3);
  EXPECT_THAT(report["jobs"][0]["error"].get<std::string>(), HasSubstr("bad.obj:2"));
  EXPECT_EQ(report["jobs"][1]["exit_code"], 0);
}

TEST_F(ManyFiles, TheTableTellsTheBadOnes) {
  write("a_name_that_is_longer_than_a_table_has_room_for.obj", cube_obj() + "v 9 9 9\n");
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("part.obj", cube_obj() + "t crease 2/1/0 0 1 10.0\nt crease 2/1/0 1 2 10.0\n");
  const ProcessResult result = fit({"a_name_that_is_longer_than_a_table_has_room_for.obj",
                                    "bad.obj", "part.obj", "scans/", "-o", "out/"});
  EXPECT_THAT(
      result.err,
      AllOf(testing::ContainsRegex("name +vertices +method +creases +joined +normals +folded "
                                   "+warnings +time\n"),
            testing::ContainsRegex("\na_name_that_is_longer\\.\\.\\. +9 +[a-z]+ +12 +0 +[0-9.]+ "
                                   "+[0-9.]+ % +1 +[0-9.]+ m?s\n"),
            testing::ContainsRegex("\nbad +- +failed +- "),
            testing::ContainsRegex("\npart +8 +[a-z]+ +2 +0 +[0-9.]+ +[0-9.]+ % +0 ")));
  std::istringstream lines(result.err);
  for (std::string line; std::getline(lines, line);) {
    const bool is_message = line.starts_with("planish: ");
    EXPECT_TRUE(is_message || line.size() <= 100) << line;
  }
}

TEST_F(ManyFiles, WarningsSayOfWhichTheyAre) {
  const std::string soft = cube_obj() + "t crease 2/1/0 0 1 2.0\n";
  write("soft.obj", soft);
  write("loose.obj", cube_obj() + "v 9 9 9\n");
  const ProcessResult result = fit({"soft.obj", "loose.obj", "-o", "out/"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err,
              testing::ContainsRegex("warning: [^ ]*soft.obj: creases of a sharpness below 10"));
  EXPECT_THAT(result.err, HasSubstr("warning: loose.obj: 1 of 9 vertices"));
}

TEST_F(ManyFiles, AreTheSameBytesForAnyNumberAtOnce) {
  ASSERT_EQ(fit({"cube.obj", "scans", "-o", "one/", "-j", "1"}).exit_code, 0);
  ASSERT_EQ(fit({"cube.obj", "scans", "-o", "four/", "-j", "4"}).exit_code, 0);
  for (const std::string& name : names_in("one"))
    EXPECT_EQ(read("one/" + name), read("four/" + name)) << name;
}

TEST_F(ManyFiles, OfOneStemAreRefusedBeforeWork) {
  write("b/cube.obj", cube_obj());
  const ProcessResult result = fit({"cube.obj", "b/cube.obj", "-o", "out/"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("cube.obj and b/cube.obj would be written under one name"));
  EXPECT_FALSE(exists("out"));
}

TEST_F(ManyFiles, DoNotGoIntoOneFileOrStdout) {
  const ProcessResult file = fit({"cube.obj", "scans", "-o", "x.glb"});
  EXPECT_EQ(file.exit_code, 2);
  EXPECT_THAT(file.err, HasSubstr("several inputs; name a folder: -o x/"));
  EXPECT_EQ(fit({"cube.obj", "scans", "-o", "-"}).exit_code, 2);
}

TEST_F(ManyFiles, FormatsOfFoldersAreChosen) {
  const ProcessResult result =
      fit({"scans", "-o", "out/", "--cage", "cages/", "--output-format", "ply", "-q"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names_in("out"), ElementsAre("plate.ply", "torus.ply"));
  EXPECT_THAT(names_in("cages"), ElementsAre("plate.ply", "torus.ply"));
  EXPECT_EQ(result.err, "");
}

TEST_F(ManyFiles, OneInputGoesIntoAFolderToo) {
  fs::create_directory(path("out"));
  EXPECT_EQ(fit({"cube.obj", "-o", "out"}).exit_code, 0);
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb"));
}

TEST_F(ManyFiles, ARunOfASceneHasOneReport) {
  write("s.json", R"({"version":1,"defaults":{"device":"cpu"},"jobs":[{"input":"cube.obj"},)"
                  R"({"input":"none.obj"}]})");
  const ProcessResult result = run_planish({"run", "s.json", "--json"},
                                           {.input = {}, .environment = {}, .folder = path("")});
  EXPECT_EQ(result.exit_code, 8);
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["jobs"][0]["job"], "cube");
  EXPECT_EQ(report["jobs"][1]["exit_code"], 3);
  const ProcessResult quiet = run_planish({"run", "s.json", "cube", "-q"},
                                          {.input = {}, .environment = {}, .folder = path("")});
  EXPECT_EQ(quiet.out, "");
}

}  // namespace
}  // namespace planish::test
