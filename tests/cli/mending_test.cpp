#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/job/job_input.h"
#include "planish/job/job_outputs.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::Not;

using nlohmann::json;

class Mending : public FolderTest {
 protected:
  // The report of a fit that writes no surface but this cage.
  json report(const std::string& flags) { return report_of("fit --cage cage.obj " + flags); }
};

// The cube's quads, each with corners of its own, a little apart from the others'.
std::string torn_cube_obj(double apart = 1e-5) {
  std::istringstream cube(cube_obj());
  std::ostringstream torn;
  std::vector<std::array<double, 3>> points;
  std::string word, faces;
  int count = 0;
  for (std::string line; std::getline(cube, line);) {
    std::istringstream words(line);
    words >> word;
    if (word == "v") {
      auto& point = points.emplace_back();
      words >> point[0] >> point[1] >> point[2];
    } else if (word == "f") {
      faces += "f";
      for (int v = 0; words >> v;) {
        const auto& point = points[v - 1];
        torn << "v " << point[0] + apart * (count % 3) << " " << point[1] - apart * (count % 5)
             << " " << point[2] << "\n";
        faces += " " + std::to_string(++count);
      }
      faces += "\n";
    }
  }
  return torn.str() + faces;
}

TEST_F(Mending, WeldsATornMeshWhereAsked) {
  write("torn.obj", torn_cube_obj());
  const json torn = report("torn.obj");
  expect_values(torn, {{"/input/components", 6}, {"/input/welded", 0}, {"/solve/weld", nullptr}});
  const json welded = report("torn.obj --weld 1e-3");
  expect_values(welded, {{"/input/components", 1},
                         {"/input/boundary_loops", 0},
                         {"/input/file_vertices", 24},
                         {"/input/vertices", 8},
                         {"/input/welded", 16},
                         {"/solve/weld", 1e-3}});
  EXPECT_THAT(said_, HasSubstr("16 vertices"));
  // The cage says how.
  run("verify cage.obj torn.obj");
  run("verify cage.obj torn.obj --weld 0", 4);
  EXPECT_EQ(report("torn.obj --weld 1e-3 --interpolation fair")["input"]["welded"], 16);
  run("verify cage.obj torn.obj");
}

TEST_F(Mending, PartsThatAreInsideOutAreTold) {
  write("cube.obj", cube_obj());
  EXPECT_TRUE(report("cube.obj")["warnings"].empty());
  std::string turned;
  for (const std::string& line : lines_of(cube_obj())) {
    std::vector<std::string> words = words_of(line);
    if (words[0] == "f") std::reverse(words.begin() + 1, words.end());
    for (const std::string& word : words) turned += word + " ";
    turned += "\n";
  }
  write("turned.obj", turned);
  const json warnings = report("turned.obj")["warnings"];
  ASSERT_EQ(warnings.size(), 1u);
  expect_values(warnings, {{"/0/code", "inside-out"}, {"/0/first", 0}});
  EXPECT_THAT(said_, HasSubstr("turned.obj: closed parts whose faces look inward: 1, first at face "
                               "0; renderers that draw front faces alone show them from inside; "
                               "turn the faces over"));
}

TEST_F(Mending, TornVerticesAreTold) {
  write("torn.obj", torn_cube_obj(0));
  const std::string wanted =
      "16 vertices at open edges lie exactly where another one does; --weld 0 makes them one";
  const json warnings = report("torn.obj")["warnings"];
  EXPECT_THAT(said_, HasSubstr("torn.obj: " + wanted));
  ASSERT_EQ(warnings.size(), 1u);
  expect_values(warnings, {{"/0/code", "torn-vertices"}, {"/0/count", 16}});
  EXPECT_THAT(run("inspect torn.obj").out, HasSubstr(wanted));
  EXPECT_EQ(printed("inspect torn.obj --json")["torn_vertices"], 16);
  const json welded = report("torn.obj --weld 0");
  EXPECT_EQ(welded["input"]["boundary_loops"], 0);
  EXPECT_TRUE(welded["warnings"].empty());
  // Nearly there: what a file's rounded numbers leave of one place.
  write("near.obj", torn_cube_obj(2e-6));
  EXPECT_EQ(report("near.obj")["warnings"][0]["count"], 16);
  EXPECT_THAT(said_, HasSubstr("16 vertices at open edges lie within 1e-05 of the diagonal of "
                               "another one; --weld 1e-05 makes them one"));
  const json near = report("near.obj --weld 1e-05");
  EXPECT_EQ(near["input"]["components"], 1);
  EXPECT_TRUE(near["warnings"].empty());
  // Those of other meshes are not: farther apart, or sheets that meet at a vertex.
  write("apart.obj", torn_cube_obj(1e-3));
  write("tips.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n"
        "f 1 2 3 4\nf 5 6 7 8\n");
  for (const char* input : {"apart.obj", "tips.obj"}) {
    EXPECT_TRUE(report(input)["warnings"].empty()) << input;
    EXPECT_THAT(said_, Not(HasSubstr("--weld")));
  }
  EXPECT_THAT(run("inspect tips.obj").out, Not(HasSubstr("torn")));
}

