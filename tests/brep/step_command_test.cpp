// STEP as the command and fit_file() write it.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <regex>

#include "brep/step_file.h"
#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/words.h"
#include "planish/job/fit_file.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class StepCommand : public FolderTest {
 protected:
  ProcessResult fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--device", "cpu", "-f"});
    if (std::ranges::find(flags, "--creases") == flags.end())
      flags.insert(flags.end(), {"--creases", "use"});
    // Tests of splines, though the shapes are those of analytic surfaces.
    const auto is_step = [](const std::string& flag) {
      return flag.ends_with(".step") || flag.ends_with(".STP");
    };
    if (std::ranges::any_of(flags, is_step) &&
        std::ranges::find(flags, "--step-analytic") == flags.end())
      flags.insert(flags.end(), {"--step-analytic", "off"});
    return run_planish(flags);
  }
  // Its entry of the report, which is valid.
  nlohmann::json reported(const std::string& input, std::vector<std::string> flags,
                          int exit_code = 0) {
    flags.insert(flags.end(), {"-o", path("p.step"), "--report", path("r.json")});
    const ProcessResult result = fit(input, flags);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    report_ = read_json("r.json");
    std::ifstream file(PLANISH_REPORT_SCHEMA);
    EXPECT_THAT(schema_problems(report_, nlohmann::json::parse(file)), IsEmpty());
    messages_ = result.err;
    return report_["outputs"][0];
  }
  [[nodiscard]] std::vector<std::string> warning_codes() const {
    std::vector<std::string> codes;
    for (const nlohmann::json& warning : report_["warnings"]) codes.push_back(warning["code"]);
    return codes;
  }
  [[nodiscard]] std::string description() const {
    const std::string text = read("p.step");
    const std::size_t begin = text.find("FILE_DESCRIPTION((") + 18;
    return text.substr(begin, text.find("),'2;1')", begin) - begin);
  }

  std::string cube_ = write("cube.obj", cube_obj());
  std::string torus_ = write("torus.obj", torus_obj(12));
  nlohmann::json report_;
  std::string messages_;
};

// A cylinder of 24 sides: named, with its radius, and as splines where they are asked for.
TEST_F(StepCommand, AnalyticFacesAreNamed) {
  std::string obj, below = "f", above = "f";
  constexpr int kSides = 24;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / kSides;
    const double x = 3 * std::cos(angle), y = 3 * std::sin(angle);
    const std::string at = "v " + std::to_string(x) + " " + std::to_string(y);
    obj += at + " 0\n" + at + " 5\n";
    const int next = (i + 1) % kSides;
    obj += formatted("f {} {} {} {}\n", 2 * i + 1, 2 * next + 1, 2 * next + 2, 2 * i + 2);
    above += formatted(" {}", 2 * i + 2);
    below += formatted(" {}", 2 * (kSides - i) - 1);
  }
  const std::string pillar = write("pillar.obj", obj + above + "\n" + below + "\n");
  const nlohmann::json step =
      reported(pillar, {"--step-analytic", "auto", "--creases", "auto"})["step"];
  EXPECT_EQ(step["faces"], 3);
  EXPECT_EQ(step["planes"], 2);
  EXPECT_EQ(step["analytic"]["faces"]["cylinder"], 1);
  EXPECT_EQ(step["analytic"]["freeform_parts"], 0);
  ASSERT_EQ(step["analytic"]["radii"].size(), 1u);
  EXPECT_NEAR(step["analytic"]["radii"][0], 3, 1e-5);
  EXPECT_EQ(step["valid"], true);
  EXPECT_THAT(messages_, HasSubstr("3 faces (2 planes, 1 cylinder), 1 solid"));
  EXPECT_THAT(read("p.step"), HasSubstr("CYLINDRICAL_SURFACE('',"));
  const nlohmann::json splines = reported(pillar, {"--creases", "auto"})["step"];
  EXPECT_EQ(splines["analytic"], nullptr);
  EXPECT_GT(splines["faces"], 3);
  EXPECT_THAT(read("p.step"), Not(HasSubstr("CYLINDRICAL_SURFACE")));
  // A freeform part says why it is.
  const nlohmann::json freeform = reported(cube_, {"--step-analytic", "auto"})["step"];
  EXPECT_EQ(freeform["analytic"]["freeform_parts"], 1);
  EXPECT_FALSE(freeform["analytic"]["freeform_reason"].get<std::string>().empty());
}

