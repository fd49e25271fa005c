#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "viewer/edit_session.h"
#include "viewer/fixture.h"
#include "viewer/headless.h"

namespace planish::testing {
namespace {

// Points that are picked, dragged, tagged and taken back, and what is saved of them; scripts as
// text.

using namespace viewer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kAspect = 4.0f / 3;

Scene edited_scene() {
  Scene scene;
  scene.name = "torus";
  scene.mesh = test::torus(24, 12, 2, 0.7);
  return scene;
}

std::vector<glm::dvec3> copied(std::span<const glm::dvec3> points) {
  return {points.begin(), points.end()};
}

TEST(EditSession, PicksTheVertexThatIsSeenAndItsEdges) {
  const Scene scene = edited_scene();
  EditSession session(scene);
  EditHand hand(session);
  const OrbitCamera camera = camera_around(scene.mesh.positions);
  const glm::dvec3 eye(camera.eye(kAspect));
  int seen = 0;
  for (std::int32_t v = 0; v < scene.mesh.vertex_count(); ++v) {
    const glm::dvec3 at = scene.mesh.positions[v];
    const auto place = camera.place_of(at, kAspect);
    ASSERT_TRUE(place);
    const PictureRay ray = camera.ray_through(*place, kAspect);
    // The ray of a point's place goes through the point, to single precision.
    ASSERT_LT(glm::length(glm::cross(ray.direction, at - ray.origin)), 1e-5);
    const auto picked = hand.vertex_at(camera, kAspect, *place);
    const glm::dvec3 from = session.points()[picked.value_or(v)];
    if (picked == v) {
      ++seen;
      continue;
    }
    // Something else is seen there, before it.
    ASSERT_TRUE(picked);
    EXPECT_LT(glm::distance(from, eye), glm::distance(at, eye) + 0.1) << v;
  }
  EXPECT_GT(seen, scene.mesh.vertex_count() / 3);
  EXPECT_FALSE(hand.vertex_at(camera, kAspect, {0.01f, 0.01f}));
  const glm::dvec3 a = scene.mesh.positions[5], b = scene.mesh.positions[6];
  const glm::dvec3 middle = 0.5 * (a + b);
  const glm::dvec3 out = middle - 2.0 * glm::normalize(glm::dvec3(middle.x, middle.y, 0));
  EXPECT_EQ(session.pick_edge({middle + 0.1 * out, -out}), std::pair(5, 6));
  EXPECT_FALSE(session.pick_edge({middle + 0.1 * out, out}));
}

TEST(EditSession, ADragOfManyFramesIsOneStep) {
  const Scene scene = edited_scene();
  EditSession session(scene);
  const auto first = copied(session.points());
  session.select({17});
  session.set_radius(0.8);
  const Selection reached = session.reached();
  EXPECT_GT(reached.vertices.size(), 8u);
  for (int drag = 0; drag < 2; ++drag) {
    session.begin_drag();
    for (int i = 1; i <= 100; ++i) session.drag_to(glm::dvec3(0, 0, 0.002 * i));
    // What moves along is what did when the drag began, though it is farther off by now.
    if (drag == 0) {
      EXPECT_EQ(session.reached().vertices, reached.vertices);
    }
    session.end_drag();
  }
  const auto last = copied(session.points());
  for (std::size_t i = 0; i < reached.vertices.size(); ++i) {
    const auto v = static_cast<std::size_t>(reached.vertices[i]);
    EXPECT_GT(last[v].z, first[v].z);
  }
  EXPECT_NEAR(last[17].z - first[17].z, 0.4, 1e-12);
  EXPECT_LE(session.editor().measured_error(), 1e-6);
  EXPECT_TRUE(session.undo());
  EXPECT_NEAR(session.points()[17].z - first[17].z, 0.2, 1e-12);
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(copied(session.points()), first);
  EXPECT_FALSE(session.undo());
  EXPECT_TRUE(session.redo());
  EXPECT_TRUE(session.redo());
  EXPECT_EQ(copied(session.points()), last);
  EXPECT_FALSE(session.redo());
  // A click that moves nothing is no step.
  session.begin_drag();
  session.end_drag();
  EXPECT_TRUE(session.undo());
  EXPECT_NE(copied(session.points()), last);
}

TEST(EditSession, CreasesAndCornersAreToggledAndTakenBack) {
  Scene scene = edited_scene();
  scene.system.sharp.use_tags = true;
  EditSession session(scene);
  const auto face = scene.mesh.face(40);
  session.toggle_crease(face[0], face[1]);
  session.toggle_corner(face[0]);
  EXPECT_EQ(session.revision(), 2);
  EXPECT_EQ(session.rest().creases.size(), 1u);
  EXPECT_EQ(session.rest().corners.size(), 1u);
  session.toggle_crease(face[1], face[0]);
  EXPECT_TRUE(session.rest().creases.empty());
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.rest().creases.size(), 1u);
  EXPECT_TRUE(session.undo());
  EXPECT_TRUE(session.undo());
  EXPECT_TRUE(session.rest().creases.empty());
  EXPECT_TRUE(session.rest().corners.empty());
  EXPECT_TRUE(session.redo());
  EXPECT_EQ(session.rest().creases.size(), 1u);
  try {
    session.toggle_crease(0, 7);
    FAIL() << "tagged what is no edge";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("vertices 0 and 7 have no edge"));
  }
}

