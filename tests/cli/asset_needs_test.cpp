// How far an asset of several meshes is, and what of memory it takes.
#include <sys/resource.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

#include "cli/needs.h"
#include "files/gltf/large_asset.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::ContainsRegex;

// Meshes are held together, whatever rides on them, and so are their surfaces.
TEST_F(Needs, OfAllMeshesOfAnAsset) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(40, 30, 1.0, 0.4);
  write("many.glb", large_asset(std::vector<PolygonMesh>(6, ring)));
  write("small.glb", large_asset(std::vector<PolygonMesh>(30, small)));
  write("skins.glb", large_asset({ring, ring}, {{.joints = 40}, {.targets = 8}}));
  // Weights of joints take more by one method than by the other: what is left open is enough for
  // either.
  for (const auto& [input, method] : {std::pair{"many.glb", "auto"},
                                      {"small.glb", "auto"},
                                      {"skins.glb", "auto"},
                                      {"skins.glb", "progressive"},
                                      {"skins.glb", "fair"}})
    for (const std::vector<std::string>& how : {std::vector<std::string>{"--levels", "1"},
                                                {"--levels", "2"},
                                                {"--compress", "meshopt"},
                                                {"--chord-error", "1e-4"}}) {
      std::vector<std::string> arguments{input, "-o", "a.glb", "--interpolation", method};
      arguments.insert(arguments.end(), how.begin(), how.end());
      expect_enough(arguments, input != std::string("skins.glb") || method != std::string("auto"));
    }
}

// A limit that each mesh would keep by itself, before anything is fitted.
TEST_F(Needs, OfAllMeshesAreRefusedTogether) {
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4);
  write("one.glb", large_asset({ring}));
  write("many.glb", large_asset(std::vector<PolygonMesh>(12, ring)));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit small = before;
  small.rlim_cur = rlim_t{3} << 30;
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &small), 0);
  const std::vector<std::string> how{"-o", "a.glb", "--levels", "5", "--dry-run"};
  std::vector<std::string> one{"one.glb"}, many{"many.glb"};
  one.insert(one.end(), how.begin(), how.end());
  many.insert(many.end(), how.begin(), how.end());
  const ProcessResult fits = fit(one), refused = fit(many);
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(fits.exit_code, 0) << fits.out;
  EXPECT_EQ(refused.exit_code, 6) << refused.out;
  EXPECT_THAT(refused.out, ContainsRegex("level 5 of 12 meshes needs about .* --levels [0-4] "
                                         "fits"));
}

// Once from 0 to 1 through all of them, and never in a large step.
TEST_F(Forecasts, ProgressRisesThroughAllMeshes) {
  // Large enough that loops go in many pieces.
  const PolygonMesh ring = torus(150, 100, 1.0, 0.4), small = torus(60, 40, 1.0, 0.4);
  write("many.glb", large_asset({ring, small, ring, ring}, {{}, {.joints = 6}, {}, {}}));
  for (const std::vector<std::string>& how : {std::vector<std::string>{"--levels", "2"},
                                              {"--levels", "1", "--compress", "meshopt"},
                                              {"--levels", "2,1", "--lods", "msft"}}) {
    std::vector<std::string> arguments{"many.glb", "-o", "a.glb", "-f", "--progress", "json"};
    arguments.insert(arguments.end(), how.begin(), how.end());
    std::istringstream lines(fit(arguments).err);
    std::vector<double> shares{0};
    std::vector<double> fitting;
    for (std::string line; std::getline(lines, line);) {
      const json entry = json::parse(line, nullptr, false);
      if (entry.is_discarded() || !entry.contains("share")) continue;
      shares.push_back(entry["share"]);
      if (entry["step"] == "stencils") fitting.push_back(shares.back());
    }
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_GE(shares.back(), 0.999) << how.back();
    double largest = 0;
    for (std::size_t i = 1; i < shares.size(); ++i)
      largest = std::max(largest, shares[i] - shares[i - 1]);
    EXPECT_LE(largest, 0.15) << how.back();
    // Each fit begins further on than the one before.
    ASSERT_GE(fitting.size(), 4U);
    EXPECT_GT(fitting.back(), fitting.front() + 0.05);
  }
}

}  // namespace
}  // namespace planish::test
