// What is chosen where the method, creases and quads are left open.
#include "cli/fair_case.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(Fair, AutoTakesWhatFoldsLessAndSaysWhy) {
  const nlohmann::json taken =
      fit(sphere_, {"-o", path("a.ply"), "--refine", "off", "--creases", "use", "--quads", "off"});
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_THAT(messages_, HasSubstr("surface     fair: progressive folds"));
  const nlohmann::json& choice = taken["solve"]["choice"];
  EXPECT_THAT(choice["reason"].get<std::string>(), HasSubstr("fair: progressive folds"));
  ASSERT_EQ(choice["candidates"].size(), 2u);
  const nlohmann::json &fair = choice["candidates"][0], &progressive = choice["candidates"][1];
  EXPECT_EQ(progressive["method"], "progressive");
  EXPECT_EQ(progressive["taken"], false);
  EXPECT_GT(progressive["folded_area_elsewhere"], 1e-4);
  EXPECT_EQ(fair["taken"], true);
  EXPECT_LT(fair["folded_area_elsewhere"], 1e-5);
  EXPECT_LT(fair["cost"], progressive["cost"]);
  // The surface is that of the method asked for by name.
  const nlohmann::json asked =
      fit(sphere_, {"-o", path("f.ply"), "--interpolation", "fair", "--quads", "off"});
  EXPECT_EQ(asked["solve"]["choice"], nullptr);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

// What repair and the cutting of concave faces change of the mesh is told as of a fair fit.
TEST_F(Fair, AutoTakesTheMeshThatItsSurfaceIsOf) {
  const std::string bracket = std::string(PLANISH_SCENES) + "/l_bracket.obj";
  const nlohmann::json taken = fit(bracket, {"-o", path("a.ply"), "--creases", "use"});
  const nlohmann::json asked = fit(bracket, {"-o", path("f.ply"), "--interpolation", "fair"});
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_EQ(taken["input"], asked["input"]);
  EXPECT_EQ(taken["warnings"], asked["warnings"]);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

TEST_F(Fair, AutoTakesCreasesThatAreClear) {
  const std::string bracket = std::string(PLANISH_SCENES) + "/l_bracket.obj";
  const nlohmann::json taken = fit(bracket, {"-o", path("a.ply")});
  EXPECT_THAT(messages_, HasSubstr("18 edges kept sharp"));
  EXPECT_EQ(taken["solve"]["creases"], "auto");
  EXPECT_EQ(taken["solve"]["choice"]["candidates"].size(), 1u) << "no fit that nobody needs";
  EXPECT_LT(taken["surface"]["rms_normal_deviation"], 1e-4);
  const nlohmann::json asked =
      fit(bracket, {"-o", path("f.ply"), "--interpolation", "fair", "--creases", "auto"});
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
  EXPECT_EQ(fit(bracket, {"-o", path("s.ply"), "--creases", "use"})["input"]["sharp_edges"], 0);
  const nlohmann::json named = fit(bracket, {"-o", path("p.ply"), "--interpolation", "fair"});
  EXPECT_EQ(named["input"]["sharp_edges"], 0) << "a named method leaves nothing to choose";
}

// Quads of a torus, cut in two.
TEST_F(Fair, AutoJoinsTrianglesThatAreHalvesOfQuads) {
  std::string obj;
  const auto at = [](int i, int j) { return std::to_string(1 + i % 24 * 12 + j % 12); };
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j < 12; ++j) {
      const double ring = 1 + 0.4 * std::cos(j * M_PI / 6);
      obj += "v " + std::to_string(ring * std::cos(i * M_PI / 12)) + " " +
             std::to_string(ring * std::sin(i * M_PI / 12)) + " " +
             std::to_string(0.4 * std::sin(j * M_PI / 6)) + "\nf " + at(i, j) + " " + at(i + 1, j) +
             " " + at(i + 1, j + 1) + "\nf " + at(i, j) + " " + at(i + 1, j + 1) + " " +
             at(i, j + 1) + "\n";
    }
  const std::string torus = write("torus.obj", obj);
  const nlohmann::json taken = fit(torus, {"-o", path("a.ply")});
  EXPECT_EQ(taken["solve"]["quads"]["joined"], 288);
  EXPECT_EQ(taken["outputs"][0]["quads"], 288 * 16);
  for (const nlohmann::json& candidate : taken["solve"]["choice"]["candidates"])
    EXPECT_EQ(candidate["faces"], "quads") << "that of triangles was not made";
  EXPECT_THAT(messages_, HasSubstr("whose halves they are (--quads off leaves them)"));
  EXPECT_THAT(messages_, HasSubstr("288 vertices, 576 faces, 288 with triangles joined (closed"));
  const nlohmann::json asked = fit(torus, {"-o", path("o.ply"), "--quads", "on"});
  EXPECT_EQ(asked["outputs"][0]["sha256"], taken["outputs"][0]["sha256"]);
  EXPECT_EQ(asked["solve"]["choice"]["faces_reason"], nullptr);
  EXPECT_THAT(messages_, Not(HasSubstr("--quads off")));
  const nlohmann::json left =
      fit(torus, {"-o", path("l.ply"), "--quads", "off", "--refine", "off"});
  EXPECT_EQ(left["outputs"][0]["quads"], 2 * 288 * 12);

  // A cage has the mesh's faces; of quads that were asked for it says so, and verify finds them.
  for (const char* method : {"progressive", "fair"}) {
    for (const char* quads : {"auto", "on"}) {
      fit(torus, {"--cage", path("c.obj"), "--interpolation", method, "--quads", quads});
      const bool is_joined = std::string(quads) == "on";
      EXPECT_THAT(read("c.obj"),
                  HasSubstr(is_joined ? "planish quads=on\n" : "planish quads=off\n"));
      EXPECT_EQ(run_planish({"verify", path("c.obj"), torus}).exit_code, 0) << method;
      EXPECT_EQ(run_planish({"verify", path("c.obj"), torus, "--quads", is_joined ? "off" : "on"})
                    .exit_code,
                4);
    }
  }
  EXPECT_THAT(
      run_planish({"fit", torus, "-o", path("x.ply"), "--scheme", "loop", "--quads", "on"}).err,
      HasSubstr("--quads: loop surfaces are of triangles; take off"));
}

