// Scripts of moves, drawn off-screen: the surface that is drawn is that of a fit of the moved mesh,
// and what is taken back looks as it did.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>

#include "planish/core/error.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "viewer/edit_session.h"
#include "viewer/fixture.h"
#include "viewer/headless.h"

namespace planish::testing {
namespace {

using namespace viewer;
using ::testing::HasSubstr;

class EditPictureTest : public ViewerTest {
 protected:
  void SetUp() override {
    ViewerTest::SetUp();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    std::filesystem::remove_all(folder_);
    ViewerTest::TearDown();
  }

  static Scene torus_scene() {
    Scene scene = scene_of(test::torus(24, 12, 2, 0.7));
    scene.system.sharp.use_tags = true;
    return scene;
  }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }

  // The bytes of a picture that a script wrote.
  [[nodiscard]] std::string bytes(const std::string& name) const {
    std::ifstream stream(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  void run(const std::string& text, EditSession& session, Headless& headless) const {
    run_script(parse_script(text, "s.txt"), session, headless, {});
  }

  // What is drawn, against a fit of the mesh as it is now.
  static void expect_surface_of_points(const EditSession& session, const Headless& headless) {
    const PolygonMesh mesh = session.editor().mesh(), rest = session.rest();
    const auto backend = make_cpu_backend();
    FitOptions options;
    options.sharp.use_tags = true;
    EvaluateOptions evaluation;
    evaluation.level = headless.system().level();
    evaluation.sharp.use_tags = true;
    evaluation.rest_positions = rest.positions;
    const SurfaceMesh surface = evaluate(fit(mesh, *backend, options).cage, *backend, evaluation);
    const auto drawn = headless.vertices();
    ASSERT_EQ(drawn.size(), surface.positions.size());
    for (std::size_t i = 0; i < drawn.size(); ++i)
      ASSERT_LT(glm::distance(glm::dvec3(drawn[i].position), surface.positions[i]),
                4e-6 * session.diagonal())
          << i;
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("planish_viewer_edit_" +
       std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(EditPictureTest, WhatIsTakenBackLooksAsItDid) {
  const Scene scene = torus_scene();
  EditSession session(scene);
  Headless headless(*device_, scene, options_for(scene.mesh));
  run("pick 80 85\nradius 0.9\npicture " + file("first.png") + "\nmove 0 0.4 0 6\npicture " +
          file("moved.png"),
      session, headless);
  expect_surface_of_points(session, headless);
  run("vertices 7 8\nmove 0.1 0 0 2\nundo 2\npick 80 85\npicture " + file("undone.png") +
          "\nredo\npicture " + file("redone.png"),
      session, headless);
  EXPECT_EQ(bytes("first.png"), bytes("undone.png"));
  EXPECT_EQ(bytes("moved.png"), bytes("redone.png"));
  EXPECT_NE(bytes("first.png"), bytes("moved.png"));
  EXPECT_GT(bytes("first.png").size(), 1000u);
}

TEST_F(EditPictureTest, ADraggedPointStaysUnderThePixel) {
  const Scene scene = torus_scene();
  EditSession session(scene);
  const HeadlessOptions options = options_for(scene.mesh);
  Headless headless(*device_, scene, options);
  EditHand hand(session);
  const float aspect = 160.0f / 120;
  const glm::vec2 size(160, 120), from(80.0f, 85.0f), to(90.0f, 100.0f);
  const auto vertex = hand.vertex_at(options.camera, aspect, (from + 0.5f) / size);
  ASSERT_TRUE(vertex);
  const auto place = [&] {
    return size * *options.camera.place_of(session.points()[*vertex], aspect);
  };
  const glm::vec2 before = place();
  run("drag 80 85 90 100 8\n", session, headless);
  EXPECT_LT(glm::distance(place(), before + to - from), 0.01f);
  EXPECT_EQ(session.selected().front(), *vertex);
  // The frame that was drawn last has the point where it is, within what warm iterations leave.
  const glm::dvec3 drawn(headless.vertices()[*vertex].position);
  const glm::dvec3 at = session.points()[*vertex];
  EXPECT_LT(glm::distance(drawn, at), 1e-4 * session.diagonal());
  // Picked there again, though the mesh is another.
  EXPECT_EQ(hand.vertex_at(options.camera, aspect, place() / size), *vertex);
}

TEST_F(EditPictureTest, CreasesAreOtherRulesOfTheSurface) {
  const Scene scene = torus_scene();
  EditSession session(scene);
  HeadlessOptions options = options_for(scene.mesh);
  Headless headless(*device_, scene, options);
  run("picture " + file("smooth.png"), session, headless);
  const std::int32_t rows = headless.system().vertex_count();
  // All the way around.
  std::string tags;
  for (int i = 0; i < 12; ++i)
    tags += "crease " + std::to_string(i) + " " + std::to_string((i + 1) % 12) + "\n";
  run(tags + "vertices 3\nmove 0 0 0.3 3\npicture " + file("creased.png"), session, headless);
  EXPECT_GT(headless.system().vertex_count(), rows);
  expect_surface_of_points(session, headless);
  run("undo 13\nvertices 40\npicture " + file("again.png") + "\n", session, headless);
  EXPECT_EQ(headless.system().vertex_count(), rows);
  expect_surface_of_points(session, headless);
}

TEST_F(EditPictureTest, NamesTheLineThatCannotBeDone) {
  const Scene scene = torus_scene();
  EditSession session(scene);
  Headless headless(*device_, scene, options_for(scene.mesh));
  const std::vector<std::pair<std::string, std::string>> cases{
      {"pick 0 0", "s.txt:1: no vertex is under pixel 0 0"},
      {"\ncrease at 0 0", "s.txt:2: no edge is under pixel 0 0"},
      {"undo", "s.txt:1: there is nothing left to take back"},
      {"redo", "s.txt:1: there is nothing left to do again"},
      {"move 1 0 0", "s.txt:1: nothing is selected; pick a vertex first"},
      {"vertices 288", "s.txt:1: there is no vertex 288; the mesh has 0 to 287"},
      {"radius -1", "s.txt:1: the radius"},
      {"crease 0 99", "s.txt:1: set_sharp: vertices 0 and 99 have no edge"},
      {"save surface " + file("a.obj"), "surfaces are saved as .glb"},
      {"picture /no/such/folder/a.png", "s.txt:1: /no/such/folder"}};
  for (const auto& [text, part] : cases) {
    try {
      run(text, session, headless);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

}  // namespace
}  // namespace planish::testing
