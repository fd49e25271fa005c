#include <gmock/gmock.h>

#include <filesystem>
#include <glm/vec3.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class RunCommand : public FolderTest {
 protected:
  void write_scene(const std::string& jobs) {
    write("scene.json", R"({"version":1,"jobs":[)" + jobs + "]}");
  }

  std::string torus_ = write("torus.obj", torus_obj(12));
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

constexpr const char* kTwoJobs =
    R"({"name":"ring","input":"torus.obj","interpolation":"progressive","outputs":[{"path":"out/ring.glb","levels":[1,2]}],
        "report":"out/ring.json"},
       {"name":"sheet","input":"plate.obj","solve":{"preset":"paper"}})";

TEST_F(RunCommand, PrintsATableAndWritesBesideTheScene) {
  write_scene(kTwoJobs);
  EXPECT_THAT(run("run scene.json --dry-run").out, HasSubstr("ring_LOD1.glb"));
  EXPECT_EQ(said_, "");
  EXPECT_FALSE(exists("out"));
  EXPECT_THAT(
      run("run scene.json").out,
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
  write_scene(kTwoJobs);
  EXPECT_THAT(run("run scene.json sheet").out,
              AllOf(HasSubstr("\nsheet "), testing::Not(HasSubstr("\nring "))));
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(run("run scene.json sheet -q").out, "");
}

TEST_F(RunCommand, AFailedJobDoesNotStopTheOthersAndExitsEight) {
  write_scene(R"({"name":"gone","input":"gone.obj"},{"name":"ring","input":"torus.obj"},
                 {"input":"plate.obj","max_iterations":1,"interpolation":"progressive"})");
  EXPECT_THAT(run("run scene.json", 8).out,
              AllOf(ContainsRegex("\ngone +- .*failed"), ContainsRegex("\nring +- +144 "),
                    HasSubstr("(not converged)")));
  EXPECT_THAT(said_, AllOf(HasSubstr("gone: "), HasSubstr("2 of 3 jobs failed")));
  const json report = printed("run scene.json gone ring --json", 8);
  expect_values(report, {{"/jobs/0/exit_code", 3}, {"/jobs/1/job", "ring"}});
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
    write_scene(R"({"input":"torus.obj","report":"r.json","creases":"use","interpolation":")" +
                method + R"(","outputs":[{"path":"cage.obj","what":"cage"},{"path":"a.ply"}],
            "moves":[{"vertices":[7],"by":[0,0,0.05]},{"vertices":[3,9],"by":[1,0,0],"radius":1},
                     {"vertices":[40],"matrix":[[1,0,0,0.03],[0,1,0,0],[0,0,1,0]]},
                     {"vertices":[90],"to":[[0,0,5]]},{"undo":1},{"undo":2},
                     {"vertices":[40],"by":[0.03,0,0]}]})");
    run("run scene.json --force");
    const json report = read_json("r.json");
    expect_values(report, {{"/moved/moves", 7}, {"/moved/vertices", 2}});
    EXPECT_GT(report["moved"]["farthest"], 0.01);
    EXPECT_LE(report["outputs"][1]["as_written_error"], 2e-6);
    EXPECT_EQ(report["solve"]["converged"], true);
    const std::string verify = "verify --creases use --interpolation " + method + " cage.obj ";
    run(verify + "expected.obj");
    run(verify + "torus.obj", 5);
  }
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
  write_scene(R"({"input":"two.obj","report":"r.json","interpolation":"progressive",
                  "moves":[{"vertices":[0],"by":[0.1,0.1,0.1]}]})");
  run("run scene.json");
  EXPECT_EQ(read_json("r.json")["moved"]["vertices"], 2);
}

// fit of several inputs: files and folders in, a folder of surfaces out.