TEST_F(StepCommand, WritesAFileAndReportsIt) {
  const nlohmann::json output = reported(cube_, {});
  const StepFile file(path("p.step"));
  const auto count = [&](const char* keyword) { return std::ssize(file.all(keyword)); };
  const nlohmann::json& step = output["step"];
  EXPECT_EQ(step["unit"], "mm");
  EXPECT_EQ(step["faces"], count("ADVANCED_FACE"));
  EXPECT_EQ(step["faces"], 6);
  EXPECT_EQ(step["edges"], count("EDGE_CURVE"));
  EXPECT_EQ(step["vertices"], 8);
  EXPECT_EQ(step["solids"], 1);
  EXPECT_EQ(step["open_shells"], 0);
  EXPECT_EQ(step["extraordinary"], 8);
  EXPECT_GT(step["deepest"], 1);
  EXPECT_GT(step["max_angle"], 0.01);
  EXPECT_LE(step["max_angle"], 0.25);
  EXPECT_EQ(step["keeps_limits"], true);
  std::int64_t points = 0;
  for (const std::int64_t id : file.all("B_SPLINE_SURFACE_WITH_KNOTS"))
    points += std::ssize(file.surface(id).rows) * std::ssize(file.surface(id).rows[0]);
  EXPECT_EQ(step["control_points"], points);
  EXPECT_EQ(output["level"], nullptr);
  EXPECT_EQ(output["bytes"], read("p.step").size());
  EXPECT_LT(output["as_written_error"], 1e-6);
  EXPECT_GT(output["as_written_error"], 0);
  EXPECT_THAT(messages_, AllOf(HasSubstr("6 B-spline faces, 1 solid, "), HasSubstr("in mm")));
  EXPECT_EQ(description(), "''");
  EXPECT_THAT(read("p.step"), HasSubstr("PRODUCT('cube','cube'"));
  // The given vertices lie on it.
  double farthest = 0;
  for (const glm::dvec3& corner : {glm::dvec3(0, 0, 0), glm::dvec3(1, 1, 1), glm::dvec3(1, 0, 1)}) {
    double nearest = 1;
    for (const std::int64_t id : file.all("VERTEX_POINT"))
      nearest = std::min(nearest, glm::length(file.point(file.at(id).values[1]) - corner));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 1e-5);
  ASSERT_EQ(fit(cube_, {"-o", path("q.STP")}).exit_code, 0);
  EXPECT_TRUE(read("q.STP") == read("p.step"));
}

TEST_F(StepCommand, OpenSheetsAreShellsAndOtherFilesStandBeside) {
  const std::string plate = write("plate.obj", bumpy_plate_obj(5));
  const nlohmann::json output = reported(plate, {"-o", path("s.glb"), "--levels", "2,1"});
  EXPECT_EQ(output["path"], path("s.glb").insert(path("s.glb").size() - 4, "_LOD0"));
  const nlohmann::json& step = report_["outputs"].back()["step"];
  EXPECT_EQ(step["solids"], 0);
  EXPECT_EQ(step["open_shells"], 1);
  EXPECT_THAT(names(), ElementsAre("cube.obj", "p.step", "plate.obj", "r.json", "s_LOD0.glb",
                                   "s_LOD1.glb", "torus.obj"));
}

