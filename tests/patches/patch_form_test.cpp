// Patches as functions of (u, v): against the templates, which have been held to the tables, and
// against differences of their own values.
#include "planish/patches/patch_form.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "patches/patch_oracle.h"
#include "planish/patches/patch_plan.h"

namespace planish::test {
namespace {

constexpr double kHere = 1e-14;  // of the diagonal, which is 1

struct FormCase : SteppedCase {
  FormCase(const PolygonMesh& given, Weights rule) : SteppedCase(given, rule, 1), forms(rule) {}

  std::vector<glm::dvec3> points_of(std::int32_t corner) {
    return SteppedCase::points_of(patches, patches.corner_patch(corner));
  }
  const PatchForm& form_of(std::int32_t corner) {
    return forms.of(patches.corner_patch(corner).patch);
  }
  PatchPoint at(std::int32_t corner, PatchParameter parameter) {
    PatchPoint point = patch_point(form_of(corner), points_of(corner), parameter, scratch);
    point.position += state[corner];
    return point;
  }

  PatchForms forms;
  PatchScratch scratch;
};

// Two n-gons, and a ring of quads that one of them is cut into triangles at, so that n faces meet.
PolygonMesh drum(std::int32_t n) {
  PolygonMesh mesh;
  for (const double z : {0.0, 0.6}) {
    for (std::int32_t i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(std::cos(angle), (1 + 0.2 * z) * std::sin(angle),
                                  z + 0.05 * std::sin(3 * angle));
    }
  }
  mesh.positions.emplace_back(0.1, 0, 0.9);
  std::vector<std::int32_t> floor;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t next = (i + 1) % n;
    mesh.add_face(std::array{i, next, n + next, n + i});
    mesh.add_face(std::array{n + i, n + next, 2 * n});
    floor.push_back(n - 1 - i);
  }
  mesh.add_face(floor);
  return mesh;
}

std::vector<NamedMesh> form_meshes() {
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"rings of 40", drum(40)});
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    PolygonMesh closed = with_random_creases(random_closed_mesh(seed), 0.1 * seed, seed);
    for (std::int32_t v = 0; v < closed.vertex_count(); v += 7) closed.corners.push_back({v, 10});
    meshes.push_back({"closed " + std::to_string(seed), std::move(closed)});
    meshes.push_back(
        {"open " + std::to_string(seed), with_random_creases(random_open_mesh(seed), 0.15, seed)});
  }
  return meshes;
}

template <class Test>
void for_cases(const Test& test) {
  for (const auto& [name, mesh] : form_meshes()) {
    for (const Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      FormCase c(mesh, weights);
      test(c);
      if (::testing::Test::HasFailure()) return;
    }
  }
}

double sine_between(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(glm::cross(a, b)) / (glm::length(a) * glm::length(b));
}

TEST(PatchForm, AgreesWithTheTemplates) {
  constexpr int kLevel = 4;
  for_cases([](FormCase& c) {
    PatchTemplates templates(c.weights);
    const PatchSamples samples(kLevel);
    const double n = samples.side();
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const PatchTemplate of_class = templates.make(c.patches.corner_patch(corner).patch, kLevel);
      const auto points = c.points_of(corner);
      for (std::int32_t i = 0; i < samples.count(); ++i) {
        const std::int32_t a = i % (samples.side() + 1), b = i / (samples.side() + 1);
        const auto rows = of_class.rows(samples.index(a, b));
        const std::size_t k = points.size() - 1;
        TableSample wanted;
        for (std::size_t j = 0; j < k; ++j) {
          wanted.position += rows[j] * points[j + 1];
          wanted.du += rows[k + j] * points[j + 1];
          wanted.dv += rows[2 * k + j] * points[j + 1];
        }
        const PatchPoint got = patch_point(c.form_of(corner), points, {a / n, b / n}, c.scratch);
        ASSERT_LT(glm::length(got.position - wanted.position), kHere) << corner << " " << i;
        const glm::dvec3 normal = glm::cross(wanted.du, wanted.dv);
        const double condition =
            glm::length(normal) / (glm::length(wanted.du) * glm::length(wanted.dv));
        if (!(condition > 1e-3)) continue;
        ASSERT_GT(glm::dot(got.normal, normal), 0.0) << corner << " " << i;
        ASSERT_LT(sine_between(got.normal, normal), 1e-9) << corner << " " << i;
      }
    }
  });
}

TEST(PatchForm, TakesLargeRingsBySums) {
  constexpr std::int32_t kSize = 500;
  for (const Weights weights : kBothWeights) {
    PatchForms forms(weights);
    for (const PatchClass patch :
         {PatchClass{PatchKind::Smooth, 3, 0, kSize}, PatchClass{PatchKind::Smooth, kSize, 0, 3}}) {
      const PatchForm& form = forms.of(patch);
      for (const PatchStep& step : form.steps) {
        EXPECT_LE(step.rows.columns.size() + step.sums.columns.size(), 14 * kSize);
      }
    }
  }
}

