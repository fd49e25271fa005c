#include <gmock/gmock.h>

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

class Mending : public FolderTest {
 protected:
  // What a fit that writes no surface but this cage says.
  nlohmann::json report_of(const std::string& input, std::vector<std::string> flags) {
    std::vector<std::string> arguments{"fit", input,      "--cage",      path("cage.obj"),
                                       "-f",  "--report", path("r.json")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProcessResult result = run_planish(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    summary_ = result.err;
    return read_json("r.json");
  }

  std::string summary_;
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
  const std::string torn = write("torn.obj", torn_cube_obj());
  nlohmann::json report = report_of(torn, {});
  EXPECT_EQ(report["input"]["components"], 6);
  EXPECT_EQ(report["input"]["welded"], 0);
  EXPECT_EQ(report["solve"]["weld"], nullptr);
  report = report_of(torn, {"--weld", "1e-3"});
  EXPECT_EQ(report["input"]["components"], 1);
  EXPECT_EQ(report["input"]["boundary_loops"], 0);
  EXPECT_EQ(report["input"]["file_vertices"], 24);
  EXPECT_EQ(report["input"]["vertices"], 8);
  EXPECT_EQ(report["input"]["welded"], 16);
  EXPECT_EQ(report["solve"]["weld"], 1e-3);
  EXPECT_THAT(summary_, HasSubstr("16 vertices"));
  // The cage says how.
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), torn}).exit_code, 0);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), torn, "--weld", "0"}).exit_code, 4);
  report = report_of(torn, {"--weld", "1e-3", "--interpolation", "fair"});
  EXPECT_EQ(report["input"]["welded"], 16);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), torn}).exit_code, 0);
}

TEST_F(Mending, PartsThatAreInsideOutAreTold) {
  const auto cube = [&](bool is_turned) {
    std::string text;
    for (int i = 0; i < 8; ++i) {
      for (int k = 0; k < 3; ++k)
        text += k == 0 ? "v " : " ", text += (i >> k & 1) != 0 ? "1" : "0";
      text += "\n";
    }
    for (std::vector<int> face : {std::vector{1, 3, 4, 2},
                                  {5, 6, 8, 7},
                                  {1, 2, 6, 5},
                                  {3, 7, 8, 4},
                                  {1, 5, 7, 3},
                                  {2, 4, 8, 6}}) {
      if (is_turned) std::ranges::reverse(face);
      text += "f";
      for (const int v : face) text += " " + std::to_string(v);
      text += "\n";
    }
    return text;
  };
  EXPECT_TRUE(report_of(write("cube.obj", cube(false)), {})["warnings"].empty());
  const std::string turned = write("turned.obj", cube(true));
  const nlohmann::json report = report_of(turned, {});
  ASSERT_EQ(report["warnings"].size(), 1u);
  EXPECT_EQ(report["warnings"][0]["code"], "inside-out");
  EXPECT_EQ(report["warnings"][0]["first"], 0);
  EXPECT_THAT(summary_, HasSubstr(turned + ": closed parts whose faces look inward: 1, first at "
                                           "face 0; renderers that draw front faces alone show "
                                           "them from inside; turn the faces over"));
}

TEST_F(Mending, TornVerticesAreTold) {
  const std::string torn = write("torn.obj", torn_cube_obj(0));
  const std::string wanted =
      "16 vertices at open edges lie exactly where another one does; --weld 0 makes them one";
  nlohmann::json report = report_of(torn, {});
  EXPECT_THAT(summary_, HasSubstr(torn + ": " + wanted));
  ASSERT_EQ(report["warnings"].size(), 1u);
  EXPECT_EQ(report["warnings"][0]["code"], "torn-vertices");
  EXPECT_EQ(report["warnings"][0]["count"], 16);
  EXPECT_THAT(run_planish({"inspect", torn}).out, HasSubstr(wanted));
  EXPECT_EQ(nlohmann::json::parse(run_planish({"inspect", torn, "--json"}).out)["torn_vertices"],
            16);
  report = report_of(torn, {"--weld", "0"});
  EXPECT_EQ(report["input"]["boundary_loops"], 0);
  EXPECT_TRUE(report["warnings"].empty());
  // Nearly there: what a file's rounded numbers leave of one place.
  const std::string near = write("near.obj", torn_cube_obj(2e-6));
  report = report_of(near, {});
  EXPECT_THAT(summary_, HasSubstr("16 vertices at open edges lie within 1e-05 of the diagonal of "
                                  "another one; --weld 1e-05 makes them one"));
  EXPECT_EQ(report["warnings"][0]["count"], 16);
  report = report_of(near, {"--weld", "1e-05"});
  EXPECT_EQ(report["input"]["components"], 1);
  EXPECT_TRUE(report["warnings"].empty());
  // Those of other meshes are not: farther apart, or sheets that meet at a vertex.
  EXPECT_TRUE(report_of(write("apart.obj", torn_cube_obj(1e-3)), {})["warnings"].empty());
  EXPECT_THAT(summary_, Not(HasSubstr("--weld")));
  const std::string tips = write("tips.obj",
                                 "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
                                 "v 2 2 0\nv 1 2 0\nf 1 2 3 4\nf 5 6 7 8\n");
  EXPECT_TRUE(report_of(tips, {})["warnings"].empty());
  EXPECT_THAT(run_planish({"inspect", tips}).out, Not(HasSubstr("torn")));
}

