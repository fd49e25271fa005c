// What files bring along and get beside them: normals, materials, axes.
#include <gmock/gmock.h>

#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class Formats : public FolderTest {
 protected:
  ProcessResult fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--device", "cpu"});
    return run_planish(flags);
  }
};

// A box of a flat normal on each side, and the same smooth.
std::string box_obj(bool is_flat) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(i & 1) + " " + std::to_string(i >> 1 & 1) + " " +
            std::to_string(i >> 2) + "\n";
  text += "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n";
  int side = 0;
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    ++side;
    text += "usemtl " + std::string(side < 3 ? "lid" : "wall") + "\nf";
    for (const char* c = face; *c != '\0'; c += c[1] == '\0' ? 1 : 2)
      text += std::string(" ") + *c + (is_flat ? "//" + std::to_string(side) : "");
    text += "\n";
  }
  return text;
}

TEST_F(Formats, SplitNormalsAreCreases) {
  const std::string flat = write("flat.obj", box_obj(true));
  ASSERT_EQ(fit(flat, {"--creases", "normals", "--cage", path("cage.obj"), "--report",
                       path("r.json"), "--levels", "1", "-o", path("a.ply")})
                .exit_code,
            0);
  EXPECT_EQ(read_json("r.json")["solve"]["creases"], "normals");
  EXPECT_EQ(read_json("r.json")["input"]["sharp_edges"], 12);
  EXPECT_THAT(read("cage.obj"), HasSubstr("planish creases=normals"));
  // The cage names the rule, so that the input is read by it again.
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), flat}).exit_code, 0);
  const ProcessResult other =
      run_planish({"verify", path("cage.obj"), flat, "--creases", "ignore"});
  EXPECT_EQ(other.exit_code, 5);

  const ProcessResult smooth =
      fit(write("smooth.obj", box_obj(false)),
          {"--creases", "normals", "--cage", path("b.obj"), "--levels", "0", "-o", path("b.ply")});
  EXPECT_EQ(smooth.exit_code, 0);
  EXPECT_THAT(smooth.err, HasSubstr("smooth.obj: --creases normals found no edge where normals"));
}

