#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/job/job_text.h"
#include "support/calls.h"

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
       cage_header_lines({}, InterpolationMethod::Progressive, "a\nv 1 2 3.obj"))
    EXPECT_EQ(line.find('\n'), std::string::npos);
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
    EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput,
                                 [&] { (void)parse_cage_header(lines, "cage.obj"); }),
                testing::HasSubstr("cage.obj: header "))
        << line;
  }
}

}  // namespace
}  // namespace planish::command

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class VerifyCommand : public FolderTest {
 protected:
  void SetUp() override {
    write("plate.obj", bumpy_plate_obj(8));
    run("fit plate.obj --cage c.obj --preset paper");
  }
};

TEST_F(VerifyCommand, ConfirmsWhatFitWrote) {
  const std::string text = run("verify c.obj plate.obj").out;
  EXPECT_THAT(text, testing::StartsWith("confirmed"));
  EXPECT_THAT(text, HasSubstr("averaged"));  // from the header
  for (const std::string name : {"d.ply", "d.off", "d.obj"}) {
    run("fit plate.obj --cage " + name);
    run("verify " + name + " plate.obj");
  }
}

TEST_F(VerifyCommand, RejectsOtherCages) {
  std::string cage = read("c.obj");
  // The first vertex moves across half the plate.
  const std::size_t first = cage.find("\nv ") + 3;
  write("moved.obj", cage.replace(first, cage.find(' ', first) - first, "0.5"));
  const json said = printed("verify moved.obj plate.obj --json", 5);
  expect_values(said, {{"/confirmed", false}, {"/error/worst_vertex", 0}});
  EXPECT_GT(said["error"]["max"], 0.01);
  for (const char* line : {"verify plate.obj plate.obj",  // by its own vertices
                                                          // Flags override the header.
                           "verify c.obj plate.obj --tolerance 1e-15",
                           "verify c.obj plate.obj --boundary edge-and-corner"})
    run(line, 5);
}

TEST_F(VerifyCommand, AgreesWithTheReport) {
  const json report = report_of("fit plate.obj --cage d.obj");
  const json error = printed("verify d.obj plate.obj --json")["error"];
  const json& of_solve = report["solve"]["error"];
  EXPECT_EQ(error["max"], report["outputs"][0]["as_written_error"]);
  EXPECT_NEAR(error["max"].get<double>(), of_solve["max"].get<double>(), 1e-14);
  EXPECT_EQ(error["worst_vertex"], of_solve["worst_vertex"]);
}

TEST_F(VerifyCommand, CreasesAreTakenFromTheInputWhereTheFormatHasNone) {
  write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 2 10\n");
  for (const std::string name : {"k.obj", "k.ply"}) {
    run("fit creased.obj --cage " + name);
    run("verify " + name + " creased.obj");
    run("verify " + name + " creased.obj --creases ignore", 5);
  }
}

class QueryCommand : public FolderTest {
 protected:
  json answers(const std::string& flags) { return printed("query torus.obj --points " + flags); }

  std::string torus_ = write("torus.obj", torus_obj(8));
  std::string probes_ = write("probes.xyz", "10 1 2\n0.5 0.25 -7\n0 0 0\n");
  std::string below_ = write("below.xyz", "1 0 -9\n");
};

double length_between(const json& a, const json& b) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) sum += std::pow(a[d].get<double>() - b[d].get<double>(), 2);
  return std::sqrt(sum);
}

TEST_F(QueryCommand, GivesOneClosestPointAPoint) {
  const json closest = answers("probes.xyz")["closest"];
  ASSERT_EQ(closest.size(), 3u);
  const json probes = {{10, 1, 2}, {0.5, 0.25, -7}, {0, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(length_between(closest[i]["position"], probes[i]),
                closest[i]["distance"].get<double>(), 1e-12);
    EXPECT_NEAR(length_between(closest[i]["normal"], {0, 0, 0}), 1, 1e-12);
  }
  run("query torus.obj --points probes.xyz -o a.json");
  EXPECT_EQ(read_json("a.json")["closest"], closest);
}

// The given vertices lie on the surface: the distances are the solve's errors.
TEST_F(QueryCommand, FindsTheGivenVerticesOnTheSurface) {
  std::string points;
  for (const std::string& line : lines_of(read("torus.obj")))
    if (line.starts_with("v ")) points += line.substr(2) + "\n";
  write("vertices.xyz", points);
  const json all = answers("vertices.xyz");
  ASSERT_EQ(all["closest"].size(), all["mesh"]["vertices"]);
  for (const json& answer : all["closest"]) EXPECT_LT(answer["distance"].get<double>(), 1e-5);
}

TEST_F(QueryCommand, RaysHitOrMiss) {
  const json rays = answers("probes.xyz --rays 0,0,1")["rays"];
  ASSERT_EQ(rays.size(), 3u);
  EXPECT_TRUE(rays[0].is_null());
  EXPECT_TRUE(rays[2].is_null());  // through the hole
  const json hit = answers("below.xyz --rays 0,0,2")["rays"][0];
  ASSERT_FALSE(hit.is_null());
  EXPECT_NEAR(hit["position"][2].get<double>(), -9 + 2 * hit["t"].get<double>(), 1e-12);
  EXPECT_LT(hit["normal"][2].get<double>(), 0);
  // Squares of these are 0 and infinite.
  const auto t = [&](const std::string& z) {
    return answers("below.xyz --rays 0,0," + z)["rays"][0]["t"].get<double>();
  };
  const double unit = t("1");
  EXPECT_NEAR(1e-200 * t("1e-200"), unit, 1e-12);
  EXPECT_NEAR(1e200 * t("1e200"), unit, 1e-12);
}

// One vertex an answer, which the mesh readers take as points.
TEST_F(QueryCommand, WritesPly) {
  run("query torus.obj --points probes.xyz -o a.ply");
  const std::string text = read("a.ply");
  EXPECT_THAT(text, HasSubstr("element vertex 3\n"));
  EXPECT_THAT(text, HasSubstr("property double distance\nproperty int face\nproperty double u\n"));
  const std::size_t head = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size() - head, 3 * (24 + 12 + 8 + 4 + 16));
  const json wanted = answers("probes.xyz")["closest"][1];
  double position[3], distance;
  std::memcpy(position, text.data() + head + 64, sizeof position);
  std::memcpy(&distance, text.data() + head + 64 + 36, sizeof distance);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(position[d], wanted["position"][d]);
  EXPECT_EQ(distance, wanted["distance"]);
  run("query torus.obj --points probes.xyz --rays 0,0,1 -o r.ply");
  EXPECT_THAT(read("r.ply"), HasSubstr("property double t\n"));
}

// Answers are made some thousand at a time: the text is that of one JSON value all the same.
TEST_F(QueryCommand, ManyAnswersAreOneJsonText) {
  std::string many;
  for (int i = 0; i < 9000; ++i)
    many += std::to_string(1e-3 * i) + " 0.5 " + std::to_string(i) + "\n";
  write("many.xyz", many);
  write("none.xyz", "");
  for (const auto& [points, count] : {std::pair{"many.xyz", 9000u}, {"none.xyz", 0u}}) {
    for (const auto& [rays, list] : {std::pair{"", "closest"}, {" --rays 0,0,-1", "rays"}}) {
      const std::string text = run(std::string("query torus.obj --points ") + points + rays).out;
      const auto whole = nlohmann::ordered_json::parse(text);
      EXPECT_EQ(whole[list].size(), count);
      EXPECT_TRUE(whole.dump(2) + "\n" == text);
    }
  }
}

}  // namespace
}  // namespace planish::test