TEST_F(StepCommand, UnitsLeaveCoordinatesAsTheyAre) {
  const auto points = [&] {
    std::string all;
    const std::string text = read("p.step");
    static const std::regex line("VERTEX_POINT|CARTESIAN_POINT\\('',\\([^)]*\\)\\)");
    for (std::sregex_iterator i(text.begin(), text.end(), line), end; i != end; ++i)
      all += i->str() + "\n";
    return all;
  };
  EXPECT_EQ(reported(cube_, {})["step"]["unit"], "mm");
  const std::string in_mm = points();
  EXPECT_THAT(read("p.step"), HasSubstr("SI_UNIT(.MILLI.,.METRE.)"));
  for (const auto& [unit, entity] : std::vector<std::pair<std::string, std::string>>{
           {"cm", "SI_UNIT(.CENTI.,.METRE.)"},
           {"m", "SI_UNIT($,.METRE.)"},
           {"in", "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4)"}}) {
    EXPECT_EQ(reported(cube_, {"--step-unit", unit})["step"]["unit"], unit);
    EXPECT_THAT(read("p.step"), HasSubstr(entity));
    EXPECT_TRUE(points() == in_mm);
    EXPECT_THAT(messages_, HasSubstr("in " + unit));
  }
}

TEST_F(StepCommand, UnitsOfGltfAreMetres) {
  ASSERT_EQ(fit(cube_, {"-o", path("a.glb"), "--levels", "0"}).exit_code, 0);
  const std::string glb = path("a.glb");
  EXPECT_EQ(reported(glb, {})["step"]["unit"], "m");
  EXPECT_THAT(read("p.step"), HasSubstr("SI_UNIT($,.METRE.)"));
  EXPECT_THAT(messages_, HasSubstr("degrees at edges, in m\n"));
  (void)fit_file(glb, path("q.step"));
  EXPECT_THAT(read("q.step"), HasSubstr("SI_UNIT($,.METRE.)"));
  EXPECT_THAT(fit(glb, {"-o", path("r.step"), "--dry-run"}).out, HasSubstr("(faces, in m)"));
  EXPECT_EQ(reported(glb, {"--step-unit", "in"})["step"]["unit"], "in");
  EXPECT_EQ(reported(cube_, {"--step-unit", "auto"})["step"]["unit"], "mm");
}

TEST_F(StepCommand, LimitsAndSizesAreAsAskedFor) {
  const auto depth = [&](const char* angle, const char* tolerance) {
    return reported(cube_,
                    {"--step-angle", angle, "--step-tolerance", tolerance})["step"]["deepest"]
        .get<int>();
  };
  EXPECT_EQ(depth("90", "1"), 1);
  EXPECT_EQ(report_["outputs"][0]["step"]["keeps_limits"], true);
  EXPECT_EQ(report_["outputs"][0]["step"]["valid"], true);
  EXPECT_LE(report_["outputs"][0]["step"]["largest_gap"], 1e-9);
  EXPECT_GT(depth("0.25", "1"), 3);
  EXPECT_GT(depth("90", "1e-9"), 3);
  EXPECT_GT(reported(torus_, {"--step-face-size", "4"})["step"]["faces"],
            reported(torus_, {"--step-face-size", "8"})["step"]["faces"]);
  const StepFile file(path("p.step"));
  for (const std::int64_t id : file.all("B_SPLINE_SURFACE_WITH_KNOTS")) {
    const StepFile::Surface& surface = file.surface(id);
    EXPECT_LE(surface.u.high(), 8);
    EXPECT_LE(surface.v.high(), 8);
  }
}

TEST_F(StepCommand, LimitsThatAreNotKeptAreFlagged) {
  const nlohmann::json output = reported(cube_, {"--step-tolerance", "1e-30"}, 5);
  EXPECT_EQ(output["step"]["keeps_limits"], false);
  EXPECT_EQ(output["step"]["deepest"], 12);
  EXPECT_EQ(report_["exit_code"], 5);
  EXPECT_THAT(warning_codes(), Contains("step-limits"));
  EXPECT_THAT(messages_, AllOf(HasSubstr("p.step: faces leave the surface by up to "),
                               HasSubstr("above the 1e-30 asked for; the file says so")));
  EXPECT_THAT(description(), HasSubstr("faces leave the surface by up to"));
  // So is a fit that does not converge.
  reported(cube_, {"--interpolation", "progressive", "--max-iterations", "1"}, 5);
  EXPECT_THAT(description(), HasSubstr("not converged: vertices are off by up to "));
}

