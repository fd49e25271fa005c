#include "planish/pipeline/fit_steps.h"

#include <gtest/gtest.h>

#include <random>

#include "planish/fair/fold_cure.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Another look asks only for what has changed, and finds what a first one would.
TEST(DeepLook, FindsAgainWhatAFreshOneFinds) {
  const auto backend = make_cpu_backend();
  const std::vector<test::NamedMesh> meshes = {
      {"crumpled", test::jittered(test::icosphere(2), 0.5, 1)},
      {"creased", test::with_random_creases(test::random_open_mesh(5), 0.2, 5)},
      {"torus", test::torus(12, 8, 2, 0.7)}};
  int found = 0;
  for (const auto& [name, mesh] : meshes) {
    FitOptions options;
    options.method = InterpolationMethod::Fair;
    const Fit fitted = fit(mesh, *backend, options);
    const UsedPart used = used_part(mesh, fitted.prepared);
    const MeshTopology& topology = *used.prepared->topology;
    LevelOne level_one = fitted.fair->level_one;
    DeepLook look(used.mesh, topology, *fitted.features, options.weights);
    std::mt19937 random(3);
    for (int round = 0; round < 8; ++round) {
      const DeepFolds again = look.at(level_one);
      const DeepFolds fresh =
          DeepLook(used.mesh, topology, *fitted.features, options.weights).at(level_one);
      EXPECT_EQ(again.at_vertex, fresh.at_vertex) << name << round;
      EXPECT_EQ(again.area, fresh.area) << name << round;
      found += fresh.area > 0 ? 1 : 0;
      // Some points move, of curves too, and in the sixth round all stand as they did at first.
      if (round == 5) level_one = fitted.fair->level_one;
      for (int moved = 0; round != 5 && moved < 3; ++moved) {
        glm::dvec3& point = level_one.state[random() % level_one.state.size()];
        point += 0.02 * glm::dvec3(1.0 - 2.0 * (random() % 2), 1.0 - 2.0 * (random() % 2), 0.5);
      }
    }
  }
  EXPECT_GT(found, 10);
}

// Folds that do not end: nets with ellipses are made from the first ellipse on.
TEST(DeeplyCuredNet, MakesNoNetTwice) {
  for (const int first_ellipse : {0, 2, 100}) {
    int nets = 0, choices = 0;
    double area = 1;
    std::vector<std::vector<std::uint8_t>> asked;
    const FairNet net =
        deeply_cured_net({.make_net =
                              [&](const FairDecisions* decisions) {
                                ++nets;
                                FairNet made;
                                if (decisions) made.decisions = *decisions;
                                made.decisions.cures.resize(2, 0);
                                if (decisions) asked.push_back(decisions->cures);
                                made.decisions.leans.assign(2, glm::vec2(static_cast<float>(nets)));
                                return made;
                              },
                          .folds_of =
                              [&](FairNet&) {
                                return DeepFolds{{1, 0}, area *= 0.8};
                              },
                          .choose_ellipses =
                              [&](std::span<const std::uint8_t>, FairDecisions&) {
                                std::vector<std::uint8_t> chosen(2, 0);
                                chosen[0] = choices++ == first_ellipse;
                                return chosen;
                              }});
    // No vertex is cured more often than kMostCures, and then all is done.
    const int with_ellipses = first_ellipse < kMostCures ? 6 - first_ellipse : 0;
    EXPECT_EQ(nets, 1 + kMostCures + with_ellipses);
    EXPECT_EQ(choices, 6);
    EXPECT_EQ(net.rounds.nets, nets);
    // A vertex that has just got its ellipse is not cured in that round.
    if (with_ellipses > 0) {
      EXPECT_EQ(asked[kMostCures][0], first_ellipse);
    }
    EXPECT_EQ(asked[kMostCures - 1][0], kMostCures);
  }
}

}  // namespace
}  // namespace planish