TEST(PatchForm, DerivativesAreThoseOfThePositions) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(0.02, 0.98);
  constexpr double h = 1e-4;
  for_cases([&](FormCase& c) {
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const double u = within(random), v = within(random);
      const PatchPoint p = c.at(corner, {u, v});
      // Seen from the place itself, the polynomial goes on beyond its border.
      const auto at = [&](double du, double dv) { return c.at(corner, {u + du, v + dv, u, v}); };
      const PatchPoint pu = at(h, 0), mu = at(-h, 0), pv = at(0, h), mv = at(0, -h);
      const double scale = 1 + 100 * (glm::length(p.du) + glm::length(p.duu) + glm::length(p.dvv));
      ASSERT_LT(glm::length((pu.position - mu.position) / (2 * h) - p.du), 1e-10 * scale);
      ASSERT_LT(glm::length((pv.position - mv.position) / (2 * h) - p.dv), 1e-10 * scale);
      ASSERT_LT(glm::length((pu.du - mu.du) / (2 * h) - p.duu), 1e-9 * scale);
      ASSERT_LT(glm::length((pu.dv - mu.dv) / (2 * h) - p.duv), 1e-9 * scale);
      ASSERT_LT(glm::length((pv.dv - mv.dv) / (2 * h) - p.dvv), 1e-9 * scale);
    }
  });
}

TEST(PatchForm, IsSmoothAcrossBorders) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> within(0.01, 0.99);
  for_cases([&](FormCase& c) {
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const double t = within(random);
      const auto expect_joined = [&](const PatchPoint& a, const PatchPoint& b) {
        // Across both borders (u, v) continues as (v, -u) turned by a quarter.
        const double size = glm::length(a.du) + glm::length(a.dv);
        ASSERT_LT(glm::length(a.position - b.position), kHere) << corner;
        ASSERT_LT(glm::length(a.du + b.dv), 1e-12 * (1 + size)) << corner;
        ASSERT_LT(glm::length(a.dv - b.du), 1e-12 * (1 + size)) << corner;
      };
      const std::int32_t next = c.topology.next(corner);
      expect_joined(c.at(corner, {1, t}), c.at(next, {t, 1}));
      const std::int32_t across = c.topology.ccw(corner);
      if (across < 0 || c.patches.corner_patch(corner).patch.is_trailing_sharp()) continue;
      expect_joined(c.at(corner, {0, t}), c.at(across, {t, 0}));
    }
  });
}

// At singular places: the exact ones are where those nearby lead to.
TEST(PatchForm, CornersAreLimitsOfWhatLiesAround) {
  std::int32_t singular = 0;
  for_cases([&](FormCase& c) {
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const PatchPoint exact = c.at(corner, {0, 0});
      const double h = std::ldexp(1.0, -18);
      const PatchPoint u = c.at(corner, {h, 0}), v = c.at(corner, {0, h});
      // Averaged weights shrink rings by more than a half (valence above 4), to nearly none.
      const double near = c.weights == Weights::DooSabin ? 1e-5 : 1e-2;
      ASSERT_LT(glm::length(exact.position - u.position), near) << corner;
      if (exact.has_second) continue;
      ++singular;
      ASSERT_EQ(exact.duu, glm::dvec3(0.0));
      if (c.weights != Weights::DooSabin) continue;  // they have none, but for a direction
      const double size = glm::length(exact.du) + glm::length(exact.dv);
      ASSERT_LT(glm::length(exact.du - u.du), 1e-4 * size + 1e-5) << corner;
      ASSERT_LT(glm::length(exact.dv - v.dv), 1e-4 * size + 1e-5) << corner;
    }
  });
  EXPECT_GT(singular, 100);
}

TEST(PatchForm, WeightsGiveTheSamePoint) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> within(0, 1);
  for_cases([&](FormCase& c) {
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const bool at_corner = corner % 5 == 0;
      const double u = at_corner ? 0 : within(random), v = at_corner ? 0 : within(random);
      const auto points = c.points_of(corner);
      const PatchPoint p = patch_point(c.form_of(corner), points, {u, v}, c.scratch);
      const std::vector<double> weights = patch_weights(c.form_of(corner), u, v);
      ASSERT_EQ(weights.size(), 3 * points.size());
      std::array<glm::dvec3, 3> sums{};
      std::array<double, 3> totals{};
      for (std::size_t i = 0; i < weights.size(); ++i) {
        sums[i / points.size()] += weights[i] * points[i % points.size()];
        totals[i / points.size()] += weights[i];
      }
      const double size = 1 + glm::length(p.du) + glm::length(p.dv);
      ASSERT_LT(glm::length(sums[0] - p.position), kHere);
      ASSERT_LT(glm::length(sums[1] - p.du), 1e-12 * size);
      ASSERT_LT(glm::length(sums[2] - p.dv), 1e-12 * size);
      ASSERT_NEAR(totals[0], 1, 1e-13);
    }
  });
}

}  // namespace
}  // namespace planish::test