TEST_F(Formats, SceneFilesTakeSplitNormals) {
  write("flat.obj", box_obj(true));
  write("scene.json", R"({"version":1,"defaults":{"device":"cpu"},"jobs":[{"name":"box",)"
                      R"("input":"flat.obj","creases":"normals","report":"r.json",)"
                      R"("outputs":[{"path":"a.ply","levels":[0]}]}]})");
  const ProcessResult result = run_planish({"run", path("scene.json")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json("r.json")["input"]["sharp_edges"], 12);
}

TEST_F(Formats, MaterialsOfObjLieBesideIt) {
  const std::string box = write("in/box.obj", box_obj(false));
  ASSERT_EQ(fit(box, {"-o", path("a.obj"), "--cage", path("c.obj"), "--levels", "0"}).exit_code, 0);
  EXPECT_THAT(read("a.obj"), HasSubstr("mtllib a.mtl\n"));
  EXPECT_THAT(read("c.obj"), HasSubstr("mtllib c.mtl\n"));
  EXPECT_THAT(read("a.mtl"), HasSubstr("newmtl lid\nKd "));
  EXPECT_THAT(read("c.mtl"), HasSubstr("newmtl wall\nKd "));
  // What exists is not touched without --force.
  write("d.mtl", "precious");
  const ProcessResult refused = fit(box, {"-o", path("d.obj"), "--levels", "0"});
  EXPECT_EQ(refused.exit_code, 7);
  EXPECT_THAT(refused.err, HasSubstr("d.mtl exists; --force overwrites it"));
  EXPECT_EQ(read("d.mtl"), "precious");
  EXPECT_THAT(fit(box, {"-o", path("d.obj"), "--levels", "0", "--dry-run"}).out,
              HasSubstr("would refuse " + path("d.mtl") + " exists"));
  EXPECT_THAT(fit(box, {"-o", path("n.obj"), "--levels", "0", "--dry-run"}).out,
              HasSubstr("n.mtl  (its materials)"));
  EXPECT_EQ(fit(box, {"-o", path("d.obj"), "--levels", "0", "-f"}).exit_code, 0);
  EXPECT_THAT(read("d.mtl"), HasSubstr("newmtl lid"));
  // Nothing is written where there is no material.
  write("e.mtl", "precious");
  EXPECT_EQ(fit(write("plain.obj", bumpy_plate_obj(4)), {"-o", path("e.obj"), "-f"}).exit_code, 0);
  EXPECT_EQ(read("e.mtl"), "precious");
  EXPECT_THAT(read("e.obj"), Not(HasSubstr("mtllib")));
}

TEST_F(Formats, UsdSaysWhichAxisIsUp) {
  const std::string plate = write("plate.obj", bumpy_plate_obj(4));
  for (const std::string axis : {"y", "z"}) {
    ASSERT_EQ(fit(plate, {"-o", path(axis + ".usda"), "--up", axis, "--levels", "0"}).exit_code, 0);
    EXPECT_THAT(read(axis + ".usda"), HasSubstr(axis == "y" ? "upAxis = \"Y\"" : "upAxis = \"Z\""));
  }
  // Turned by its reader, not by us.
  const std::string y = read("y.usda"), z = read("z.usda");
  EXPECT_EQ(y.substr(y.find("def Xform")), z.substr(z.find("def Xform")));
}

// As they stand in the input's own file, textures named from where the output stands; a material
// that nobody knows gets a colour.
TEST_F(Formats, MaterialsOfAnObjComeAlong) {
  std::filesystem::create_directory(path("model"));
  std::filesystem::create_directory(path("out"));
  const std::string box =
      write("model/box.obj", "mtllib box.mtl\nmtllib gone.mtl\n" + box_obj(false));
  write("model/box.mtl",
        "# of hand\nnewmtl lid\nKd 0.1 0.2 0.3\nmap_Kd -s 2 2 1 -clamp on textures/my lid.png\n"
        "bump -bm 0.5 /abs/bump.png\nnewmtl unused\nKd 1 1 1\n");
  const ProcessResult result =
      fit(box, {"-o", path("out/a.obj"), "--cage", path("out/c.obj"), "--levels", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("out/c.mtl"), read("out/a.mtl"));
  EXPECT_THAT(result.err, testing::AllOf(HasSubstr("its materials are not there: "),
                                         HasSubstr("gone.mtl"), Not(HasSubstr("box.mtl"))));
  const std::string materials = read("out/a.mtl");
  EXPECT_THAT(materials, HasSubstr("newmtl lid\nKd 0.1 0.2 0.3\n"
                                   "map_Kd -s 2 2 1 -clamp on ../model/textures/my lid.png\n"
                                   "bump -bm 0.5 /abs/bump.png\n"));
  EXPECT_THAT(materials, testing::AllOf(HasSubstr("newmtl wall\nKd "), Not(HasSubstr("unused"))));
  // In the same folder every line stays as it is.
  ASSERT_EQ(fit(box, {"-o", path("model/a.obj"), "--levels", "1"}).exit_code, 0);
  EXPECT_THAT(read("model/a.mtl"), HasSubstr("map_Kd -s 2 2 1 -clamp on textures/my lid.png\n"));
  // Those of a cage alone, too.
  ASSERT_EQ(fit(box, {"--cage", path("model/c.obj")}).exit_code, 0);
  EXPECT_EQ(read("model/c.mtl"), read("model/a.mtl"));
  // Where no OBJ is written nobody misses them.
  EXPECT_THAT(fit(box, {"-o", path("out/a.ply")}).err, Not(HasSubstr("materials are not")));
}

}  // namespace
}  // namespace planish::test
