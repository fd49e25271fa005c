#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "cli/json_schema.h"
#include "cli/needs.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"

namespace planish::test {
namespace {

// What files bring along and get beside them: normals, materials, axes.

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

class Attributes : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

// The scalars of an attribute of a GLB.
std::vector<float> scalars(const std::string& glb, const std::string& name) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const auto document = nlohmann::json::parse(glb.substr(20, length));
  const auto& accessor =
      document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name].get<int>()];
  const auto& view = document["bufferViews"][accessor["bufferView"].get<int>()];
  std::vector<float> values(accessor["count"].get<std::size_t>());
  std::memcpy(values.data(), glb.data() + 28 + length + view["byteOffset"].get<std::size_t>(),
              4 * values.size());
  return values;
}

TEST_F(Attributes, ErrorsInTheFileAreTheReports) {
  ASSERT_EQ(fit({"-o", path("p.glb"), "--report", path("r.json"), "--attributes", "error,deviation",
                 "--interpolation", "progressive"})
                .exit_code,
            0);
  const auto report = read_json("r.json");
  const auto errors = scalars(read("p.glb"), "_ERROR");
  const auto deviations = scalars(read("p.glb"), "_DEVIATION");
  EXPECT_NEAR(*std::ranges::max_element(errors), report["solve"]["error"]["max"].get<double>(),
              1e-9);
  const auto worst = std::ranges::max_element(errors) - errors.begin();
  EXPECT_EQ(worst, report["solve"]["error"]["worst_vertex"]);
  EXPECT_NEAR(*std::ranges::max_element(deviations),
              report["surface"]["max_normal_deviation"].get<double>(), 1e-4);
  EXPECT_THAT(read("p.glb"), Not(HasSubstr("_FOLD")));
}

