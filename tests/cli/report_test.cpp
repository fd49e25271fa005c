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
#include <regex>
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

using testing::ElementsAre;

std::vector<std::string> keys_of(const nlohmann::ordered_json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

class Report : public FolderTest {
 protected:
  nlohmann::ordered_json fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--report", path("r.json"), "-f", "--interpolation",
                                 "progressive"});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::ordered_json::parse(read("r.json"));
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
};

TEST_F(Report, HasTheKeysThatItPromises) {
  const nlohmann::ordered_json report = fit({"-o", path("p.glb")});
  EXPECT_THAT(keys_of(report),
              ElementsAre("schema", "tool", "argv", "job", "exit_code", "input", "device", "solve",
                          "surface", "outputs", "timing_ms", "memory", "warnings"));
  EXPECT_EQ(report["schema"], "planish.report/1");
  EXPECT_THAT(keys_of(report["tool"]), ElementsAre("name", "version", "git"));
  EXPECT_THAT(
      keys_of(report["input"]),
      ElementsAre("path", "sha256", "format", "vertices", "faces", "face_sizes", "boundary_loops",
                  "components", "genus", "sharp_edges", "corners", "folded_edges", "welded",
                  "dropped", "separated_edges", "changed_faces", "file_vertices", "file_faces"));
  EXPECT_THAT(keys_of(report["device"]), ElementsAre("kind", "name", "uuid", "driver", "api"));
  EXPECT_THAT(
      keys_of(report["solve"]),
      ElementsAre("method", "choice", "scheme", "weights", "solver", "boundary", "creases",
                  "repair", "weld", "quads", "refine", "tolerance", "within", "converged",
                  "stop_reason", "iterations", "spectral_bound", "error", "history", "fair"));
  EXPECT_THAT(keys_of(report["solve"]["error"]), ElementsAre("max", "rms", "worst_vertex"));
  EXPECT_THAT(keys_of(report["solve"]["history"][0]), ElementsAre("iteration", "max", "rms"));
  EXPECT_THAT(keys_of(report["surface"]),
              ElementsAre("level", "reference", "folded_area", "folded_area_elsewhere",
                          "rms_normal_deviation", "max_normal_deviation", "bending", "sheet_gap"));
  EXPECT_THAT(keys_of(report["outputs"][0]),
              ElementsAre("path", "what", "bytes", "sha256", "level", "vertices", "quads",
                          "triangles", "as_written_error"));
  EXPECT_THAT(keys_of(report["timing_ms"]),
              ElementsAre("read", "check", "topology", "stencils", "upload", "solve", "choose",
                          "evaluate", "write", "total"));
  EXPECT_THAT(keys_of(report["memory"]), ElementsAre("host_peak_bytes", "device_bytes"));
}

TEST_F(Report, DescribesTheInput) {
  const nlohmann::ordered_json input = fit({"-o", path("p.glb")})["input"];
  EXPECT_EQ(input["path"], plate_);
  EXPECT_EQ(input["format"], "obj");
  EXPECT_EQ(input["vertices"], 81);
  EXPECT_EQ(input["faces"], 64);
  EXPECT_EQ(input["face_sizes"], (nlohmann::ordered_json{{"4", 64}}));
  EXPECT_EQ(input["boundary_loops"], 1);
  EXPECT_EQ(input["components"], 1);
  EXPECT_EQ(input["genus"], 0);
  EXPECT_EQ(input["sharp_edges"], 32);  // the boundary
  EXPECT_EQ(input["corners"], 0);
}

// Whatever is written; the torus by the closed formula (Willmore 1965).
TEST_F(Report, BendingIsThatOfTheMeshForEveryLevel) {
  constexpr double kPi = std::numbers::pi, kRatio = 1 / 0.4;
  const double of_torus = 4 * kPi * kPi * kRatio * kRatio / std::sqrt(kRatio * kRatio - 1);
  const std::string ball = PLANISH_SCENES "/icosphere.obj", torus = write("t.obj", torus_obj(24));
  struct Case {
    std::string mesh;
    std::vector<std::string> flags;
    double expected;
  };
  for (const Case& c : {Case{torus, {}, of_torus},
                        {torus, {"--interpolation", "progressive"}, of_torus},
                        {torus, {"--source", torus}, of_torus},
                        {torus, {"--scheme", "catmull-clark"}, of_torus},
                        {ball, {}, 8 * kPi},
                        {ball, {"--scheme", "loop"}, 8 * kPi}}) {
    double of_level_1 = 0;
    for (const char* level : {"1", "2", "3"}) {
      std::vector<std::string> arguments{"fit", c.mesh,     "-o",  path("s.glb"), "-f",
                                         "-q",  "--levels", level, "--report",    path("r.json")};
      arguments.insert(arguments.end(), c.flags.begin(), c.flags.end());
      ASSERT_EQ(run_planish(arguments).exit_code, 0);
      const nlohmann::json surface = read_json("r.json")["surface"];
      EXPECT_EQ(surface["level"], std::stoi(level));
      if (of_level_1 == 0) of_level_1 = surface["bending"];
      EXPECT_NEAR(surface["bending"], of_level_1, 1e-12 * of_level_1)  // sums' order
          << level << testing::PrintToString(c.flags);
    }
    EXPECT_NEAR(of_level_1, c.expected, 0.01 * c.expected) << testing::PrintToString(c.flags);
  }
}

