#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/job/job_text.h"

namespace planish::command {
namespace {

TEST(CageHeader, ReadsBackWhatItWrites) {
  FitSettings settings;
  settings.weights = Weights::Averaged;
  settings.boundary = BoundaryRule::EdgeAndCorner;
  settings.creases = {.dihedral_degrees = 32.5};
  settings.repair = RepairChoice::None;
  settings.tolerance = 1.0 / 3.0 * 1e-7;
  settings.weld = 1.0 / 3.0 * 1e-5;
  FoundCreases found{{}, {0, 17, 2147483647}};
  for (std::int32_t v = 0; v < 40; ++v) found.edges.push_back({v, v + 100});
  std::vector<std::string> lines =
      cage_header_lines(settings, InterpolationMethod::Fair, "some/where/goblet.obj", found);
  for (std::string& line : lines) EXPECT_EQ(line.substr(0, 8), "planish ");
  const CageHeader header = parse_cage_header(lines, "cage.obj");
  EXPECT_EQ(header.settings.interpolation, InterpolationChoice::Fair);
  EXPECT_EQ(header.settings.weights, Weights::Averaged);
  EXPECT_EQ(header.settings.boundary, BoundaryRule::EdgeAndCorner);
  EXPECT_EQ(header.settings.creases.dihedral_degrees, 32.5);
  EXPECT_EQ(header.settings.repair, RepairChoice::None);
  EXPECT_EQ(header.settings.tolerance, settings.tolerance);  // to the last bit
  EXPECT_EQ(header.source, "goblet.obj");
  EXPECT_EQ(header.settings.weld, settings.weld);
  ASSERT_TRUE(header.found);
  EXPECT_EQ(header.found->edges, found.edges) << "of three lines";
  EXPECT_EQ(header.found->corners, found.corners);
}

// Those of older versions are read: order and spelling stay.
TEST(CageHeader, HasItsLinesInOrder) {
  FitSettings settings;
  settings.creases = {.dihedral_degrees = 1e-5};
  settings.weld = 0;
  settings.scheme = Scheme::Loop;
  const std::vector<std::string> lines =
      cage_header_lines(settings, InterpolationMethod::Progressive, "a.obj");
  EXPECT_THAT(
      std::vector(lines.begin() + 1, lines.end()),
      testing::ElementsAre("planish scheme=loop", "planish interpolation=progressive",
                           "planish weights=doo-sabin", "planish boundary=edge",
                           "planish creases=auto:1e-05", "planish repair=safe",
                           "planish quads=auto", "planish refine=auto", "planish tolerance=1e-06",
                           "planish source=a.obj", "planish weld=0", "planish sharp_edges="));
  EXPECT_EQ(parse_cage_header(lines, "a").settings.creases.dihedral_degrees, 1e-5);
}

TEST(CageHeader, ASourceCannotBreakTheLine) {
  for (const std::string& line :
       cage_header_lines({}, InterpolationMethod::Progressive, "a\nv 1 2 3.obj")) {
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST(CageHeader, SaysNothingWhereNothingStands) {
  const CageHeader header = parse_cage_header({}, "cage.obj");
  EXPECT_EQ(header.settings.interpolation, InterpolationChoice::Progressive);
  EXPECT_FALSE(header.settings.weld);
  EXPECT_EQ(header.settings.tolerance, FitSettings().tolerance);
  EXPECT_EQ(header.source, "");
  EXPECT_FALSE(header.found);
}

TEST(CageHeader, KeysOfNewerVersionsAreLeftToThem) {
  const std::vector<std::string> lines{"planish colour=blue", "planish weights=doo-sabin"};
  EXPECT_EQ(parse_cage_header(lines, "cage.obj").settings.weights, Weights::DooSabin);
}

TEST(CageHeader, WrongValuesAreNamed) {
  for (const char* line :
       {"planish weights=heavy", "planish tolerance=small", "planish tolerance=-1",
        "planish tolerance=1e-6x", "planish scheme=kobbelt", "planish weld=0.1", "planish weld=nan",
        "planish sharp_corners=1 x", "planish sharp_corners=-1", "planish sharp_corners=2147483648",
        "planish sharp_edges=1", "planish sharp_edges=1-x", "planish sharp_edges=1-2-3",
        "planish boundary=", "planish interpolation=auto"}) {
    const std::vector<std::string> lines{line};
    try {
      (void)parse_cage_header(lines, "cage.obj");
      FAIL() << line;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::UnreadableInput) << line;
      EXPECT_THAT(error.what(), testing::HasSubstr("cage.obj: header "));
    }
  }
}

}  // namespace
}  // namespace planish::command

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class VerifyCommand : public FolderTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_planish({"fit", input_, "--cage", path("c.obj"), "--preset", "paper"}).exit_code,
              0);
  }

  std::string input_ = write("plate.obj", bumpy_plate_obj(8));
};