TEST(EditSession, SavesWhatFitsTogether) {
  const auto folder = std::filesystem::temp_directory_path() / "planish_viewer_save";
  std::filesystem::create_directories(folder);
  Scene scene = edited_scene();
  scene.settings.up = UpAxis::Z;  // shown (x, z, -y), saved as it was
  EditSession session(scene);
  session.select({3});
  session.drag_to({0.1, 0.2, 0.3});
  session.end_drag();
  const std::string prefix = (folder / "torus").string();
  EXPECT_THAT(save_all(session, prefix, save_options(scene)), HasSubstr("torus_cage.obj"));
  const PolygonMesh mesh = read_mesh(prefix + ".obj").mesh;
  const MeshFile cage = read_mesh(prefix + "_cage.obj");
  EXPECT_THAT(cage.header, ::testing::Contains(HasSubstr("interpolation=progressive")));
  const glm::dvec3 moved = session.points()[3];
  EXPECT_EQ(mesh.positions[3], glm::dvec3(moved.x, -moved.z, moved.y));
  const auto limit = limit_positions(cage.mesh, Weights::DooSabin, {});
  for (std::size_t v = 0; v < limit.size(); ++v)
    ASSERT_LT(glm::distance(limit[v], mesh.positions[v]), 1e-6 * session.diagonal());
  EXPECT_GT(read_mesh(prefix + ".glb").mesh.vertex_count(), 16 * 24 * 12 - 1);
  EXPECT_THROW(save(session, SavedPart::Surface, folder / "a.obj", {}), Error);
  EXPECT_THROW(save(session, SavedPart::Mesh, folder / "a.glb", {}), Error);
  std::filesystem::remove_all(folder);
}

TEST(EditSession, RefusesWhatIsNotThere) {
  const Scene scene = edited_scene();
  EditSession session(scene);
  EXPECT_THROW(session.select({-1}), Error);
  EXPECT_THROW(session.select({24 * 12}), Error);
  EXPECT_THROW(session.set_radius(-1), Error);
  EXPECT_THROW(session.begin_drag(), Error);
}

TEST(EditScript, ReadsStepsWithTheirLines) {
  const auto script = parse_script(
      "# a comment\n\npick 3 4.5 add  # another\r\nvertices 1 2 3\nradius 0.5\n"
      "move 0 -1 2e-1 10\ndrag 1 2 3 4\ncrease 4 5\ncrease at 6 7\ncorner 8\nundo\nredo 2\n"
      "frames 3\npicture my file.png\nsave cage a.obj\n",
      "s.txt");
  ASSERT_EQ(script.size(), 13u);
  EXPECT_EQ(script[0].where, "s.txt:3");
  EXPECT_EQ(std::get<steps::Pick>(script[0].what).pixel, glm::vec2(3, 4.5f));
  EXPECT_TRUE(std::get<steps::Pick>(script[0].what).adds);
  EXPECT_THAT(std::get<steps::Select>(script[1].what).vertices, ElementsAre(1, 2, 3));
  EXPECT_EQ(std::get<steps::Radius>(script[2].what).length, 0.5);
  EXPECT_EQ(std::get<steps::Move>(script[3].what).way, glm::dvec3(0, -1, 0.2));
  EXPECT_EQ(std::get<steps::Move>(script[3].what).frames, 10);
  EXPECT_EQ(std::get<steps::Drag>(script[4].what).to, glm::vec2(3, 4));
  EXPECT_EQ(std::get<steps::Drag>(script[4].what).frames, 1);
  EXPECT_EQ(std::get<steps::Crease>(script[5].what).v1, 5);
  EXPECT_EQ(std::get<steps::CreaseAt>(script[6].what).pixel, glm::vec2(6, 7));
  EXPECT_EQ(std::get<steps::Corner>(script[7].what).vertex, 8);
  EXPECT_EQ(std::get<steps::Undo>(script[8].what).count, 1);
  EXPECT_EQ(std::get<steps::Redo>(script[9].what).count, 2);
  EXPECT_EQ(std::get<steps::Frames>(script[10].what).count, 3);
  EXPECT_EQ(std::get<steps::Picture>(script[11].what).path, "my file.png");
  EXPECT_EQ(std::get<steps::Save>(script[12].what).part, SavedPart::Cage);
}

TEST(EditScript, NamesTheLineOfWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"jump 1 2", "s.txt:1: 'jump' is no step; planish-viewer --help lists them"},
      {"undo\nmove 1 2", "s.txt:2: a way of three numbers is wanted"},
      {"move 1 2 x", "s.txt:1: a way of three numbers is wanted, not 'x'"},
      {"move 1 2 nan", "is wanted, not 'nan'"},
      {"move 1 2 3 0", "a number of frames from 1 to 10000 is wanted, not 0"},
      {"vertices", "a vertex is wanted"},
      {"vertices 1.5", "a vertex from 0 to"},
      {"undo 1 2", "'2' is too much"},
      {"save all a.obj", "mesh, cage or surface is wanted"},
      {"picture", "a file is wanted"},
      {"# nothing\n", "s.txt: has no step"}};
  for (const auto& [text, part] : cases) {
    try {
      (void)parse_script(text, "s.txt");
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

// Scripts of moves, drawn off-screen: the surface that is drawn is that of a fit of the moved mesh,
// and what is taken back looks as it did.

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
