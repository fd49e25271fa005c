#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

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
