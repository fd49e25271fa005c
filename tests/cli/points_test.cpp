#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>
#include <random>
#include <set>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/glb_bytes.h"
#include "planish/core/json.h"
#include "planish/files/mesh_file.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Points : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("planish_points_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream cloud(path("torus.xyz"));
    cloud.precision(17);
    std::mt19937 random(4);
    for (int i = 0; i < 3000; ++i) {
      const double u = 2 * M_PI * random() * 0x1p-32, v = 2 * M_PI * random() * 0x1p-32;
      const double ring = 1 + 0.4 * std::cos(v);
      cloud << ring * std::cos(u) << ' ' << ring * std::sin(u) << ' ' << 0.4 * std::sin(v) << '\n';
    }
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] nlohmann::json json(const std::string& name) const {
    std::ifstream file(path(name));
    return nlohmann::json::parse(file);
  }

  fs::path folder_;
};

TEST_F(Points, WithoutTheMesherEndInExitSix) {
  const PlanishProcess::Options missing{.environment = {"PLANISH_RECONSTRUCT=/nonexistent"}};
  for (const char* command : {"fit", "reconstruct"}) {
    const auto result = run_planish({command, path("torus.xyz"), "-o", path("m.obj")}, missing);
    EXPECT_EQ(result.exit_code, 6);
    EXPECT_THAT(result.err, HasSubstr("planish-reconstruct"));
    EXPECT_FALSE(fs::exists(path("m.obj")));
  }
}

#ifdef PLANISH_HAS_MESHER
TEST_F(Points, BecomeAMeshWithAReport) {
  const auto result = run_planish({"reconstruct", path("torus.xyz"), "-o", path("m.obj"),
                                   "--report", path("r.json"), "--tolerance-mesh", "5e-3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto facts = json("r.json")["reconstruction"];
  EXPECT_EQ(facts["points"], 3000);
  EXPECT_EQ(facts["genus"], 1);
  EXPECT_EQ(facts["boundary_loops"], 0);
  EXPECT_LE(facts["max_point_distance"], 5e-3);
  EXPECT_LT(facts["vertices"], 2000);
  EXPECT_EQ(run_planish({"inspect", path("m.obj")}).exit_code, 0);
}

TEST_F(Points, ColorsAndNumbersArriveAtTheSurface) {
  constexpr int kPoints = 600;
  std::ofstream cloud(path("ball.ply"));
  cloud.precision(17);
  cloud << "ply\nformat ascii 1.0\nelement vertex " << kPoints
        << "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
           "property uchar green\nproperty uchar blue\nproperty float intensity\nend_header\n";
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1 - (2 * i + 1.0) / kPoints, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    cloud << r * std::cos(angle) << ' ' << r * std::sin(angle) << ' ' << z << ' ' << i % 256
          << " 40 " << i % 2 * 255 << ' ' << 0.5 * i << '\n';
  }
  cloud.close();
  ASSERT_EQ(
      run_planish({"fit", path("ball.ply"), "-o", path("ball.glb"), "-o", path("s.ply")}).exit_code,
      0);
  const PolygonMesh surface = read_mesh(path("s.ply")).mesh;
  ASSERT_EQ(surface.colors.size(), surface.positions.size());
  // Given points come first in a surface, in the mesh's order.
  const PointCloud given = read_points(path("ball.ply"));
  ASSERT_EQ(given.colors.size(), kPoints);
  ASSERT_EQ(surface.attributes.size(), 1u);
  EXPECT_EQ(surface.attributes[0].name, "intensity");
  std::set<std::size_t> found;
  for (int v = 0; v < kPoints; ++v) {
    const auto nearest = std::ranges::min_element(given.points, {}, [&](const glm::dvec3& point) {
      return glm::distance(surface.positions[v], point + given.origin);
    });
    const auto i = static_cast<std::size_t>(nearest - given.points.begin());
    ASSERT_LT(glm::distance(surface.positions[v], *nearest + given.origin), 1e-6);
    EXPECT_LT(glm::distance(surface.colors[v], given.colors[i]), 0.01f) << i;
    EXPECT_EQ(surface.attributes[0].values[v], 0.5f * static_cast<float>(i));
    found.insert(i);
  }
  EXPECT_EQ(found.size(), kPoints);
  const auto glb = read_mesh(path("ball.glb")).mesh;
  EXPECT_EQ(glb.colors.size(), glb.positions.size());
  std::ifstream bytes(path("ball.glb"), std::ios::binary);
  const auto document = document_of({std::istreambuf_iterator<char>(bytes), {}});
  EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("_INTENSITY"));
  // The mesh has them too, and inspecting the cloud names them.
  ASSERT_EQ(run_planish({"reconstruct", path("ball.ply"), "-o", path("m.ply")}).exit_code, 0);
  EXPECT_EQ(read_mesh(path("m.ply")).mesh.attributes.size(), 1u);
  EXPECT_EQ(
      nlohmann::json::parse(run_planish({"inspect", path("ball.ply"), "--json"}).out)["attributes"],
      nlohmann::json::parse(R"(["intensity"])"));
}

TEST_F(Points, BecomeASurfaceWhoseDistanceIsReported) {
  const auto result = run_planish({"fit", path("torus.xyz"), "-o", path("s.glb"), "--report",
                                   path("r.json"), "--tolerance-mesh", "2e-3", "--device", "cpu"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto report = json("r.json");
  EXPECT_EQ(report["solve"]["method"], "fair");  // what auto means for points
  EXPECT_EQ(report["surface"]["folded_area"], 0.0);
  EXPECT_GT(report["surface"]["max_point_distance"], 0);
  EXPECT_LT(report["surface"]["max_point_distance"], 0.05);
  EXPECT_LE(report["surface"]["rms_point_distance"], report["surface"]["max_point_distance"]);
  EXPECT_EQ(report["input"]["vertices"], report["reconstruction"]["vertices"]);
}

TEST_F(Points, AreInputsOfScenes) {
  std::ofstream(path("s.json"))
      << R"({"version":1,"jobs":[{"name":"ring","input":"torus.xyz","report":"r.json","device":"cpu",
             "tolerance_mesh":5e-3}]})";
  const auto result = run_planish({"run", path("s.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::ContainsRegex("\nring +3,000 "));
  EXPECT_EQ(json("r.json")["reconstruction"]["genus"], 1);
}

TEST_F(Points, NameWhatIsWrongWithThem) {
  std::ofstream(path("line.xyz")) << "0 0 0\n1 1 1\n2 2 2\n3 3 3\n4 4 4\n";
  auto result = run_planish({"reconstruct", path("line.xyz"), "-o", path("m.obj")});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("on a line"));
  std::ofstream(path("none.xyz")) << "5.6e-45 0 0\n1 0 1\n0 1 2\n1 1 3\n";
  result = run_planish({"reconstruct", path("none.xyz"), "-o", path("m.obj")});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_THAT(result.err, HasSubstr("no surface was found in 4 points"));
  std::ofstream(path("bad.xyz")) << "0 0 0\n1 x 1\n";
  result = run_planish({"reconstruct", path("bad.xyz"), "-o", path("m.obj")});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("bad.xyz:2"));
  result = run_planish({"reconstruct", path("torus.xyz"), "-o", path("m.obj"), "--spacing", "evn"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("did you mean even?"));
  EXPECT_FALSE(fs::exists(path("m.obj")));
}
#endif

}  // namespace
}  // namespace planish::test
