#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/files/mesh_file.h"
#include "planish/job/digest.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"

namespace planish::command {
namespace {

TEST(Digest, IsThatOfTheStandard) {
  EXPECT_EQ(sha256(std::as_bytes(std::span(std::string_view("abc")))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-4
}

// Around every place of the padding, and cut at every place of a block.
TEST(Digest, PlainOneIsThatOfTheLibrary) {
  std::vector<std::byte> bytes;
  for (int i = 0; i < 300; ++i) bytes.push_back(static_cast<std::byte>(i * 7919 >> 3));
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const std::span<const std::byte> all = std::span(bytes).first(size);
    PlainSha256 plain;
    plain.add(all.first(size * 3 / 7));
    plain.add(all.subspan(size * 3 / 7));
    ASSERT_EQ(plain.finish(), sha256_bytes(all)) << size;
  }
}

}  // namespace
}  // namespace planish::command

namespace planish::test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::IsEmpty;

class Report : public FolderTest {
 protected:
  json fit(const std::string& flags) {
    return report_of("fit plate.obj --interpolation progressive " + flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
};

// All that are required, which report_of() asks for, in the schema's order.
TEST_F(Report, HasItsKeysInTheOrderOfTheSchema) {
  EXPECT_EQ(fit("-o p.glb")["schema"], "planish.report/1");
  const auto report = nlohmann::ordered_json::parse(read("r.json"));
  const json schema = json::parse(std::ifstream(PLANISH_REPORT_SCHEMA))["$defs"];
  using Pointer = json::json_pointer;
  using OrderedPointer = nlohmann::ordered_json::json_pointer;
  for (const auto& [place, described] : std::vector<std::pair<std::string, std::string>>{
           {"", "/fit"},
           {"/tool", "/tool"},
           {"/input", "/fit/properties/input"},
           {"/device", "/fit/properties/device"},
           {"/solve", "/solve"},
           {"/solve/error", "/solve/properties/error"},
           {"/solve/history/0", "/solve/properties/history/items"},
           {"/surface", "/fit/properties/surface/anyOf/1"},
           {"/outputs/0", "/fit/properties/outputs/items"},
           {"/timing_ms", "/fit/properties/timing_ms"},
           {"/memory", "/fit/properties/memory"}}) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : report.at(OrderedPointer(place)).items()) keys.push_back(key);
    EXPECT_EQ(json(keys), schema.at(Pointer(described))["required"]) << place;
  }
}

TEST_F(Report, DescribesTheInput) {
  const json input = fit("-o p.glb --boundary edge-and-corner")["input"];
  expect_values(input,
                {{"/path", "plate.obj"}, {"/format", "obj"}, {"/vertices", 81}, {"/faces", 64}});
  EXPECT_EQ(input["face_sizes"], (json{{"4", 64}}));
  expect_values(input, {{"/boundary_loops", 1}, {"/components", 1}, {"/genus", 0}});
  EXPECT_EQ(input["sharp_edges"], 32);  // the boundary
  EXPECT_EQ(input["corners"], 4);
  EXPECT_EQ(fit("-o p.glb")["input"]["corners"], 0);
}

// Whatever is written; the torus by the closed formula (Willmore 1965).
TEST_F(Report, BendingIsThatOfTheMeshForEveryLevel) {
  constexpr double kPi = std::numbers::pi, kRatio = 1 / 0.4;
  const double of_torus = 4 * kPi * kPi * kRatio * kRatio / std::sqrt(kRatio * kRatio - 1);
  write("t.obj", torus_obj(24));
  const std::string ball = PLANISH_SCENES "/icosphere.obj";
  for (const auto& [flags, expected] :
       std::vector<std::pair<std::string, double>>{{"t.obj", of_torus},
                                                   {"t.obj --interpolation progressive", of_torus},
                                                   {"t.obj --source t.obj", of_torus},
                                                   {"t.obj --scheme catmull-clark", of_torus},
                                                   {ball, 8 * kPi},
                                                   {ball + " --scheme loop", 8 * kPi}}) {
    double of_level_1 = 0;
    for (const int level : {1, 2, 3}) {
      const std::string line = "fit -o s.glb -q --levels " + std::to_string(level) + " " + flags;
      const json surface = report_of(line)["surface"];
      EXPECT_EQ(surface["level"], level);
      if (of_level_1 == 0) of_level_1 = surface["bending"];
      EXPECT_NEAR(surface["bending"], of_level_1, 1e-12 * of_level_1) << line;  // sums' order
    }
    EXPECT_NEAR(of_level_1, expected, 0.01 * expected) << flags;
  }
}

TEST_F(Report, DescribesOutputsAsTheyAreOnDisk) {
  const json report = fit("-o p.glb -o p.gltf --cage c.ply --levels 2");
  for (const auto& output : report["outputs"]) {
    const std::string name = output["path"];
    const std::string content = read(name);
    EXPECT_EQ(output["sha256"], sha256(std::as_bytes(std::span(content)))) << name;
    const std::size_t companion = name == "p.gltf" ? read("p.bin").size() : 0;
    EXPECT_EQ(output["bytes"], content.size() + companion) << name;
  }
  EXPECT_EQ(report["outputs"][0]["level"], 2);
  EXPECT_EQ(report["outputs"][0]["quads"], 64 * 16);
  EXPECT_EQ(report["outputs"][0]["triangles"], 64 * 32);
  EXPECT_EQ(report["outputs"][0]["vertices"], 33 * 33);
  expect_values(
      report,
      {{"/outputs/2/what", "cage"}, {"/outputs/2/level", nullptr}, {"/outputs/2/vertices", 81}});
}

TEST_F(Report, AsWrittenErrorIsThatOfTheBytesInTheFile) {
  const json report = fit("-o p.gltf --tolerance 1e-12");
  // The plate's vertices come first in the buffer, in their order.
  const std::string bytes = read("p.bin");
  std::istringstream obj(read("plate.obj"));
  double largest = 0;
  glm::dvec3 low(1e9), high(-1e9);
  std::string keyword;
  for (std::size_t vertex = 0; obj >> keyword && keyword == "v"; ++vertex) {
    glm::dvec3 given;
    obj >> given.x >> given.y >> given.z;
    float written[3];
    std::memcpy(written, bytes.data() + 12 * vertex, sizeof written);
    const double distance =
        std::hypot(written[0] - given.x, written[1] - given.y, written[2] - given.z);
    largest = std::max(largest, distance);
    low = glm::min(low, given);
    high = glm::max(high, given);
  }
  const glm::dvec3 size = high - low;
  const double expected = largest / std::hypot(size.x, size.y, size.z);
  EXPECT_GT(expected, 1e-9);  // float32 rounds
  EXPECT_NEAR(report["outputs"][0]["as_written_error"].get<double>(), expected, 1e-15);
  EXPECT_EQ(report["warnings"][0]["code"], "rounded-output");
}

TEST_F(Report, HistoryEndsAtTheFinalError) {
  const json solve = fit("-o p.glb")["solve"];
  const std::size_t iterations = solve["iterations"];
  ASSERT_EQ(solve["history"].size(), iterations + 1);
  EXPECT_GT(solve["history"][0]["max"], 1e-6);
  EXPECT_NEAR(solve["history"][iterations]["max"].get<double>(),
              solve["error"]["max"].get<double>(), 1e-8);
  EXPECT_LE(solve["error"]["max"], 1e-6);
  EXPECT_LE(solve["error"]["rms"], solve["error"]["max"]);
}

TEST_F(Report, GoesToStdout) {
  EXPECT_EQ(printed("fit plate.obj -o p.glb --report -")["exit_code"], 0);
}

TEST_F(Report, KnowsTheFoldedArea) {
  EXPECT_EQ(fit("-o p.glb")["surface"]["folded_area"], 0.0);
  EXPECT_EQ(fit("--cage c.obj")["surface"]["folded_area"], 0.0);
  // Against the surface itself, evaluated and measured as a whole.
  const std::string scene = PLANISH_SCENES "/mixed_polygons.obj";
  const json surface = report_of("fit " + scene + " --interpolation progressive")["surface"];
  const PolygonMesh mesh = read_mesh(std::filesystem::path(scene)).mesh;
  const auto backend = make_cpu_backend({.solve_precision = precision_for(1e-6)});
  const Fit fitted = planish::fit(mesh, *backend, {});
  const SurfaceQuality quality =
      surface_quality(evaluate(mesh, fitted, *backend, {.level = surface["level"]}), mesh);
  EXPECT_GT(quality.folded_area, 0.01);
  EXPECT_NEAR(surface["folded_area"].get<double>(), quality.folded_area, 1e-9);
}

// Each key has its own figure: no two are alike.
TEST(ReportJson, TimesAndMemoryStandUnderTheirNames) {
  JobReport report;
  report.timing = {.read = 1,
                   .check = 2,
                   .topology = 3,
                   .stencils = 4,
                   .upload = 5,
                   .solve = 6,
                   .choose = 7,
                   .evaluate = 8,
                   .write = 9,
                   .total = 10};
  report.host_peak_bytes = 11;
  report.device_bytes = 12;
  const nlohmann::ordered_json said = to_json(report);
  EXPECT_EQ(said["timing_ms"],
            nlohmann::ordered_json::parse(
                R"({"read": 1.0, "check": 2.0, "topology": 3.0, "stencils": 4.0, "upload": 5.0,
                    "solve": 6.0, "choose": 7.0, "evaluate": 8.0, "write": 9.0, "total": 10.0})"));
  EXPECT_EQ(said["memory"],
            nlohmann::ordered_json::parse(R"({"host_peak_bytes": 11, "device_bytes": 12})"));
}

// As the kernel counts it for who has started the command.
TEST_F(Report, MemoryIsTheProcesss) {
  const ProcessResult result = run("fit plate.obj -o p.glb --report r.json", 0, {.measured = true});
  const json report = read_json("r.json");
  const auto bytes = report["memory"]["host_peak_bytes"].get<std::int64_t>();
  EXPECT_EQ(bytes % 4096, 0);  // pages: a kilobyte of 1000 bytes would not do
  // The kernel counts the pages of a thread in lots.
  EXPECT_NEAR(static_cast<double>(bytes), result.peak_bytes, 0.05 * result.peak_bytes);
  EXPECT_EQ(report["memory"]["device_bytes"], 0);
  const json& times = report["timing_ms"];
  double sum = 0;
  for (const auto& [step, milliseconds] : times.items())
    if (step != "total") sum += milliseconds.get<double>();
  EXPECT_LE(sum, times["total"].get<double>() + 0.01);
}

// Everything that planish writes as JSON against the published schema; report_of() does so, too.

class ReportSchema : public FolderTest {
 protected:
  void expect_valid(const json& value, const std::string& form) {
    EXPECT_THAT(report_problems(value, form), IsEmpty()) << value.dump(1).substr(0, 500);
    EXPECT_THAT(report_problems(value), IsEmpty());
  }

