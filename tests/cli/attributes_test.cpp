#include <gmock/gmock.h>

#include <cstring>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class Attributes : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

// The scalars of an attribute of a GLB.
std::vector<float> scalars(const std::string& glb, const std::string& name) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const auto document = nlohmann::json::parse(glb.substr(20, length));
  const auto& accessor =
      document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name].get<int>()];
  const auto& view = document["bufferViews"][accessor["bufferView"].get<int>()];
  std::vector<float> values(accessor["count"].get<std::size_t>());
  std::memcpy(values.data(), glb.data() + 28 + length + view["byteOffset"].get<std::size_t>(),
              4 * values.size());
  return values;
}

TEST_F(Attributes, ErrorsInTheFileAreTheReports) {
  ASSERT_EQ(fit({"-o", path("p.glb"), "--report", path("r.json"), "--attributes", "error,deviation",
                 "--interpolation", "progressive"})
                .exit_code,
            0);
  const auto report = read_json("r.json");
  const auto errors = scalars(read("p.glb"), "_ERROR");
  const auto deviations = scalars(read("p.glb"), "_DEVIATION");
  EXPECT_NEAR(*std::ranges::max_element(errors), report["solve"]["error"]["max"].get<double>(),
              1e-9);
  const auto worst = std::ranges::max_element(errors) - errors.begin();
  EXPECT_EQ(worst, report["solve"]["error"]["worst_vertex"]);
  EXPECT_NEAR(*std::ranges::max_element(deviations),
              report["surface"]["max_normal_deviation"].get<double>(), 1e-4);
  EXPECT_THAT(read("p.glb"), Not(HasSubstr("_FOLD")));
}

// A figure that is asked for has its name before a property of the input; sizes are forecast.
TEST_F(Attributes, PropertiesOfTheInputAreCarried) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      "property float z\nproperty float Quality\nproperty float Error\nelement face 6\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 1 9\n1 0 0 2 9\n1 1 0 3 9\n0 1 0 4 9\n0 0 1 5 9\n1 0 1 6 9\n1 1 1 7 9\n0 1 1 8 9\n"
      "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  plate_ = write("cube.ply", ply);
  const ProcessResult run = fit({"-o", path("p.glb"), "-o", path("p.ply"), "--attributes", "error",
                                 "--levels", "1", "--creases", "use"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("properties of the vertices are left out: Error; fields"));
  const std::vector<float> values = scalars(read("p.glb"), "_QUALITY");
  ASSERT_EQ(values.size(), 26u);
  EXPECT_THAT(std::vector(values.begin(), values.begin() + 8),
              testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(std::vector(values.begin() + 8, values.end()),
              testing::Each(testing::AllOf(testing::Gt(1), testing::Lt(8))));
  EXPECT_LT(std::ranges::max(scalars(read("p.glb"), "_ERROR")), 1);
  EXPECT_THAT(read("p.ply"), HasSubstr("property float error\nproperty float Quality\n"));
}

TEST_F(Attributes, CurvatureSaysWhatItIsTakenFrom) {
  ASSERT_EQ(fit({"-o", path("p.glb"), "-o", path("p.ply"), "--attributes", "curvature"}).exit_code,
            0);
  EXPECT_EQ(scalars(read("p.glb"), "_GAUSSIAN_CURVATURE").size(), 625u);
  EXPECT_THAT(read("p.glb"), HasSubstr(R"("curvature_from":"second derivatives")"));
  EXPECT_THAT(read("p.ply"), HasSubstr("comment planish curvature_from=second derivatives\n"));
  EXPECT_THAT(read("p.ply"),
              HasSubstr("property float mean_curvature\nproperty float gaussian_curvature\n"));
}

TEST_F(Attributes, FilesThatCannotHoldThemAreRefused) {
  const ProcessResult result = fit({"-o", path("p.obj"), "--attributes", "fold"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("p.obj cannot hold them; .glb, .gltf, .ply and .usda can"));
  EXPECT_THAT(fit({"-o", path("p.glb"), "--attributes", "error,curvatur"}).err,
              HasSubstr("\"curvatur\" is not one of error, deviation, fold, curvature; did you "
                        "mean curvature?"));
}

TEST_F(Attributes, ASceneNamesThemToo) {
  write("s.json", R"({"version": 1, "jobs": [{"input": "plate.obj", "device": "cpu",
      "attributes": "fold", "outputs": [{"path": "p.glb"}]}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  for (const float share : scalars(read("p.glb"), "_FOLD")) EXPECT_EQ(share, 0.0f);
}

}  // namespace
}  // namespace planish::test