TEST_F(Mending, WeldsEveryFormatAndSceneFilesToo) {
  const std::string torn = write("torn.obj", torn_cube_obj());
  for (const char* name : {"torn.ply", "torn.off", "torn.stl", "torn.glb"}) {
    ASSERT_EQ(run_planish({"fit", torn, "-o", path(name), "--levels", "0"}).exit_code, 0);
    const nlohmann::json report = report_of(path(name), {"--weld", "1e-3"});
    EXPECT_EQ(report["input"]["vertices"], 8) << name;
    EXPECT_EQ(report["input"]["components"], 1) << name;
    EXPECT_GE(report["input"]["welded"], 16) << name;
  }
  write("scene.json", R"({"version":1,"defaults":{"weld":0.001},"jobs":[
      {"input":"torn.obj","outputs":[{"path":"out.obj"}],"report":"s.json"}]})");
  ASSERT_EQ(run_planish({"run", path("scene.json")}).exit_code, 0);
  EXPECT_EQ(read_json("s.json")["input"]["welded"], 16);
}

TEST_F(Mending, RefusesOtherReaches) {
  const std::string cube = write("cube.obj", cube_obj());
  for (const char* value : {"-1e-6", "nan", "0.1", "1e-13", "inf", "little"}) {
    const ProcessResult result =
        run_planish({"fit", cube, "-o", path("out.glb"), "--weld=" + std::string(value)});
    EXPECT_EQ(result.exit_code, 2) << value;
    EXPECT_THAT(result.err, HasSubstr("--weld: ")) << value;
  }
  for (const char* value : {"-1e-6", "0.1", "\"little\"", "null"}) {
    write("scene.json", R"({"version":1,"jobs":[{"input":"cube.obj","solve":{"weld":)" +
                            std::string(value) + "}}]}");
    const ProcessResult result = run_planish({"run", path("scene.json")});
    EXPECT_EQ(result.exit_code, 2) << value;
    EXPECT_THAT(result.err, HasSubstr("jobs[0].solve.weld: ")) << value;
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
  const std::string sheets = write("sheets.obj", sheets_obj(0));
  for (const std::vector<std::string>& flags : {std::vector<std::string>{},
                                                {"--interpolation", "fair"},
                                                {"--creases", "ignore"},
                                                {"--creases", "auto", "--interpolation", "fair"}}) {
    const nlohmann::json report = report_of(sheets, flags);
    EXPECT_EQ(report["input"]["separated_edges"], 4);
    ASSERT_TRUE(report["surface"]["sheet_gap"].is_number());
    EXPECT_LT(report["surface"]["sheet_gap"], 1e-6);
    EXPECT_THAT(summary_, HasSubstr("sheets      separated along 4 edges"));
    EXPECT_EQ(run_planish({"verify", path("cage.obj"), sheets}).exit_code, 0);
  }
  const nlohmann::json report = report_of(write("apart.obj", sheets_obj(1e-7)), {"--weld", "1e-5"});
  EXPECT_EQ(report["input"]["welded"], 10);
  EXPECT_EQ(report["input"]["separated_edges"], 4);
  EXPECT_LT(report["surface"]["sheet_gap"], 1e-6);
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
  const std::string torus = write("torus.obj", torus_obj(8));
  nlohmann::json report = report_of(torus, {});
  EXPECT_EQ(report["input"]["separated_edges"], 0);
  EXPECT_EQ(report["surface"]["sheet_gap"], nullptr);
  const std::string sheets = write("sheets.obj", sheets_obj(0));
  report = report_of(sheets, {"--scheme", "catmull-clark"});
  EXPECT_EQ(report["input"]["separated_edges"], 4);
  EXPECT_EQ(report["surface"]["sheet_gap"], nullptr) << "measured with doo-sabin only";
}

}  // namespace
}  // namespace planish::test
