// Everything that planish writes as JSON against the published schema.
#include <gmock/gmock.h>

#include <fstream>
#include <regex>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

json report_schema() {
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  return json::parse(file);
}

class ReportSchema : public FolderTest {
 protected:
  void expect_valid(const json& value, const std::string& form) {
    EXPECT_THAT(schema_problems(value, {{"$ref", "#/$defs/" + form}}, schema_), IsEmpty())
        << value.dump(1).substr(0, 500);
    EXPECT_THAT(schema_problems(value, schema_), IsEmpty());
  }
  json fitted(std::vector<std::string> arguments, int exit_code = 0) {
    arguments.insert(arguments.begin(), "fit");
    arguments.insert(arguments.end(), {"--report", path("r.json"), "-f"});
    const ProcessResult result = run_planish(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return read_json("r.json");
  }
  static json printed(const std::vector<std::string>& arguments) {
    return json::parse(run_planish(arguments).out);
  }

  json schema_ = report_schema();
  std::string torus_ = write("torus.obj", torus_obj(8));
  std::string plate_ = write("plate.obj", bumpy_plate_obj(5));
};

TEST_F(ReportSchema, HoldsForEveryMethodSchemeAndSolver) {
  for (const std::vector<std::string>& flags : {std::vector<std::string>{},
                                                {"--solver", "plain", "--weights", "averaged"},
                                                {"--solver", "cg"},
                                                {"--interpolation", "fair"},
                                                {"--scheme", "catmull-clark"},
                                                {"--source", torus_, "-v"},
                                                {"--creases", "auto:20"},
                                                {"--boundary", "edge-and-corner"}}) {
    std::vector<std::string> arguments{torus_, "-o", path("t.glb"), "--cage", path("c.obj")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    expect_valid(fitted(arguments), "fit");
  }
  const std::string tetrahedron =
      write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  expect_valid(fitted({tetrahedron, "--scheme", "loop"}), "fit");
}

TEST_F(ReportSchema, HoldsForWhatDidNotConvergeOrNeededRepair) {
  expect_valid(fitted({plate_, "-o", path("p.obj"), "--max-iterations", "1", "--interpolation",
                       "progressive"},
                      5),
               "fit");
  const json report = fitted({PLANISH_SCENES "/bad/inconsistent_winding.obj"});
  EXPECT_FALSE(report["warnings"].empty());
  expect_valid(report, "fit");
}

TEST_F(ReportSchema, HoldsForTheJobsOfAScene) {
  write("s.json", R"({"version":1,"jobs":[{"name":"a","input":"torus.obj","report":"a.json",)"
                  R"("outputs":[{"path":"a.glb"}]},{"name":"b","input":"plate.obj",)"
                  R"("solve":{"interpolation":"fair"},"report":"b.json",)"
                  R"("outputs":[{"path":"b.obj","what":"cage"}]}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  expect_valid(read_json("a.json"), "fit");
  expect_valid(read_json("b.json"), "fit");
}

#ifdef PLANISH_HAS_MESHER
TEST_F(ReportSchema, HoldsForPoints) {
  // The torus' points alone.
  const std::string points = std::regex_replace(torus_obj(24), std::regex("f .*\n|v "), "");
  const std::string cloud = write("cloud.xyz", points);
  ASSERT_EQ(run_planish({"reconstruct", cloud, "-o", path("m.obj"), "--tolerance-mesh", "1e-2",
                         "--report", path("m.json")})
                .exit_code,
            0);
  expect_valid(read_json("m.json"), "reconstruct");
  expect_valid(fitted({cloud, "-o", path("f.glb"), "--tolerance-mesh", "1e-2"}), "fit");
  write("s.json", R"({"version":1,"jobs":[{"name":"a","input":"torus.obj","report":"a.json",)"
                  R"("sample":{"points":2000},"tolerance_mesh":0.01,)"
                  R"("outputs":[{"path":"a.glb"}]}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  const json sampled = read_json("a.json");
  EXPECT_TRUE(sampled["reconstruction"].contains("sampled"));
  expect_valid(sampled, "fit");
}
#endif

TEST_F(ReportSchema, HoldsForWhatOtherCommandsPrint) {
  (void)fitted({plate_, "--cage", path("c.ply")});
  expect_valid(printed({"verify", path("c.ply"), plate_, "--json"}), "verify");
  const std::string probes = write("probes.xyz", "0.1 0.2 5\n9 9 9\n");
  expect_valid(printed({"query", plate_, "--points", probes}), "query");
  expect_valid(printed({"query", plate_, "--points", probes, "--rays", "0,0,-1"}), "query");
  expect_valid(printed({"inspect", plate_, "--json"}), "inspect");
  expect_valid(printed({"inspect", PLANISH_SCENES "/bad/non_manifold_edge.obj", "--json"}),
               "inspect");
  expect_valid(printed({"devices", "--json"}), "devices");
}

TEST_F(ReportSchema, PromisesEveryKey) {
  const json report = fitted({torus_, "-o", path("t.glb"), "--interpolation", "fair"});
  for (const auto& [key, value] : report.items()) {
    json lacking = report;
    lacking.erase(key);
    EXPECT_THAT(schema_problems(lacking, schema_), Contains(": has no " + key));
  }
  json more = report;
  more["solve"]["fair"]["speed"] = 1;
  EXPECT_THAT(schema_problems(more, schema_), Contains("/solve/fair/speed: is not in the schema"));
}

TEST(JsonSchema, SaysWhatIsWrongAndWhere) {
  const json document = json::parse(R"({"type":"object","additionalProperties":false,
      "required":["a"],"properties":{"a":{"type":["integer","null"],"minimum":1,"maximum":3},
      "b":{"items":{"$ref":"#/$defs/word"},"minItems":1,"maxItems":2},"c":{"const":5},
      "d":{"anyOf":[{"type":"null"},{"type":"object","required":["e"]}]}},
      "$defs":{"word":{"type":"string","pattern":"^[a-z]+$","enum":["x","yy","Z"]}}})");
  const auto problems = [&](const char* text) {
    return schema_problems(json::parse(text), document);
  };
  EXPECT_THAT(problems(R"({"a":2,"b":["x","yy"],"c":5,"d":null})"), IsEmpty());
  EXPECT_THAT(problems(R"({"a":null,"d":{"e":1}})"), IsEmpty());
  EXPECT_THAT(problems("[]"), ElementsAre(": [] is no \"object\""));
  EXPECT_THAT(problems("{}"), ElementsAre(": has no a"));
  EXPECT_THAT(problems(R"({"a":0})"), ElementsAre("/a: 0.000000 is too small"));
  EXPECT_THAT(problems(R"({"a":4})"), ElementsAre("/a: 4.000000 is too large"));
  EXPECT_EQ(problems(R"({"a":1.5})").size(), 1u);
  EXPECT_THAT(problems(R"({"a":1,"z":1})"), ElementsAre("/z: is not in the schema"));
  EXPECT_THAT(problems(R"({"a":1,"b":[]})"), ElementsAre("/b: is too short"));
  EXPECT_THAT(problems(R"({"a":1,"b":["x","x","x"]})"), ElementsAre("/b: is too long"));
  EXPECT_THAT(problems(R"({"a":1,"b":["Z"]})"),
              ElementsAre("/b/0: \"Z\" does not match \"^[a-z]+$\""));
  EXPECT_THAT(problems(R"({"a":1,"b":["zz"]})"),
              ElementsAre("/b/0: \"zz\" is none of [\"x\",\"yy\",\"Z\"]"));
  EXPECT_THAT(problems(R"({"a":1,"c":6})"), ElementsAre("/c: 6 is not 5"));
  EXPECT_EQ(problems(R"({"a":1,"d":{}})").size(), 1u);
  EXPECT_THROW((void)schema_problems(1, json{{"multipleOf", 2}}), std::invalid_argument);
}

}  // namespace
}  // namespace planish::test