  std::string torus_ = write("torus.obj", torus_obj(8));
  std::string plate_ = write("plate.obj", bumpy_plate_obj(5));
};

TEST_F(ReportSchema, HoldsForEveryMethodSchemeAndSolver) {
  write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  for (const std::string flags :
       {"torus.obj", "torus.obj --solver plain --weights averaged", "torus.obj --solver cg",
        "torus.obj --interpolation fair", "torus.obj --scheme catmull-clark",
        "torus.obj --source torus.obj -v", "torus.obj --creases auto:20",
        "torus.obj --boundary edge-and-corner", "t.obj --scheme loop"})
    expect_valid(report_of("fit -o t.glb --cage c.obj " + flags), "fit");
  expect_valid(report_of("fit plate.obj --max-iterations 1 --interpolation progressive", 5), "fit");
  const json mended = report_of("fit " PLANISH_SCENES "/bad/inconsistent_winding.obj");
  EXPECT_FALSE(mended["warnings"].empty());
  expect_valid(mended, "fit");
}

TEST_F(ReportSchema, HoldsForTheJobsOfAScene) {
  write("s.json", R"({"version":1,"jobs":[{"name":"a","input":"torus.obj","report":"a.json",)"
                  R"("outputs":[{"path":"a.glb"}]},{"name":"b","input":"plate.obj",)"
                  R"("solve":{"interpolation":"fair"},"report":"b.json",)"
                  R"("outputs":[{"path":"b.obj","what":"cage"}]}]})");
  run("run s.json");
  expect_valid(read_json("a.json"), "fit");
  expect_valid(read_json("b.json"), "fit");
}

TEST_F(ReportSchema, HoldsForWhatOtherCommandsPrint) {
  run("fit plate.obj --cage c.ply");
  write("probes.xyz", "0.1 0.2 5\n9 9 9\n");
  expect_valid(printed("verify c.ply plate.obj --json"), "verify");
  expect_valid(printed("query plate.obj --points probes.xyz"), "query");
  expect_valid(printed("query plate.obj --points probes.xyz --rays 0,0,-1"), "query");
  expect_valid(printed("inspect plate.obj --json"), "inspect");
  expect_valid(printed("inspect " PLANISH_SCENES "/bad/non_manifold_edge.obj --json"), "inspect");
  expect_valid(printed("devices --json"), "devices");
}

TEST_F(ReportSchema, PromisesEveryKey) {
  const json report = report_of("fit torus.obj -o t.glb --interpolation fair");
  for (const auto& [key, value] : report.items()) {
    json lacking = report;
    lacking.erase(key);
    EXPECT_THAT(report_problems(lacking), Contains(": has no " + key));
  }
  json more = report;
  more["solve"]["fair"]["speed"] = 1;
  EXPECT_THAT(report_problems(more), Contains("/solve/fair/speed: is not in the schema"));
}

TEST(JsonSchema, SaysWhatIsWrongAndWhere) {
  const json document = json::parse(R"({"type":"object","additionalProperties":false,
      "required":["a"],"properties":{"a":{"type":["integer","null"],"minimum":1,"maximum":3},
      "b":{"items":{"$ref":"#/$defs/word"},"minItems":1,"maxItems":2},"c":{"const":5},
      "d":{"anyOf":[{"type":"null"},{"type":"object","required":["e"]}]}},
      "$defs":{"word":{"type":"string","pattern":"^[a-z]+$","enum":["x","yy","Z"]}}})");
  for (const auto& [text, problem] : std::vector<std::pair<const char*, const char*>>{
           {R"({"a":2,"b":["x","yy"],"c":5,"d":null})", ""},
           {R"({"a":null,"d":{"e":1}})", ""},
           {"[]", ": [] is no \"object\""},
           {"{}", ": has no a"},
           {R"({"a":0})", "/a: 0.000000 is too small"},
           {R"({"a":4})", "/a: 4.000000 is too large"},
           {R"({"a":1.5})", "/a: 1.5 is no [\"integer\",\"null\"]"},
           {R"({"a":1,"z":1})", "/z: is not in the schema"},
           {R"({"a":1,"b":[]})", "/b: is too short"},
           {R"({"a":1,"b":["x","x","x"]})", "/b: is too long"},
           {R"({"a":1,"b":["Z"]})", "/b/0: \"Z\" does not match \"^[a-z]+$\""},
           {R"({"a":1,"b":["zz"]})", "/b/0: \"zz\" is none of [\"x\",\"yy\",\"Z\"]"},
           {R"({"a":1,"c":6})", "/c: 6 is not 5"},
           {R"({"a":1,"d":{}})", "/d: has no e"}}) {
    const std::vector<std::string> none, one{problem};
    EXPECT_EQ(schema_problems(json::parse(text), document), *problem == 0 ? none : one) << text;
  }
  EXPECT_THROW((void)schema_problems(1, json{{"multipleOf", 2}}), std::invalid_argument);
}

}  // namespace
}  // namespace planish::test