TEST_F(Mending, WeldsEveryFormat) {
  write("torn.obj", torn_cube_obj());
  for (const std::string name : {"torn.ply", "torn.off", "torn.stl", "torn.glb"}) {
    run("fit torn.obj --levels 0 -o " + name);
    const json input = report(name + " --weld 1e-3")["input"];
    EXPECT_EQ(input["vertices"], 8) << name;
    EXPECT_EQ(input["components"], 1) << name;
    EXPECT_GE(input["welded"], 16) << name;
  }
}

// Three bumpy strips at one bent line; `apart`: each with vertices of its own there, so far off.
std::string sheets_obj(double apart) {
  std::ostringstream text;
  std::string faces;
  int count = 0;
  const auto vertex = [&](double x, double y, double z) {
    text << "v " << x << " " << y << " " << z << "\n";
    return ++count;
  };
  constexpr int kCells = 4;
  std::vector<int> line;
  for (int sheet = 0; sheet < 3; ++sheet) {
    const double angle = 2.1 * sheet;
    if (sheet == 0 || apart > 0) {
      line.clear();
      for (int i = 0; i <= kCells; ++i)
        line.push_back(vertex(i, apart * sheet, 0.3 * std::sin(1.3 * i)));
    }
    std::vector<int> rim;
    for (int i = 0; i <= kCells; ++i) {
      const double width = 0.4 + 0.3 * sheet + 0.1 * (i % 3);
      rim.push_back(vertex(i + 0.1, width * std::cos(angle),
                           0.3 * std::sin(1.3 * i) + width * std::sin(angle)));
    }
    for (int i = 0; i < kCells; ++i)
      for (const int v : {line[i], line[i + 1], rim[i + 1], rim[i]})
        faces += (v == line[i] ? "f " : " ") + std::to_string(v) + (v == rim[i] ? "\n" : "");
  }
  return text.str() + faces;
}

TEST_F(Mending, SaysHowFarSeparatedSheetsAreApart) {
  write("sheets.obj", sheets_obj(0));
  for (const std::string flags :
       {"", " --interpolation fair", " --creases ignore", " --creases auto --interpolation fair"}) {
    const json fitted = report("sheets.obj" + flags);
    EXPECT_EQ(fitted["input"]["separated_edges"], 4);
    ASSERT_TRUE(fitted["surface"]["sheet_gap"].is_number());
    EXPECT_LT(fitted["surface"]["sheet_gap"], 1e-6);
    EXPECT_THAT(said_, HasSubstr("sheets      separated along 4 edges"));
    run("verify cage.obj sheets.obj");
  }
  write("apart.obj", sheets_obj(1e-7));
  const json welded = report("apart.obj --weld 1e-5");
  expect_values(welded, {{"/input/welded", 10}, {"/input/separated_edges", 4}});
  EXPECT_LT(welded["surface"]["sheet_gap"], 1e-6);
}

// A part of the diagonal, whatever the unit: of two quads, said to be sheets of one edge, that lie
// apart.
TEST(SheetGapOfAJob, DoesNotGrowWithTheMesh) {
  for (const double unit : {1.0, 1000.0}) {
    FittedMesh fitted;
    PolygonMesh& mesh = fitted.mesh;
    mesh.positions = {{0, 0, 0},   {1, 0, 0},   {1, 1, 0},    {0, 1, 0},
                      {0, 0, 0.2}, {1, 0, 0.2}, {1, -1, 0.2}, {0, -1, 0.2}};
    for (glm::dvec3& position : mesh.positions) position *= unit;
    mesh.face_offsets = {0, 4, 8};
    mesh.face_vertices = {0, 1, 2, 3, 5, 4, 7, 6};
    for (std::int32_t v = 0; v < 8; ++v) mesh.corners.push_back({v});
    fitted.source_vertices = {0, 1, 2, 3, 0, 1, 4, 5};
    fitted.separated_edges = {{0, 1}};
    fitted.fit = fit(mesh, *make_cpu_backend(), {});
    JobReport report;
    report.surface.emplace();
    note_sheet_gap(fitted, fitted_surface(mesh, fitted.fit, {}), report);
    ASSERT_TRUE(report.surface->sheet_gap);
    EXPECT_NEAR(*report.surface->sheet_gap, 0.2 / std::sqrt(1 + 4 + 0.04), 1e-6) << unit;
  }
}

TEST_F(Mending, HasNoGapWhereNoSheetsMeet) {
  write("torus.obj", torus_obj(8));
  write("sheets.obj", sheets_obj(0));
  const json torus = report("torus.obj"), other = report("sheets.obj --scheme catmull-clark");
  expect_values(torus, {{"/input/separated_edges", 0}, {"/surface/sheet_gap", nullptr}});
  EXPECT_EQ(other["input"]["separated_edges"], 4);
  EXPECT_EQ(other["surface"]["sheet_gap"], nullptr) << "measured with doo-sabin only";
}

}  // namespace
}  // namespace planish::test
