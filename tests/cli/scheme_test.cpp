// --scheme catmull-clark and loop from input to files.

#include <gmock/gmock.h>

#include <cmath>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

const std::string kScenes = PLANISH_SCENES;

class SchemeFlag : public FolderTest {
 protected:
  // Fits to all kinds of files and has the cage verified.
  nlohmann::json expect_fit_and_verify(const std::string& input, const std::string& scheme,
                                       const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"fit",      input,          "--scheme", scheme,
                                       "-o",       path("s.glb"),  "-o",       path("s.ply"),
                                       "--levels", "2,0",          "--cage",   path("c.obj"),
                                       "--report", path("r.json"), "-f"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult fitted = run_planish(arguments);
    EXPECT_EQ(fitted.exit_code, 0) << fitted.err;
    EXPECT_THAT(fitted.err, HasSubstr(scheme));
    EXPECT_THAT(read("c.obj"), HasSubstr("# planish scheme=" + scheme));
    const ProcessResult verified = run_planish({"verify", path("c.obj"), input, "--json"});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    EXPECT_EQ(nlohmann::json::parse(verified.out)["scheme"], scheme);
    nlohmann::json report = read_json("r.json");
    EXPECT_EQ(report["solve"]["scheme"], scheme);
    EXPECT_EQ(report["solve"]["weights"], nullptr);
    EXPECT_TRUE(report["solve"]["converged"]);
    for (const auto& output : report["outputs"]) {
      EXPECT_LE(output["as_written_error"], 1.01e-6) << output["path"];
    }
    return report;
  }
};

TEST_F(SchemeFlag, CatmullClarkInterpolatesTheGoblet) {
  const nlohmann::json report = expect_fit_and_verify(kScenes + "/goblet.obj", "catmull-clark");
  EXPECT_GT(report["outputs"][0]["quads"], 0);
  EXPECT_EQ(report["outputs"][0]["triangles"],
            2 * report["outputs"][0]["quads"].get<std::int64_t>());
  const ProcessResult as_doo_sabin =
      run_planish({"verify", path("c.obj"), kScenes + "/goblet.obj", "--scheme", "doo-sabin"});
  EXPECT_EQ(as_doo_sabin.exit_code, 5);
}

TEST_F(SchemeFlag, LoopInterpolatesATriangleMesh) {
  const nlohmann::json report = expect_fit_and_verify(kScenes + "/rocker_arm_scan.obj", "loop");
  EXPECT_EQ(report["outputs"][0]["quads"], 0);
  EXPECT_EQ(report["outputs"][0]["triangles"], 16 * report["input"]["faces"].get<std::int64_t>());
  EXPECT_THAT(read("s_LOD0.glb"), HasSubstr("\"scheme\":\"loop\""));
}

TEST_F(SchemeFlag, RunsOnVulkanAsOnTheCpu) {
  if (run_planish({"fit", write("t.obj", torus_obj(4)), "-o", path("t.glb"), "--device", "vulkan"})
          .exit_code == 6) {
    GTEST_SKIP() << "no Vulkan device";
  }
  for (const std::string scheme : {"catmull-clark", "loop"}) {
    const std::string input =
        scheme == "loop" ? kScenes + "/icosphere.obj" : write("plate.obj", bumpy_plate_obj(9));
    const auto on_cpu = expect_fit_and_verify(input, scheme, {"--device", "cpu"});
    const auto on_vulkan = expect_fit_and_verify(input, scheme, {"--device", "vulkan"});
    EXPECT_EQ(on_cpu["solve"]["iterations"], on_vulkan["solve"]["iterations"]);
    EXPECT_NE(on_vulkan["device"]["kind"], "cpu");
  }
}

TEST_F(SchemeFlag, CreasesOfEverySharpnessHold) {
  std::string obj = bumpy_plate_obj(6);
  obj += "t crease 2/1/0 8 9 3.5\nt crease 2/1/0 9 10 10\nt corner 1/1/0 24 2\n";
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark");
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark",
                        {"--boundary", "edge-and-corner"});
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark", {"--creases", "auto:5"});
}

TEST_F(SchemeFlag, ACubeOutOfTrueHasNoCatmullClarkSurface) {
  std::string obj = cube_obj();
  obj.replace(obj.find("v 1 1 1"), 7, "v 1 1 1.3");
  const ProcessResult result =
      run_planish({"fit", write("cube.obj", obj), "--scheme", "catmull-clark", "-o", path("c.glb"),
                   "--cage", path("cage.obj"), "--report", path("r.json")});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("not converged (singular)"));
  EXPECT_THAT(result.err, HasSubstr("take --scheme doo-sabin"));
  EXPECT_THAT(read("c.glb"), HasSubstr("\"converged\":false"));
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(report["exit_code"], 5);
  EXPECT_EQ(report["solve"]["converged"], false);
  EXPECT_EQ(report["solve"]["stop_reason"], "singular");
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), path("cube.obj")}).exit_code, 5);
}

TEST_F(SchemeFlag, LoopNamesTheFirstFaceThatIsNoTriangle) {
  const ProcessResult result = run_planish(
      {"fit", write("plate.obj", bumpy_plate_obj(3)), "--scheme", "loop", "-o", path("p.glb")});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("plate.obj: face 0 has 4 corners, and Loop subdivision knows "
                                    "triangles only; split the faces into triangles, or take "
                                    "catmull-clark or doo-sabin"));
  EXPECT_FALSE(exists("p.glb"));
}

TEST_F(SchemeFlag, SceneFilesNameSchemes) {
  write("plate.obj", bumpy_plate_obj(5));
  write("s.json",
        R"({"version":1,"jobs":[{"input":"plate.obj","solve":{"scheme":"catmull-clark"},
            "outputs":[{"path":"p.glb"}],"report":"r.json"}]})");
  const ProcessResult result = run_planish({"run", path("s.json")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json("r.json")["solve"]["scheme"], "catmull-clark");
  EXPECT_THAT(result.out + result.err, HasSubstr("catmull-clark"));
}

TEST_F(SchemeFlag, DryRunCountsFaces) {
  const ProcessResult result = run_planish({"fit", kScenes + "/icosphere.obj", "--scheme", "loop",
                                            "-o", path("i.glb"), "--levels", "2", "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("81,920 triangles, about"));
}

}  // namespace
}  // namespace planish::test