TEST_F(Report, CountsTheCornersOfTheBoundaryRule) {
  EXPECT_EQ(fit({"-o", path("p.glb"), "--boundary", "edge-and-corner"})["input"]["corners"], 4);
}

TEST_F(Report, DescribesOutputsAsTheyAreOnDisk) {
  const nlohmann::ordered_json report =
      fit({"-o", path("p.glb"), "-o", path("p.gltf"), "--cage", path("c.ply"), "--levels", "2"});
  for (const auto& output : report["outputs"]) {
    const std::string name = std::filesystem::path(output["path"].get<std::string>()).filename();
    const std::string content = read(name);
    EXPECT_EQ(output["sha256"], sha256(std::as_bytes(std::span(content)))) << name;
    const std::size_t companion = name == "p.gltf" ? read("p.bin").size() : 0;
    EXPECT_EQ(output["bytes"], content.size() + companion) << name;
  }
  EXPECT_EQ(report["outputs"][0]["level"], 2);
  EXPECT_EQ(report["outputs"][0]["quads"], 64 * 16);
  EXPECT_EQ(report["outputs"][0]["triangles"], 64 * 32);
  EXPECT_EQ(report["outputs"][0]["vertices"], 33 * 33);
  EXPECT_EQ(report["outputs"][2]["what"], "cage");
  EXPECT_EQ(report["outputs"][2]["level"], nullptr);
  EXPECT_EQ(report["outputs"][2]["vertices"], 81);
}

TEST_F(Report, AsWrittenErrorIsThatOfTheBytesInTheFile) {
  const nlohmann::ordered_json report = fit({"-o", path("p.gltf"), "--tolerance", "1e-12"});
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
  const nlohmann::ordered_json solve = fit({"-o", path("p.glb")})["solve"];
  const std::size_t iterations = solve["iterations"];
  ASSERT_EQ(solve["history"].size(), iterations + 1);
  EXPECT_GT(solve["history"][0]["max"], 1e-6);
  EXPECT_NEAR(solve["history"][iterations]["max"].get<double>(),
              solve["error"]["max"].get<double>(), 1e-8);
  EXPECT_LE(solve["error"]["max"], 1e-6);
  EXPECT_LE(solve["error"]["rms"], solve["error"]["max"]);
}

TEST_F(Report, GoesToStdout) {
  const ProcessResult result = run_planish({"fit", plate_, "-o", path("p.glb"), "--report", "-"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(result.out)["exit_code"], 0);
}

TEST_F(Report, KnowsTheFoldedArea) {
  EXPECT_EQ(fit({"-o", path("p.glb")})["surface"]["folded_area"], 0.0);
  EXPECT_EQ(fit({"--cage", path("c.obj")})["surface"]["folded_area"], 0.0);
  // Against the surface itself, evaluated and measured as a whole.
  const std::string scene = PLANISH_SCENES "/mixed_polygons.obj";
  const ProcessResult result = run_planish({"fit", scene, "--report", path("r.json"), "-f",
                                            "--interpolation", "progressive", "--device", "cpu"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json surface = read_json("r.json")["surface"];
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
  const ProcessResult result = run_planish(
      {"fit", plate_, "-o", path("p.glb"), "--report", path("r.json"), "--device", "cpu"},
      {.environment = {}, .folder = {}, .measured = true});
  const nlohmann::json report = read_json("r.json");
  const auto bytes = report["memory"]["host_peak_bytes"].get<std::int64_t>();
  EXPECT_EQ(bytes % 4096, 0);  // pages: a kilobyte of 1000 bytes would not do
  // The kernel counts the pages of a thread in lots.
  EXPECT_NEAR(static_cast<double>(bytes), result.peak_bytes, 0.05 * result.peak_bytes);
  EXPECT_EQ(report["memory"]["device_bytes"], 0);
  const nlohmann::json& times = report["timing_ms"];
  double sum = 0;
  for (const auto& [step, milliseconds] : times.items())
    if (step != "total") sum += milliseconds.get<double>();
  EXPECT_LE(sum, times["total"].get<double>() + 0.01);
}

TEST_F(Report, Sha256IsTheStandardOne) {
  // FIPS 180-2, appendix B.1.
  const std::string text = "abc";
  EXPECT_EQ(sha256(std::as_bytes(std::span(text))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// Everything that planish writes as JSON against the published schema.

using nlohmann::json;
using testing::Contains;
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