TEST_F(StepCommand, WarnsOfWhatCadProgramsFailOn) {
  const std::string scenes = PLANISH_SCENES;
  (void)reported(scenes + "/icosphere.obj", {"--step-angle", "90", "--step-tolerance", "1"});
  EXPECT_THAT(warning_codes(), ElementsAre("step-faces"));
  EXPECT_THAT(messages_, HasSubstr("faces, for which CAD programs take long"));
  (void)reported(scenes + "/mixed_polygons.obj",
                 {"--interpolation", "progressive", "--step-angle", "90", "--step-tolerance", "1"});
  EXPECT_THAT(warning_codes(), Contains("step-folds"));
  EXPECT_THAT(messages_, HasSubstr("% of the surface is folded, where its shell crosses itself"));
  // Small things are told by their unit.
  const std::string tiny = write("tiny.obj", [] {
    std::string text;
    for (const char* corner :
         {"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"})
      text += "v " + std::regex_replace(std::string(corner), std::regex("1"), "1e-3") + "\n";
    return text + "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  }());
  (void)reported(tiny, {});
  EXPECT_THAT(warning_codes(), ElementsAre("step-spans"));
  EXPECT_THAT(messages_, HasSubstr("mm, where CAD programs may take 0.001 mm for nothing"));
  (void)reported(tiny, {"--step-unit", "m"});
  EXPECT_THAT(warning_codes(), IsEmpty());
  (void)reported(scenes + "/mapped_cube.obj", {});
  EXPECT_THAT(messages_, HasSubstr(".step holds no texture coordinates"));
}

TEST_F(StepCommand, FlagsWithoutEffectAreTold) {
  const ProcessResult no_step = fit(cube_, {"-o", path("a.glb"), "--step-unit", "m"});
  EXPECT_EQ(no_step.exit_code, 0);
  EXPECT_THAT(no_step.err, HasSubstr("without effect here: --step-unit"));
  EXPECT_THAT(no_step.err, HasSubstr("no output STEP)"));
  const ProcessResult only_step = fit(cube_, {"-o", path("a.step"), "--levels", "3"});
  EXPECT_THAT(only_step.err,
              AllOf(HasSubstr("without effect here: --levels"), HasSubstr("STEP has no levels)")));
  const ProcessResult both =
      fit(cube_, {"-o", path("a.step"), "-o", path("a.glb"), "--levels", "3", "--step-unit", "m"});
  EXPECT_THAT(both.err, Not(HasSubstr("without effect")));
}

TEST_F(StepCommand, RefusesByName) {
  const auto error = [&](std::vector<std::string> flags) {
    flags.insert(flags.end(), {"-o", path("p.step")});
    const ProcessResult result = fit(cube_, std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_THAT(error({"--scheme", "loop"}),
              AllOf(HasSubstr("p.step: STEP's faces are quads, and patches of loop are triangles"),
                    HasSubstr("take --scheme doo-sabin or catmull-clark, or a format of meshes")));
  EXPECT_THAT(error({"--step-unit", "km"}), HasSubstr("--step-unit: \"km\""));
  EXPECT_THAT(error({"--step-angle", "0"}), HasSubstr("above 0 to 90 degrees are wanted"));
  EXPECT_THAT(error({"--step-angle", "91"}), HasSubstr("--step-angle: 91"));
  EXPECT_THAT(error({"--step-tolerance", "0"}), HasSubstr("--step-tolerance: 0"));
  EXPECT_THAT(error({"--step-face-size", "0"}), HasSubstr("1 to 4096"));
  EXPECT_THAT(error({"--attributes", "error"}), HasSubstr("p.step cannot hold them"));
  EXPECT_THAT(error({"--compress", "quantize"}), HasSubstr("p.step is not compressed"));
  EXPECT_THAT(names(), ElementsAre("cube.obj", "torus.obj"));
}

TEST_F(StepCommand, TheLibrarySaysWhatItWrote) {
  FitFileOptions options;
  options.settings.step = {.faces = {.angle = 1, .deviation = 1e-5, .face_size = 6},
                           .analytic = AnalyticChoice::Off,
                           .unit = StepUnit::Inch};
  options.cage = path("cage.obj");
  options.settings.interpolation = InterpolationChoice::Progressive;
  const FileFit done = fit_file(torus_, path("c.step"), options);
  EXPECT_TRUE(exists("cage.obj"));
  ASSERT_TRUE(done.step);
  EXPECT_TRUE(done.step->keeps_limits);
  EXPECT_EQ(done.byte_count, read("c.step").size());
  EXPECT_EQ(done.face_count, std::ssize(StepFile(path("c.step")).all("ADVANCED_FACE")));
  options.settings.scheme = Scheme::Loop;
  const std::string message = message_of(ErrorCode::InvalidArgument,
                                         [&] { (void)fit_file(torus_, path("d.step"), options); });
  EXPECT_THAT(message, HasSubstr("d.step: STEP's faces are quads, and patches of loop are"));
  EXPECT_FALSE(exists("d.step"));
}

TEST_F(StepCommand, WritesCatmullClarkSurfaces) {
  const nlohmann::json output = reported(torus_, {"--scheme", "catmull-clark"});
  EXPECT_EQ(output["step"]["solids"], 1);
  EXPECT_EQ(output["step"]["extraordinary"], 0);
  EXPECT_LE(output["as_written_error"], 1e-6);
  const StepFile file(path("p.step"));
  for (const std::int64_t id : file.all("B_SPLINE_SURFACE_WITH_KNOTS"))
    ASSERT_EQ(file.at(id).values[1].number(), 3);
  // fit_file() writes the same.
  FitFileOptions options;
  options.settings.scheme = Scheme::CatmullClark;
  const FileFit done = fit_file(torus_, path("d.step"), options);
  EXPECT_EQ(done.step->faces, output["step"]["faces"]);
  EXPECT_EQ(read("p.step").size(), read("d.step").size());
}

TEST_F(StepCommand, CreasesOfCatmullClarkThatAreSharpForSomeStepsAreRefused) {
  // OBJ cannot say it; a cage of OpenSubdiv's shapes can.
  write("semi.obj", cube_obj() + "t crease 2/1/0 0 1 2.5\n");
  const ProcessResult result =
      fit(path("semi.obj"), {"--scheme", "catmull-clark", "-o", path("p.step")});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("the edge between vertices 0 and 1 has sharpness 2.5"));
  EXPECT_FALSE(exists("p.step"));
}

TEST_F(StepCommand, DryRunsSayTheUnit) {
  const ProcessResult dry = fit(cube_, {"-o", path("p.step"), "--dry-run"});
  EXPECT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_FALSE(exists("p.step"));
  EXPECT_THAT(dry.out, HasSubstr("p.step  (faces, in mm)"));
}

TEST_F(StepCommand, FullDisksAndInterruptsLeaveTheOldFile) {
  write("p.step", "old");
  const std::string scan = PLANISH_SCENES "/rocker_arm_scan.obj";
  const auto expect_old = [&] {
    EXPECT_EQ(read("p.step"), "old");
    EXPECT_THAT(names(), ElementsAre("cube.obj", "p.step", "torus.obj"));
  };
  {
    const ProcessResult result = [&] {
      const FileSizeLimit limit(16 << 10);
      return fit(cube_, {"-o", path("p.step")});
    }();
    EXPECT_EQ(result.exit_code, 7) << result.err;
    EXPECT_THAT(result.err, HasSubstr("cannot write"));
    expect_old();
  }
  PlanishProcess process({"fit", scan, "--device", "cpu", "-f", "-o", path("p.step"),
                          "--step-angle", "1e-3", "--progress", "json"},
                         {});
  EXPECT_TRUE(process.wait_for_message("\"faces\""));
  ::kill(process.id(), SIGINT);
  EXPECT_EQ(process.finish().exit_code, 130);
  expect_old();
}

}  // namespace
}  // namespace planish::test
