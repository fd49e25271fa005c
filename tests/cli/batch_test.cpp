#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <glm/vec3.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;

class RunCommand : public FolderTest {
 protected:
  std::string scene(const std::string& jobs) {
    return write("scene.json",
                 R"({"version":1,"defaults":{"device":"cpu"},"jobs":[)" + jobs + "]}");
  }

  std::string torus_ = write("torus.obj", torus_obj(12));
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

constexpr const char* kTwoJobs =
    R"({"name":"ring","input":"torus.obj","interpolation":"progressive","outputs":[{"path":"out/ring.glb","levels":[1,2]}],
        "report":"out/ring.json"},
       {"name":"sheet","input":"plate.obj","solve":{"preset":"paper"}})";

TEST_F(RunCommand, PrintsATableAndWritesBesideTheScene) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs)});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(
      result.out,
      AllOf(
          ContainsRegex(
              "name +points +vertices +solver +weights +iterations +error +fit ms +all ms\n"),
          ContainsRegex(
              "\nring +- +144 +chebyshev +doo-sabin +[0-9]+ +[-.0-9e]+ +[.0-9]+ +[.0-9]+\n"),
          ContainsRegex("\nsheet +- +49 +plain +averaged +[0-9]+ +[-.0-9e]+ +[.0-9]+ +[.0-9]+\n")));
  EXPECT_TRUE(exists("out/ring_LOD0.glb"));
  EXPECT_TRUE(exists("out/ring_LOD1.glb"));
  EXPECT_EQ(read_json("out/ring.json")["job"], "ring");
}

TEST_F(RunCommand, RunsTheJobsThatAreNamed) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs), "sheet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("\nsheet "), testing::Not(HasSubstr("\nring "))));
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(run_planish({"run", scene(kTwoJobs), "shete"}).exit_code, 2);
}

TEST_F(RunCommand, AFailedJobDoesNotStopTheOthersAndExitsEight) {
  const ProcessResult result = run_planish(
      {"run", scene(R"({"name":"gone","input":"gone.obj"},{"name":"ring","input":"torus.obj"})")});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(result.out,
              AllOf(ContainsRegex("\ngone +- .*failed"), ContainsRegex("\nring +- +144 ")));
  EXPECT_THAT(result.err, AllOf(HasSubstr("gone: "), HasSubstr("1 of 2 jobs failed")));
}

TEST_F(RunCommand, AJobThatDoesNotConvergeCountsAsFailed) {
  const ProcessResult result = run_planish(
      {"run", scene(R"({"input":"plate.obj","max_iterations":1,"interpolation":"progressive"})")});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(result.out, HasSubstr("(not converged)"));
}

TEST_F(RunCommand, SceneErrorsExitTwo) {
  const ProcessResult result = run_planish({"run", scene(R"({"inptu":"torus.obj"})")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("did you mean input?"));
  EXPECT_EQ(run_planish({"run", path("none.json")}).exit_code, 2);
}

TEST_F(RunCommand, OutputsAreCheckedBeforeAnyJobStarts) {
  const std::string file = scene(
      R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
         {"input":"plate.obj","outputs":[{"path":"plate.obj"}]})");
  const ProcessResult result = run_planish({"run", file, "--force"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("jobs[1].outputs[0]"));
  EXPECT_FALSE(exists("a.glb"));
  EXPECT_EQ(read("plate.obj"), bumpy_plate_obj(6));
}

TEST_F(RunCommand, TwoJobsCannotWriteOneFile) {
  const std::string file = scene(
      R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
         {"input":"plate.obj","outputs":[{"path":"./a.glb"}]})");
  EXPECT_EQ(run_planish({"run", file}).exit_code, 2);
}

TEST_F(RunCommand, ADryRunWritesNothing) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs), "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("ring_LOD1.glb"));
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_FALSE(exists("out"));
}

// An OBJ with some vertices elsewhere.
std::string moved_obj(const std::string& obj, const std::vector<std::pair<int, glm::dvec3>>& ways) {
  std::istringstream lines(obj);
  std::string line, text;
  for (int vertex = 0; std::getline(lines, line);) {
    if (!line.starts_with("v ")) {
      text += line + "\n";
      continue;
    }
    glm::dvec3 p;
    std::istringstream(line.substr(2)) >> p.x >> p.y >> p.z;
    for (const auto& [moved, way] : ways)
      if (moved == vertex) p += way;
    std::ostringstream out;
    out.precision(17);
    out << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    text += out.str();
    ++vertex;
  }
  return text;
}

