#include "planish/job/try_choices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "support/cut_quads.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;

class TryChoices : public testing::Test {
 protected:
  void take(const PolygonMesh& mesh) {
    write_mesh(folder_.path() / "mesh.obj", FileFormat::Obj, mesh);
    job_.name = job_.label = "mesh";
    job_.input = utf8(folder_.path() / "mesh.obj");
  }
  const Trial& tried(bool has_page = false) {
    bytes_.clear();
    trial_ = try_choices(
        job_, *backend_, {}, has_page,
        [&](const TriedSurface& one, std::string_view bytes) { bytes_[one.stem] = bytes; });
    return trial_;
  }
  // Of the file that the job makes with more settings.
  std::string bytes_of(const std::vector<std::pair<std::string, std::string>>& settings) {
    Job job = job_;
    apply_settings(std::vector<NamedSetting>(settings.begin(), settings.end()), job.settings);
    job.outputs = {surface_request(job.settings, "-", "-o")};
    std::string all;
    JobWatch watch;
    watch.write = [&](std::string_view bytes) { all += bytes; };
    (void)run(job, *backend_, watch);
    return all;
  }
  std::set<std::string> stems() const {
    std::set<std::string> all;
    for (const TriedSurface& one : trial_.surfaces) all.insert(one.stem);
    return all;
  }

  TemporaryFolder folder_;
  const std::unique_ptr<Backend> backend_ = make_cpu_backend({.thread_count = 2});
  Job job_;
  Trial trial_;
  std::map<std::string, std::string> bytes_;
};

// Edges of a low cylinder are found, its sides are halves of quads, random balls get vertices.
std::map<std::string, PolygonMesh> meshes() {
  const PolygonMesh torus = cut_quads(test::torus(16, 8, 1, 0.4));
  const PolygonMesh ball = jittered(icosphere(2), 0.05, 3);
  PolygonMesh tagged = torus;
  for (std::int32_t i = 0; i < 16; ++i)
    tagged.creases.push_back({tagged.face(2 * i)[0], tagged.face(2 * i)[1]});
  return {{"torus", torus},
          {"ball", ball},
          {"box", cut_quads(cube())},
          {"tagged", tagged},
          {"quads", test::torus(12, 6, 1, 0.4)}};
}

TEST_F(TryChoices, EachSurfaceIsWhatItsSettingsGiveAndTheTakenOneTheJobsOwn) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    take(mesh);
    const Trial& trial = tried();
    ASSERT_GE(trial.surfaces.size(), 2u);
    const std::string own = bytes_of({});
    EXPECT_TRUE(trial.surfaces.front().is_taken);
    for (const TriedSurface& one : trial.surfaces) {
      SCOPED_TRACE(one.title);
      EXPECT_EQ(one.failure, "");
      EXPECT_EQ(bytes_of(one.settings), bytes_[one.stem]);
      EXPECT_EQ(bytes_[one.stem] == own, one.is_taken);
      EXPECT_THAT(stems_to_try(job_.settings), Contains(one.stem));
    }
  }
}

// What the report of the job says of those that it made itself.
TEST_F(TryChoices, CostsAreThoseOfTheChoice) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    take(mesh);
    const Trial& trial = tried();
    const TriedSurface& taken = trial.surfaces.front();
    ASSERT_TRUE(taken.report.fit.choice);
    int compared = 0;
    for (const Candidate& candidate : taken.report.fit.choice->candidates) {
      if (!candidate.is_measured()) continue;
      const auto found = std::ranges::find_if(trial.surfaces, [&](const TriedSurface& one) {
        const FitFigures& fit = one.report.fit;
        const CandidateFaces faces = fit.added > 0    ? CandidateFaces::Refined
                                     : fit.joined > 0 ? CandidateFaces::Quads
                                                      : CandidateFaces::Given;
        return faces == candidate.faces && fit.method == candidate.method &&
               fit.creases == taken.report.fit.creases;
      });
      ASSERT_NE(found, trial.surfaces.end());
      EXPECT_DOUBLE_EQ(found->cost.sum(), candidate.cost());
      EXPECT_EQ(found->bending, candidate.bending);
      EXPECT_EQ(found->folded, candidate.folded_area);
      ++compared;
    }
    EXPECT_TRUE(compared >= 2 || compared == 0) << compared;
  }
}

TEST_F(TryChoices, MakesWhatTheChoiceSaves) {
  take(meshes()["torus"]);
  (void)tried();
  EXPECT_THAT(stems(), IsSupersetOf({"given_progressive_auto", "given_fair_auto",
                                     "quads_progressive_auto", "quads_fair_auto"}));
  take(meshes()["tagged"]);
  (void)tried();
  EXPECT_THAT(stems(), IsSupersetOf({"quads_fair_use", "quads_fair_ignore"}));
  // Without triangles there is nothing to join.
  take(meshes()["quads"]);
  (void)tried();
  EXPECT_THAT(stems(), testing::Each(testing::Not(HasSubstr("quads"))));
}

TEST_F(TryChoices, ASurfaceHasAPictureAndAPartOfThePage) {
  take(cut_quads(cube()));
  for (const TriedSurface& one : tried(true).surfaces) {
    EXPECT_FALSE(one.picture.empty());
    EXPECT_FALSE(one.page.payloads.empty());
    EXPECT_EQ(one.page.report["job"], one.title);
  }
}

TEST_F(TryChoices, SettingsThatAreNamedStay) {
  take(meshes()["torus"]);
  apply_settings(
      std::vector<NamedSetting>{{"quads", "on"}, {"interpolation", "fair"}, {"creases", "use"}},
      job_.settings);
  EXPECT_THROW((void)tried(), Error);
  job_.settings.interpolation = InterpolationChoice::Auto;
  (void)tried();
  EXPECT_EQ(stems(), (std::set<std::string>{"fair", "progressive"}));
}

// Of two parts one wants quads and one its triangles: no flags say so.
TEST_F(TryChoices, WhatNoFlagsNameHasACardOfItsOwn) {
  PolygonMesh ball = delaunay_sphere(300, 2);
  for (glm::dvec3& p : ball.positions) p.x += 3;
  const PolygonMesh parts[] = {meshes()["torus"], ball};
  take(merged_meshes(parts).mesh);
  const TriedSurface& taken = tried().surfaces.front();
  EXPECT_TRUE(taken.is_taken);
  EXPECT_EQ(taken.stem, "default");
  EXPECT_TRUE(taken.settings.empty());
  EXPECT_EQ(bytes_["default"], bytes_of({}));
  EXPECT_DOUBLE_EQ(taken.cost.sum(), taken.report.fit.choice->best().cost());
}

}  // namespace
}  // namespace planish::test
