#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <set>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/glb_bytes.h"
#include "planish/core/json.h"
#include "planish/files/mesh_file.h"

namespace planish::test {
namespace {

using nlohmann::json;

class Points : public FolderTest {
 protected:
  void SetUp() override {
    std::ostringstream cloud;
    cloud.precision(17);
    std::mt19937 random(4);
    for (int i = 0; i < 3000; ++i) {
      const double u = 2 * M_PI * random() * 0x1p-32, v = 2 * M_PI * random() * 0x1p-32;
      const double ring = 1 + 0.4 * std::cos(v);
      cloud << ring * std::cos(u) << ' ' << ring * std::sin(u) << ' ' << 0.4 * std::sin(v) << '\n';
    }
    write("torus.xyz", cloud.str());
  }
};

TEST_F(Points, WithoutTheMesherEndInExitSix) {
  for (const char* line : {"fit torus.xyz -o m.obj", "reconstruct torus.xyz -o m.obj"}) {
    run(line, 6, {.environment = {"PLANISH_RECONSTRUCT=/nonexistent"}});
    EXPECT_THAT(said_, testing::HasSubstr("planish-reconstruct"));
    EXPECT_FALSE(exists("m.obj"));
  }
}

#ifdef PLANISH_HAS_MESHER
TEST_F(Points, BecomeAMeshWithAReport) {
  run("reconstruct torus.xyz -o m.obj --report r.json --tolerance-mesh 5e-3");
  EXPECT_EQ(report_problems(read_json("r.json"), "reconstruct"), std::vector<std::string>());
  const json facts = read_json("r.json")["reconstruction"];
  expect_values(facts, {{"/points", 3000}, {"/genus", 1}, {"/boundary_loops", 0}});
  EXPECT_LE(facts["max_point_distance"], 5e-3);
  EXPECT_LT(facts["vertices"], 2000);
  run("inspect m.obj");
}

TEST_F(Points, ColorsAndNumbersArriveAtTheSurface) {
  constexpr int kPoints = 600;
  std::ostringstream cloud;
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
  write("ball.ply", cloud.str());
  run("fit ball.ply -o ball.glb -o s.ply");
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
  const json document = document_of(read("ball.glb"));
  EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("_INTENSITY"));
  // The mesh has them too, and inspecting the cloud names them.
  run("reconstruct ball.ply -o m.ply");
  EXPECT_EQ(read_mesh(path("m.ply")).mesh.attributes.size(), 1u);
  EXPECT_EQ(printed("inspect ball.ply --json")["attributes"], json::parse(R"(["intensity"])"));
}

TEST_F(Points, BecomeASurfaceWhoseDistanceIsReported) {
  const json report = report_of("fit torus.xyz -o s.glb --tolerance-mesh 2e-3");
  EXPECT_EQ(report["solve"]["method"], "fair");  // what auto means for points
  EXPECT_EQ(report["surface"]["folded_area"], 0.0);
  EXPECT_GT(report["surface"]["max_point_distance"], 0);
  EXPECT_LT(report["surface"]["max_point_distance"], 0.05);
  EXPECT_LE(report["surface"]["rms_point_distance"], report["surface"]["max_point_distance"]);
  EXPECT_EQ(report["input"]["vertices"], report["reconstruction"]["vertices"]);
}

// A plate of 8 x 6 x 2 with a bore of radius 2, as a scanner sees it: no point on an edge, and
// noise.
TEST_F(Points, OfAPartBecomeTheFacesOfItsSurfaces) {
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, 1e-3);
  const auto within = [&](double most) { return most * (2.0 * random() * 0x1p-32 - 1); };
  std::ostringstream cloud;
  const auto add = [&](double x, double y, double z) {
    cloud << x + noise(random) << ' ' << y + noise(random) << ' ' << z + noise(random) << '\n';
  };
  for (int i = 0; i < 8000; ++i) {
    const double x = within(4), y = within(3);
    if (std::hypot(x, y) > 2) add(x, y, i % 2 == 0 ? 1 : -1);
  }
  for (int i = 0; i < 1600; ++i) {
    add(within(4), i % 2 == 0 ? 3 : -3, within(1));
    if (i % 4 != 0) add(i % 2 == 0 ? 4 : -4, within(3), within(1));
    const double angle = within(std::numbers::pi);
    add(2 * std::cos(angle), 2 * std::sin(angle), within(1));
  }
  write("plate.xyz", cloud.str());
  run("fit plate.xyz -o plate.step --report r.json");
  const json step = read_json("r.json")["outputs"][0]["step"];
  expect_values(step, {{"/faces", 7},
                       {"/solids", 1},
                       {"/analytic/parts", 1},
                       {"/analytic/faces/plane", 6},
                       {"/analytic/faces/cylinder", 1}});
  EXPECT_NEAR(step["analytic"]["radii"][0], 2, 2e-3);
  EXPECT_GT(step["analytic"]["largest_distance"], 2e-3);
  EXPECT_LT(step["analytic"]["largest_distance"], 1e-2);
}

TEST_F(Points, AreInputsOfScenes) {
  write("s.json", R"({"version":1,"jobs":[{"name":"ring","input":"torus.xyz","report":"r.json",
                      "tolerance_mesh":5e-3}]})");
  EXPECT_THAT(run("run s.json").out, testing::ContainsRegex("\nring +3,000 "));
  const json report = read_json("r.json");
  EXPECT_EQ(report_problems(report, "fit"), std::vector<std::string>());
  EXPECT_EQ(report["reconstruction"]["genus"], 1);
}
#endif

}  // namespace
}  // namespace planish::test