// `planish verify`, which knows nothing of moves, finds the cage's surface through the moved mesh.
TEST_F(RunCommand, MovesVerticesAfterTheFit) {
  write("expected.obj", moved_obj(torus_obj(12), {{7, {0, 0, 0.05}}, {40, {0.03, 0, 0}}}));
  for (const std::string method : {"progressive", "fair"}) {
    const ProcessResult result = run_planish(
        {"run",
         scene(R"({"input":"torus.obj","report":"r.json","creases":"use","interpolation":")" +
               method +
               R"(","outputs":[{"path":"cage.obj","what":"cage"},{"path":"a.ply"}],
            "moves":[{"vertices":[7],"by":[0,0,0.05]},{"vertices":[3,9],"by":[1,0,0],"radius":1},
                     {"vertices":[40],"matrix":[[1,0,0,0.03],[0,1,0,0],[0,0,1,0]]},
                     {"vertices":[90],"to":[[0,0,5]]},{"undo":1},{"undo":2},
                     {"vertices":[40],"by":[0.03,0,0]}]})"),
         "--force"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json report = read_json("r.json");
    EXPECT_EQ(report["moved"]["moves"], 7);
    EXPECT_EQ(report["moved"]["vertices"], 2);
    EXPECT_GT(report["moved"]["farthest"], 0.01);
    EXPECT_LE(report["outputs"][1]["as_written_error"], 2e-6);
    EXPECT_EQ(report["solve"]["converged"], true);
    const auto verify = [&](const std::string& mesh) {
      return run_planish(
          {"verify", path("cage.obj"), mesh, "--interpolation", method, "--creases", "use"});
    };
    const ProcessResult verified = verify(path("expected.obj"));
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    EXPECT_EQ(verify(torus_).exit_code, 5);
  }
}

TEST_F(RunCommand, MovesThatCannotBeAreNamedByTheirPlace) {
  const auto message = [&](const std::string& job) {
    const ProcessResult result = run_planish({"run", scene(job)});
    EXPECT_EQ(result.exit_code, 8);
    return result.err;
  };
  EXPECT_THAT(message(R"({"input":"torus.obj","moves":[{"vertices":[3],"by":[0,0,1]},
                          {"vertices":[144],"by":[0,0,1]}]})"),
              HasSubstr("jobs[0].moves[1]: there is no vertex 144; the mesh has 0 to 143"));
  EXPECT_THAT(message(R"({"input":"torus.obj","moves":[{"undo":1}]})"),
              HasSubstr("jobs[0].moves[0]: there are no 1 moves to take back"));
  EXPECT_THAT(message(R"({"input":"torus.obj","scheme":"catmull-clark",
                          "moves":[{"vertices":[3],"by":[0,0,1]}]})"),
              HasSubstr("jobs[0].moves[0]: "));
  EXPECT_THAT(message(R"({"input":"torus.obj","moves":[{"vertices":[3],"by":[0,1e300,0]}]})"),
              HasSubstr("jobs[0].moves[0]: move 0: "));
}

// Vertices are the file's; where sheets were separated, all that it became move.
TEST_F(RunCommand, MovesNameVerticesOfTheFile) {
  std::string two_cubes = cube_obj();
  std::istringstream lines(cube_obj());
  std::string faces;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(1));
    if (line.starts_with("v ")) {
      glm::dvec3 p;
      words >> p.x >> p.y >> p.z;
      if (p == glm::dvec3(0)) continue;  // the corner that both share: vertex 1
      two_cubes += "v " + std::to_string(-p.x) + " " + std::to_string(-p.y) + " " +
                   std::to_string(p.z == 0 ? 0 : -p.z) + "\n";
    } else if (line.starts_with("f ")) {
      std::string turned;
      for (int v = 0; words >> v;)
        turned = " " + std::to_string(v == 1 ? 1 : v + 7) + turned;  // mirrored: the other way
      faces += "f" + turned + "\n";
    }
  }
  write("two.obj", two_cubes + faces);
  const ProcessResult result = run_planish(
      {"run", scene(R"({"input":"two.obj","report":"r.json","interpolation":"progressive",
                        "moves":[{"vertices":[0],"by":[0.1,0.1,0.1]}]})")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json("r.json")["moved"]["vertices"], 2);
}

// fit of several inputs: files and folders in, a folder of surfaces out.
using testing::ElementsAre;

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