TEST_F(VerifyCommand, ConfirmsWhatFitWrote) {
  const ProcessResult result = run_planish({"verify", path("c.obj"), input_});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, StartsWith("confirmed"));
  EXPECT_THAT(result.out, HasSubstr("averaged"));  // from the header
}

TEST_F(VerifyCommand, ConfirmsCagesOfEveryFormat) {
  for (const char* name : {"d.ply", "d.off", "d.obj"}) {
    ASSERT_EQ(run_planish({"fit", input_, "--cage", path(name)}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), input_}).exit_code, 0) << name;
  }
}

TEST_F(VerifyCommand, RejectsAPerturbedCage) {
  std::string cage = read("c.obj");
  // The first vertex moves across half the plate.
  const std::size_t first = cage.find("\nv ") + 3;
  cage.replace(first, cage.find(' ', first) - first, "0.5");
  write("moved.obj", cage);
  const ProcessResult result = run_planish({"verify", path("moved.obj"), input_, "--json"});
  EXPECT_EQ(result.exit_code, 5);
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["confirmed"], false);
  EXPECT_EQ(json["error"]["worst_vertex"], 0);
  EXPECT_GT(json["error"]["max"], 0.01);
}

TEST_F(VerifyCommand, RejectsTheInputAsItsOwnCage) {
  EXPECT_EQ(run_planish({"verify", input_, input_}).exit_code, 5);
}

TEST_F(VerifyCommand, FlagsOverrideTheHeader) {
  EXPECT_EQ(run_planish({"verify", path("c.obj"), input_, "--tolerance", "1e-15"}).exit_code, 5);
  EXPECT_EQ(
      run_planish({"verify", path("c.obj"), input_, "--boundary", "edge-and-corner"}).exit_code, 5);
}

TEST_F(VerifyCommand, AgreesWithTheReport) {
  ASSERT_EQ(
      run_planish({"fit", input_, "--cage", path("d.obj"), "--report", path("r.json")}).exit_code,
      0);
  const nlohmann::json verified =
      nlohmann::json::parse(run_planish({"verify", path("d.obj"), input_, "--json"}).out);
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(verified["error"]["max"], report["outputs"][0]["as_written_error"]);
  EXPECT_NEAR(verified["error"]["max"].get<double>(), report["solve"]["error"]["max"].get<double>(),
              1e-14);
  EXPECT_EQ(verified["error"]["worst_vertex"], report["solve"]["error"]["worst_vertex"]);
}

TEST_F(VerifyCommand, ACageOfAnotherMeshIsRefused) {
  const std::string cube = write("cube.obj", cube_obj());
  const ProcessResult result = run_planish({"verify", path("c.obj"), cube});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("is no cage of"));
  const std::string torus =
      write("torus.obj", torus_obj(8));  // 64 faces as the plate, fewer vertices
  EXPECT_THAT(run_planish({"verify", path("c.obj"), torus}).err,
              HasSubstr("face 0 has other corners"));
}

TEST_F(VerifyCommand, ABrokenHeaderIsNamed) {
  std::string cage = read("c.obj");
  cage.replace(cage.find("=averaged"), 9, "=avaraged");
  const ProcessResult result = run_planish({"verify", write("b.obj", cage), input_});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("header weights: \"avaraged\" is not one of"));
}