// A figure that is asked for has its name before a property of the input.
TEST_F(Attributes, PropertiesOfTheInputAreCarried) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      "property float z\nproperty float Quality\nproperty float Error\nelement face 6\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 1 9\n1 0 0 2 9\n1 1 0 3 9\n0 1 0 4 9\n0 0 1 5 9\n1 0 1 6 9\n1 1 1 7 9\n0 1 1 8 9\n"
      "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  plate_ = write("cube.ply", ply);
  const ProcessResult run = fit({"-o", path("p.glb"), "-o", path("p.ply"), "--attributes", "error",
                                 "--levels", "1", "--creases", "use"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("properties of the vertices are left out: Error; fields"));
  const std::vector<float> values = scalars(read("p.glb"), "_QUALITY");
  ASSERT_EQ(values.size(), 26u);
  EXPECT_THAT(std::vector(values.begin(), values.begin() + 8),
              testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(std::vector(values.begin() + 8, values.end()),
              testing::Each(testing::AllOf(testing::Gt(1), testing::Lt(8))));
  EXPECT_LT(std::ranges::max(scalars(read("p.glb"), "_ERROR")), 1);
  EXPECT_THAT(read("p.ply"), HasSubstr("property float error\nproperty float Quality\n"));
}

TEST_F(Attributes, CurvatureSaysWhatItIsTakenFrom) {
  ASSERT_EQ(fit({"-o", path("p.glb"), "-o", path("p.ply"), "--attributes", "curvature"}).exit_code,
            0);
  EXPECT_EQ(scalars(read("p.glb"), "_GAUSSIAN_CURVATURE").size(), 625u);
  EXPECT_THAT(read("p.glb"), HasSubstr(R"("curvature_from":"second derivatives")"));
  EXPECT_THAT(read("p.ply"), HasSubstr("comment planish curvature_from=second derivatives\n"));
  EXPECT_THAT(read("p.ply"),
              HasSubstr("property float mean_curvature\nproperty float gaussian_curvature\n"));
}

TEST_F(Attributes, FilesThatCannotHoldThemAreRefused) {
  const ProcessResult result = fit({"-o", path("p.obj"), "--attributes", "fold"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("p.obj cannot hold them; .glb, .gltf, .ply and .usda can"));
  EXPECT_THAT(fit({"-o", path("p.glb"), "--attributes", "error,curvatur"}).err,
              HasSubstr("\"curvatur\" is not one of error, deviation, fold, curvature; did you "
                        "mean curvature?"));
}

TEST_F(Attributes, ASceneNamesThemToo) {
  write("s.json", R"({"version": 1, "jobs": [{"input": "plate.obj", "device": "cpu",
      "attributes": "fold", "outputs": [{"path": "p.glb"}]}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  for (const float share : scalars(read("p.glb"), "_FOLD")) EXPECT_EQ(share, 0.0f);
}

using testing::AllOf;

class Compress : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

TEST_F(Compress, WrittenErrorsStayWithinTheTolerance) {
  double last = 0;
  for (const std::string mode : {"none", "quantize", "meshopt"}) {
    for (const std::string tolerance : {"1e-4", "1e-6"}) {
      SCOPED_TRACE(mode + " " + tolerance);
      ASSERT_EQ(fit({"-o", path("p.glb"), "--report", path("r.json"), "--compress", mode,
                     "--tolerance", tolerance})
                    .exit_code,
                0);
      const auto output = read_json("r.json")["outputs"][0];
      EXPECT_LE(output["as_written_error"].get<double>(), std::stod(tolerance));
      EXPECT_EQ(output["bytes"], read("p.glb").size());
      if (tolerance == "1e-6") {
        const double bytes = output["bytes"].get<double>();
        if (mode != "none") {
          EXPECT_LT(bytes, last);
        }
        last = bytes;
      }
    }
  }
}

// 16 bits move positions by some 1e-5 of the diagonal, of which the default tolerance leaves less.
TEST_F(Compress, QuantizeSaysWherePositionsStayFloat) {
  const auto said = [&](const std::string& mode, const std::string& tolerance) {
    return fit({"-o", path("p.glb"), "--compress", mode, "--tolerance", tolerance}).err;
  };
  EXPECT_THAT(said("quantize", "1e-6"),
              AllOf(HasSubstr("p.glb: positions stay 32 bits: 16 would move them by up to 9"),
                    HasSubstr("e-06 of the diagonal, and --tolerance leaves ")));
  EXPECT_THAT(said("quantize", "1e-3"), Not(HasSubstr("positions stay")));
  EXPECT_THAT(said("meshopt", "1e-6"), Not(HasSubstr("positions stay")));
}

TEST_F(Compress, OtherFormatsAreRefused) {
  const ProcessResult result = fit({"-o", path("p.obj"), "--compress", "meshopt"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("p.obj is not compressed; .glb, .gltf and 3D Tiles are"));
}

TEST_F(Compress, StdoutIsCompressedToo) {
  const ProcessResult file = fit({"-o", path("p.glb"), "--compress", "meshopt"});
  const ProcessResult piped = fit({"-o", "-", "--compress", "meshopt"});
  EXPECT_EQ(file.exit_code, 0);
  EXPECT_EQ(piped.out.size(), read("p.glb").size());
  EXPECT_THAT(piped.out, HasSubstr("EXT_meshopt_compression"));
}

// What the command does with --bake; what the maps show is tested in tests/pipeline.

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

// A plate whose texture coordinates are its x and y.
std::string mapped_plate(double stretch = 1, int side = 4) {
  std::string lines = "usemtl bark\n";
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const double x = double(i) / side, y = double(j) / side;
      lines += "v " + std::to_string(x) + " " + std::to_string(y) + " " +
               std::to_string(0.4 * x * (1 - x)) + "\nvt " + std::to_string(stretch * x) + " " +
               std::to_string(stretch * y) + "\n";
    }
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      lines += "f";
      for (const int k : {0, 1, side + 2, side + 1}) {
        const std::string number = std::to_string(j * (side + 1) + i + k + 1);
        lines += " " + number + "/" + number;
      }
      lines += "\n";
    }
  return lines;
}

class BakeCommand : public FolderTest {
 protected:
  ProcessResult fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", mapped_plate());
};

TEST_F(BakeCommand, WritesTheMeshItselfWithItsMap) {
  const ProcessResult result =
      fit(plate_, {"-o", path("p.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json report = read_json("r.json");
  EXPECT_THAT(schema_problems(report, json::parse(std::ifstream(PLANISH_REPORT_SCHEMA))),
              IsEmpty());
  const json& output = report["outputs"][0];
  EXPECT_EQ(output["level"], 0);
  EXPECT_EQ(output["vertices"], 25);
  EXPECT_EQ(output["bake"]["size"], 64);
  ASSERT_EQ(output["bake"]["maps"].size(), 1U);
  const json& map = output["bake"]["maps"][0];
  EXPECT_EQ(map["material"], "bark");
  EXPECT_NEAR(map["covered"].get<double>(), 1, 1e-9);
  EXPECT_EQ(map["overlapped"], 0);
  const json document = document_of(read("p.glb"));
  EXPECT_EQ(document["images"][0]["mimeType"], "image/png");
  EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("TANGENT"));
  EXPECT_EQ(document["materials"][0]["normalTexture"]["index"], 0);
  EXPECT_EQ(map["bytes"], document["bufferViews"].back()["byteLength"]);
  // The same on stdout, and in a .gltf whose buffer has the image.
  EXPECT_EQ(fit(plate_, {"-o", "-", "--bake", "64"}).out, read("p.glb"));
  ASSERT_EQ(fit(plate_, {"-o", path("q.gltf"), "--bake", "64"}).exit_code, 0);
  EXPECT_EQ(json::parse(read("q.gltf"))["images"], document["images"]);
  EXPECT_THAT(names(), ElementsAre("p.glb", "plate.obj", "q.bin", "q.gltf", "r.json"));
}

TEST_F(BakeCommand, ScenesDoTheSame) {
  ASSERT_EQ(fit(plate_, {"-o", path("p.glb"), "--bake", "64"}).exit_code, 0);
  write("scene.json", R"({"version": 1, "jobs": [{"input": "plate.obj", "bake": 64,
                          "device": "cpu", "outputs": [{"path": "s.glb"}]}]})");
  const ProcessResult result = run_planish({"run", path("scene.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("s.glb"), read("p.glb"));
}

TEST_F(BakeCommand, RefusesWhatHoldsNoMap) {
  const auto refusal = [&](std::vector<std::string> flags) {
    const ProcessResult result = fit(plate_, std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  for (const std::string name : {"p.stl", "p.obj", "p.ply", "p.step", "p.usda", "tiles.json"})
    EXPECT_THAT(refusal({"-o", path(name), "--bake", "64"}),
                HasSubstr(name + " holds no baked map; .glb and .gltf do"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "15"}), HasSubstr("--bake: 15"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "8193"}),
              AllOf(HasSubstr("--bake: 8193"), HasSubstr("16 to 8192")));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--levels", "2"}),
              HasSubstr("p.glb: a baked map is of level 0, the input's own mesh"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--levels", "1,0"}),
              HasSubstr("a baked map is of level 0"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--chord-error", "0.01"}),
              HasSubstr("a baked map is of level 0"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--refine", "on"}),
              HasSubstr("--refine: a baked map is of the input's own vertices"));
  EXPECT_THAT(refusal({"--report", path("r.json"), "--bake", "64"}),
              HasSubstr("--bake: no surface is written that holds a map"));
  EXPECT_THAT(names(), ElementsAre("plate.obj"));
}

TEST_F(BakeCommand, RefusesMeshesThatNoMapFits) {
  const auto refusal = [&](const std::string& name, const std::string& obj) {
    const ProcessResult result = fit(write(name, obj), {"-o", path("p.glb"), "--bake", "64"});
    EXPECT_EQ(result.exit_code, 4);
    return result.err;
  };
  EXPECT_THAT(refusal("bare.obj", bumpy_plate_obj(4)),
              HasSubstr("bare.obj: has no texture coordinates, by which a map is baked; unwrap"));
  EXPECT_THAT(refusal("tiled.obj", mapped_plate(3)),
              AllOf(HasSubstr("tiled.obj: material `bark`: its texture repeats (face "),
                    HasSubstr("unwrap the mesh into the square from 0 to 1")));
  EXPECT_FALSE(exists("p.glb"));
}

TEST_F(BakeCommand, GivesEachMeshOfAnAssetItsMaps) {
  AssetSample sample;
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()),
          {"-o", path("a.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("2 meshes, first ball: has no texture coordinates"),
                                HasSubstr("it stays without a map")));
  const json report = read_json("r.json");
  EXPECT_THAT(schema_problems(report, json::parse(std::ifstream(PLANISH_REPORT_SCHEMA))),
              IsEmpty());
  const json& maps = report["outputs"][0]["bake"]["maps"];
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0]["mesh"], "tube");
  EXPECT_EQ(maps[0]["material"], "check");
  EXPECT_EQ(maps[1]["material"], "red");
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
  const json given = sample.json, made = document_of(read("a.glb"));
  for (const char* kept : {"nodes", "skins", "animations", "cameras", "scenes"})
    EXPECT_EQ(made[kept].size(), given[kept].size()) << kept;
  const json& primitives = made["meshes"][0]["primitives"];
  for (const json& primitive : primitives) {
    for (const char* name : {"TANGENT", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_1"})
      EXPECT_TRUE(primitive["attributes"].contains(name)) << name;
    EXPECT_EQ(primitive["targets"].size(), 1U);
  }
  // The red material is also that of a mesh without coordinates, which keeps it as it is.
  EXPECT_EQ(primitives[0]["material"], 0);
  EXPECT_EQ(primitives[1]["material"], 3);
  EXPECT_EQ(made["meshes"][2]["primitives"][0]["material"], 1);
  EXPECT_EQ(made["materials"][1], given["materials"][1]);
  EXPECT_EQ(made["materials"][3]["name"], "red");
  // The clear coat of the other one has no normals of its own.
  EXPECT_EQ(
      made["materials"][0]["normalTexture"],
      made["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]);
  EXPECT_EQ(made["images"].size(), 3U);
}

TEST_F(BakeCommand, LiesByTheSetThatTheNormalTextureNames) {
  AssetSample sample;
  sample.json["materials"][0]["normalTexture"] = {{"index", 0}, {"texCoord", 1}, {"scale", 0.5}};
  ASSERT_EQ(fit(write("asset.glb", sample.glb()),
                {"-o", path("a.glb"), "--bake", "64", "--report", path("r.json")})
                .exit_code,
            0);
  const json document = document_of(read("a.glb"));
  // Its scale is in the map.
  EXPECT_EQ(document["materials"][0]["normalTexture"], (json{{"index", 1}, {"texCoord", 1}}));
  // That set has half the width and height.
  const json maps = read_json("r.json")["outputs"][0]["bake"]["maps"];
  EXPECT_NEAR(maps[0]["covered"].get<double>(), 0.125, 1e-6);
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
}

TEST_F(BakeCommand, VariantsOfMaterialsAreTold) {
  AssetSample sample;
  sample.json["extensionsUsed"].push_back("KHR_materials_variants");
  sample.json["extensions"]["KHR_materials_variants"] = {
      {"variants", {{{"name", "a"}}, {{"name", "b"}}}}};
  sample.json["meshes"][0]["primitives"][1]["extensions"]["KHR_materials_variants"] = {
      {"mappings", {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1}}}}}};
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("variants of materials keep the normal textures"));
  const json primitive = document_of(read("a.glb"))["meshes"][0]["primitives"][1];
  EXPECT_EQ(primitive["material"], 3);
  const json& mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
  EXPECT_EQ(mappings[0]["material"], 3);
  EXPECT_EQ(mappings[1]["material"], 2);
}

// Two meshes of one material: each has a copy of its own, the last one the material itself.
TEST_F(BakeCommand, MeshesShareNoMap) {
  AssetSample sample;
  sample.json["meshes"].push_back(sample.json["meshes"][0]);
  sample.json["nodes"].push_back({{"mesh", 3}, {"skin", 0}});
  sample.json["scenes"][0]["nodes"].push_back(9);
  ASSERT_EQ(fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"}).exit_code,
            0);
  const json document = document_of(read("a.glb"));
  std::set<int> materials, images;
  for (const int mesh : {0, 3})
    for (const json& primitive : document["meshes"][mesh]["primitives"]) {
      const int material = primitive["material"];
      materials.insert(material);
      const int texture = document["materials"][material]["normalTexture"]["index"];
      images.insert(document["textures"][texture]["source"].get<int>());
    }
  EXPECT_EQ(materials.size(), 4U);
  EXPECT_EQ(images.size(), 4U);
}

TEST_F(BakeCommand, RefusesAssetsWithoutCoordinates) {
  AssetSample sample;
  for (json& primitive : sample.json["meshes"][0]["primitives"]) {
    primitive["attributes"].erase("TEXCOORD_0");
    primitive["attributes"].erase("TEXCOORD_1");
  }
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("tube: has no texture coordinates"));
  EXPECT_FALSE(exists("a.glb"));
}

TEST_F(BakeCommand, CompressionKeepsTangents) {
  for (const std::string mode : {"quantize", "meshopt"}) {
    ASSERT_EQ(fit(plate_, {"-o", path("p.glb"), "--bake", "64", "--compress", mode}).exit_code, 0);
    const json document = document_of(read("p.glb"));
    EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("TANGENT")) << mode;
    EXPECT_EQ(document["images"].size(), 1U);
  }
}

// A texture that repeats on one material leaves the map of another alone.
TEST_F(BakeCommand, LeavesOutWhatRepeats) {
  const ProcessResult result =
      fit(write("two.obj", mapped_plate() +
                               "usemtl brick\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n"
                               "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf -4/-4 -3/-3 -2/-2 -1/-1\n"),
          {"-o", path("p.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("two.obj: material `brick`: its texture repeats (face 16, "));
  const json maps = read_json("r.json")["outputs"][0]["bake"]["maps"];
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]["material"], "bark");
}

TEST_F(Needs, OfBakedMapsAreKnown) {
  write("plate.obj", mapped_plate(1, 40));
  for (const char* size : {"64", "2048"})
    expect_enough({"plate.obj", "-o", "p.glb", "--bake", size});
  // A page holds where the texture is.
  write("large.obj", mapped_plate(1, 120));
  expect_enough({"large.obj", "--page", "p.html"});
}

}  // namespace
}  // namespace planish::test