class ManyFiles : public FolderTest {
 protected:
  void SetUp() override {
    write("cube.obj", cube_obj());
    write("scans/plate.obj", bumpy_plate_obj(4));
    write("scans/tetra.off",
          "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
    write("scans/notes.txt", "not a mesh");
  }
  [[nodiscard]] std::vector<std::string> names_in(const std::string& folder) const {
    std::vector<std::string> result;
    for (const auto& [name, bytes] : files_below(path(folder))) result.push_back(name);
    return result;
  }
};

TEST_F(ManyFiles, GoIntoAFolderUnderTheirNames) {
  run("fit cube.obj scans/ -o out/ --report all.json");
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb", "plate.glb", "tetra.glb"));
  EXPECT_THAT(said_, AllOf(HasSubstr("name "), HasSubstr("cube "), HasSubstr("plate ")));
  const json report = read_json("all.json");
  EXPECT_EQ(report["schema"], "planish.batch/1");
  ASSERT_EQ(report["jobs"].size(), 3u);
  expect_values(report, {{"/jobs/1/input/path", "scans/plate.obj"},
                         {"/jobs/1/outputs/0/path", "out/plate.glb"}});
}

TEST_F(ManyFiles, OneThatFailsDoesNotStopTheOthers) {
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  run("fit bad.obj cube.obj -o out --report all.json -j 2", 8);
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb"));
  EXPECT_THAT(said_, AllOf(HasSubstr("error: bad.obj:2: "), HasSubstr("1 of 2 jobs failed")));
  const json report = read_json("all.json");
  expect_values(report, {{"/exit_code", 8}, {"/jobs/0/exit_code", 3}});
  EXPECT_THAT(report["jobs"][0]["error"].get<std::string>(), HasSubstr("bad.obj:2"));
  EXPECT_EQ(report["jobs"][1]["exit_code"], 0);
  EXPECT_THAT(report_problems(report, "batch"), IsEmpty());
  EXPECT_EQ(report["worst_first"], json({"bad", "cube"}));
  run("fit cube.obj bad.obj -o out --report all.json -f", 8);
  EXPECT_EQ(read_json("all.json")["worst_first"], json({"bad", "cube"}));
}

TEST_F(ManyFiles, TheTableTellsTheBadOnes) {
  write("a_name_that_is_longer_than_a_table_has_room_for.obj", cube_obj() + "v 9 9 9\n");
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("part.obj", cube_obj() + "t crease 2/1/0 0 1 10.0\nt crease 2/1/0 1 2 10.0\n");
  write("odd.obj", cube_obj() + "v 7 7 7\nv 8 8 8\n");
  run("fit a_name_that_is_longer_than_a_table_has_room_for.obj bad.obj part.obj odd.obj scans/ "
      "-o out/",
      8);
  EXPECT_THAT(said_,
              AllOf(ContainsRegex("name +vertices +method +creases +joined +normals +folded "
                                  "+warnings +time\n"),
                    ContainsRegex("\na_name_that_is_longer\\.\\.\\. +9 +[a-z]+ +12 +0 +[0-9.]+ "
                                  "+[0-9.]+ % +1 +[0-9.]+ m?s\n"),
                    ContainsRegex("\nbad +- +failed +- "),
                    ContainsRegex("\npart +8 +[a-z]+ +2 +0 +[0-9.]+ +[0-9.]+ % +0 ")));
  // Warnings say of which they are.
  EXPECT_THAT(said_, ContainsRegex("warning: [^ ]*odd.obj: 2 of 10 vertices"));
  EXPECT_THAT(said_, ContainsRegex("warning: a_name[^ ]*.obj: 1 of 9 vertices"));
  for (const std::string& line : lines_of(said_))
    EXPECT_TRUE(line.starts_with("planish: ") || line.size() <= 100) << line;
}

TEST_F(ManyFiles, AreTheSameBytesForAnyNumberAtOnce) {
  run("fit cube.obj scans -o one/ -j 1");
  run("fit cube.obj scans -o four/ -j 4");
  EXPECT_EQ(files_below(path("one")), files_below(path("four")));
}

TEST_F(ManyFiles, FormatsOfFoldersAreChosen) {
  run("fit scans -o out/ --cage cages/ --output-format ply -q");
  EXPECT_THAT(names_in("out"), ElementsAre("plate.ply", "tetra.ply"));
  EXPECT_THAT(names_in("cages"), ElementsAre("plate.ply", "tetra.ply"));
  EXPECT_EQ(said_, "");
}

TEST_F(ManyFiles, OneInputGoesIntoAFolderToo) {
  std::filesystem::create_directory(path("out"));
  run("fit cube.obj -o out");
  EXPECT_THAT(names_in("out"), ElementsAre("cube.glb"));
}

}  // namespace
}  // namespace planish::test