TEST_F(VerifyCommand, CreasesAreTakenFromTheInputWhereTheFormatHasNone) {
  const std::string creased =
      write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\n" + "t crease 2/1/0 1 2 10\n");
  for (const char* name : {"k.obj", "k.ply"}) {
    ASSERT_EQ(run_planish({"fit", creased, "--cage", path(name)}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), creased}).exit_code, 0) << name;
    EXPECT_EQ(run_planish({"verify", path(name), creased, "--creases", "ignore"}).exit_code, 5);
  }
}

using nlohmann::json;

class QueryCommand : public FolderTest {
 protected:
  json answers(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"query", torus_});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out);
  }
  ProcessResult refused(const std::vector<std::string>& flags, int code) {
    std::vector<std::string> all{"query", torus_};
    all.insert(all.end(), flags.begin(), flags.end());
    ProcessResult result = run_planish(all);
    EXPECT_EQ(result.exit_code, code) << result.err;
    return result;
  }

  std::string torus_ = write("torus.obj", torus_obj(8));
  std::string probes_ = write("probes.xyz", "10 1 2\n0.5 0.25 -7\n0 0 0\n");
};

double length_between(const json& a, const json& b) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) sum += std::pow(a[d].get<double>() - b[d].get<double>(), 2);
  return std::sqrt(sum);
}

TEST_F(QueryCommand, GivesOneClosestPointAPoint) {
  const json all = answers({"--points", probes_});
  ASSERT_EQ(all["closest"].size(), 3u);
  const json probes = {{10, 1, 2}, {0.5, 0.25, -7}, {0, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& answer = all["closest"][i];
    EXPECT_NEAR(length_between(answer["position"], probes[i]), answer["distance"].get<double>(),
                1e-12);
    EXPECT_NEAR(length_between(answer["normal"], {0, 0, 0}), 1, 1e-12);
  }
}

// The given vertices lie on the surface: the distances are the solve's errors.
TEST_F(QueryCommand, FindsTheGivenVerticesOnTheSurface) {
  const std::string vertices = write("vertices.obj.xyz", [&] {
    std::string points;
    std::istringstream lines(read("torus.obj"));
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with("v ")) points += line.substr(2) + "\n";
    return points;
  }());
  const json all = answers({"--points", vertices});
  ASSERT_EQ(all["closest"].size(), all["mesh"]["vertices"]);
  for (const json& answer : all["closest"]) EXPECT_LT(answer["distance"].get<double>(), 1e-5);
}

TEST_F(QueryCommand, RaysHitOrMiss) {
  const json all = answers({"--points", probes_, "--rays", "0,0,1"});
  ASSERT_EQ(all["rays"].size(), 3u);
  EXPECT_TRUE(all["rays"][0].is_null());
  EXPECT_TRUE(all["rays"][2].is_null());  // through the hole
  const std::string below = write("below.xyz", "1 0 -9\n");
  const json hit = answers({"--points", below, "--rays", "0,0,2"})["rays"][0];
  ASSERT_FALSE(hit.is_null());
  EXPECT_NEAR(hit["position"][2].get<double>(), -9 + 2 * hit["t"].get<double>(), 1e-12);
  EXPECT_LT(hit["normal"][2].get<double>(), 0);
}

// Squares of these are 0 and infinite.
TEST_F(QueryCommand, TakesDirectionsOfAnyLength) {
  const std::string below = write("below.xyz", "1 0 -9\n");
  const auto t = [&](const std::string& direction) {
    return answers({"--points", below, "--rays", direction})["rays"][0]["t"].get<double>();
  };
  const double unit = t("0,0,1");
  EXPECT_NEAR(1e-200 * t("0,0,1e-200"), unit, 1e-12);
  EXPECT_NEAR(1e200 * t("0,0,1e200"), unit, 1e-12);
}