// A part's flat faces do not say what its triangles are: both surfaces are made.
TEST_F(Fair, AutoMeasuresQuadsAgainstTrianglesOfParts) {
  const std::string box =
      write("box.obj",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
            "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\n"
            "f 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n");
  const nlohmann::json choice = fit(box, {"-o", path("b.ply")})["solve"]["choice"];
  ASSERT_EQ(choice["candidates"].size(), 2u);
  for (const nlohmann::json& candidate : choice["candidates"])
    EXPECT_LT(candidate["bending"], 1e-6);
  EXPECT_EQ(choice["faces_reason"],
            "triangles joined to quads: all is flat (--quads off leaves them)");
}

// Its own surface is progressive: of the mesh's faces, and sharp where the other is.
TEST_F(Fair, ACageLeavesTheSurfaceBesideItAlone) {
  for (const std::string& input : {sphere_, write("cube.obj", cube_obj())}) {
    const nlohmann::json alone = fit(input, {"-o", path("a.ply")});
    const nlohmann::json both = fit(input, {"-o", path("p.ply"), "--cage", path("c.obj")});
    EXPECT_EQ(alone["solve"]["method"], "fair") << input;
    EXPECT_EQ(both["outputs"][0]["sha256"], alone["outputs"][0]["sha256"]) << input;
    EXPECT_EQ(both["solve"], alone["solve"]) << input;
    EXPECT_THAT(read("c.obj"), HasSubstr("planish interpolation=progressive\n"));
    EXPECT_EQ(run_planish({"verify", path("c.obj"), input}).exit_code, 0) << input;
    // And the surface beside does not change the cage.
    const nlohmann::json cage = fit(input, {"--cage", path("d.obj")});
    EXPECT_EQ(cage["outputs"][0]["sha256"], both["outputs"][1]["sha256"]) << input;
    EXPECT_EQ(cage["solve"]["method"], "progressive") << input;
    EXPECT_THAT(messages_, HasSubstr("surface     progressive: the control cage"));
  }
  EXPECT_THAT(read("c.obj"), HasSubstr("planish sharp_edges=0-1 "));
}

// Whatever is sharp stands in the header: of a mesh that another version would find others on.
TEST_F(Fair, ACageSaysWhichEdgesAreSharp) {
  const std::string cube = write("cube.obj", cube_obj());
  for (const char* name : {"c.ply", "c.off"}) {
    fit(cube, {"--cage", path(name)});
    std::string cage = read(name);
    EXPECT_EQ(run_planish({"verify", path(name), cube}).exit_code, 0) << name;
    EXPECT_EQ(run_planish({"verify", path(name), cube, "--creases", "auto"}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), cube, "--creases", "use"}).exit_code, 5) << name;
    const std::size_t first = cage.find("0-1 ");
    ASSERT_NE(first, std::string::npos) << name;
    cage.erase(first, 4);
    EXPECT_EQ(
        run_planish({"verify", write(std::string("less") + (name + 1), cage), cube}).exit_code, 5)
        << name;
  }
}

TEST_F(Fair, AutoSparesTheSecondFitOfSmoothMeshes) {
  const std::string plate = write("fine.obj", bumpy_plate_obj(120));
  const nlohmann::json solve = fit(plate, {"-o", path("p.ply")})["solve"];
  EXPECT_EQ(solve["method"], "progressive");
  EXPECT_EQ(solve["choice"]["candidates"].size(), 1u);
  EXPECT_THAT(messages_, HasSubstr("surface     progressive: it does not fold"));
  // At level 0 what was measured for the choice is what the surface is reported with.
  const nlohmann::json chosen = fit(plate, {"-o", path("p.ply"), "--levels", "0"});
  const nlohmann::json asked = fit(plate, {"-o", path("p.ply"), "--levels", "0", "--interpolation",
                                           "progressive", "--creases", "auto:180"});
  EXPECT_EQ(chosen["surface"], asked["surface"]);
}

}  // namespace
}  // namespace planish::test