TEST_F(QueryCommand, WritesAFileAndKeepsToTheRulesOfOutputs) {
  EXPECT_EQ(run_planish({"query", torus_, "--points", probes_, "-o", path("a.json")}).exit_code, 0);
  EXPECT_EQ(read_json("a.json")["closest"].size(), 3u);
  EXPECT_THAT(refused({"--points", probes_, "-o", path("a.json")}, 7).err, HasSubstr("--force"));
  EXPECT_THAT(refused({"--points", probes_, "-o", path("a.txt")}, 2).err,
              HasSubstr("a.txt: answers are written as .json or .ply"));
}

// One vertex an answer, which the mesh readers take as points.
TEST_F(QueryCommand, WritesPly) {
  EXPECT_EQ(run_planish({"query", torus_, "--points", probes_, "-o", path("a.ply")}).exit_code, 0);
  const std::string text = read("a.ply");
  EXPECT_THAT(text, HasSubstr("element vertex 3\n"));
  EXPECT_THAT(text, HasSubstr("property double distance\nproperty int face\nproperty double u\n"));
  const std::size_t head = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size() - head, 3 * (24 + 12 + 8 + 4 + 16));
  const json wanted = answers({"--points", probes_})["closest"][1];
  double position[3], distance;
  std::memcpy(position, text.data() + head + 64, sizeof position);
  std::memcpy(&distance, text.data() + head + 64 + 36, sizeof distance);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(position[d], wanted["position"][d]);
  EXPECT_EQ(distance, wanted["distance"]);
  const ProcessResult rays =
      run_planish({"query", torus_, "--points", probes_, "--rays", "0,0,1", "-o", path("r.ply")});
  EXPECT_EQ(rays.exit_code, 0) << rays.err;
  EXPECT_THAT(read("r.ply"), HasSubstr("property double t\n"));
}

// Answers are made some thousand at a time: the text is that of one JSON value all the same.
TEST_F(QueryCommand, ManyAnswersAreOneJsonText) {
  std::string many;
  for (int i = 0; i < 9000; ++i)
    many += std::to_string(1e-3 * i) + " 0.5 " + std::to_string(i) + "\n";
  for (const std::string& points : {write("many.xyz", many), write("none.xyz", "")}) {
    for (const bool rays : {false, true}) {
      std::vector<std::string> flags{"query", torus_, "--points", points};
      if (rays) flags.insert(flags.end(), {"--rays", "0,0,-1"});
      const ProcessResult result = run_planish(flags);
      ASSERT_EQ(result.exit_code, 0) << result.err;
      const auto whole = nlohmann::ordered_json::parse(result.out);
      EXPECT_EQ(whole[rays ? "rays" : "closest"].size(), points == path("none.xyz") ? 0u : 9000u);
      EXPECT_TRUE(whole.dump(2) + "\n" == result.out);
    }
  }
}

// A slip in the points must not cost a fit.
TEST_F(QueryCommand, ReadsThePointsFirst) {
  const std::string broken = write("broken.obj", "v 0 0 0\nf 1 2 3\n");
  const std::string points = write("points.xyz", "0 0 0\n1 1 1\n2 two 2\n");
  const ProcessResult result = run_planish({"query", broken, "--points", points});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("points.xyz:3"));
}

TEST_F(QueryCommand, SaysWhatWasPassedOverInThePoints) {
  const std::string points = write("odd.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                   "property float y\nproperty float z\nend_header\n0 0 0 7\n");
  const ProcessResult result = run_planish({"query", torus_, "--points", points});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("odd.ply:8"));
}

TEST_F(QueryCommand, BadQuestionsAreRefused) {
  EXPECT_THAT(refused({"--points", probes_, "--rays", "0,0"}, 2).err,
              HasSubstr("--rays: \"0,0\" is no direction such as 0,0,-1"));
  EXPECT_THAT(refused({"--points", probes_, "--rays", "0,0,0"}, 2).err, HasSubstr("no direction"));
  EXPECT_THAT(refused({"--points", path("none.xyz")}, 3).err, HasSubstr("none.xyz"));
  EXPECT_THAT(refused({"--points", write("n.xyz", "0 0 0\nnan 0 0\n")}, 3).err,
              HasSubstr("1 of its points are not finite"));
}

}  // namespace
}  // namespace planish::test
