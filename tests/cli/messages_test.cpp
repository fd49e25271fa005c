#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"

namespace planish::test {
namespace {

// What the command says, message by message: other tests ask for exit statuses and warnings' codes.

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

struct Said {
  std::string line;  ///< behind what all lines of a table begin with
  int exit_code;
  std::string said = "", also = "";  ///< parts of what is said, on either stream
};

class Wording : public FolderTest {
 protected:
  void expect_said(const std::string& beginning, const std::vector<Said>& table) {
    for (const Said& row : table) {
      SCOPED_TRACE(beginning + row.line);
      const std::vector<std::string> before = names();
      const ProcessResult result = run(beginning + row.line, row.exit_code);
      EXPECT_THAT(result.out + said_, AllOf(HasSubstr(row.said), HasSubstr(row.also)));
      if (row.exit_code == 0 || row.exit_code == 5 || row.exit_code == 8) continue;
      EXPECT_EQ(names(), before) << "refused before any work";
      if (row.exit_code != 2) continue;
      EXPECT_THAT(said_, StartsWith("planish: error: "));
      EXPECT_EQ(result.out, "");
    }
  }

  std::string cube_ = write("cube.obj", cube_obj());
  std::string plate_ = write("plate.obj", bumpy_plate_obj(4));
  std::string torus_ = write("torus.obj", torus_obj(8));
};

TEST_F(Wording, OfLinesThatAreNoCommands) {
  expect_said(
      "",
      {
          {"dir/goblet.obj", 2, "did you mean: planish fit dir/goblet.obj -o goblet.glb"},
          {"dir/a.glb", 2, "did you mean: planish fit dir/a.glb -o a.glb"},
          {"table.json", 2, "did you mean: planish run table.json"},
          {"run a.obj", 2, "did you mean: planish fit a.obj -o a.glb"},
          {"fti a.obj", 2, "\"fti\" is no command; did you mean fit?"},
          {"completion bsh", 2, "did you mean bash?"},
          {"inspect fit", 3, "fit: cannot read: No such file"},
          {"fit", 2, "planish fit --help"},
          {"verify a.obj", 2, "planish verify --help"},
          {"fit a.obj", 2, "nothing to write; did you mean: planish fit a.obj -o a.glb"},
          // Not the input: it is not written over.
          {"fit a.glb", 2, "did you mean: planish fit a.glb -o a_surface.glb"},
          {"fit a.obj b.glb", 2, "b.glb: no such input; did you mean -o b.glb?"},
          {"fit -- a.obj -o b.glb", 2, "-o stands after --, where flags end; put flags before it"},
          {"fit - --input-format objj -o b.glb", 2, "did you mean obj?"},
          {"verify a.obj b.obj --tolerence=1", 2, "did you mean --tolerance?"},
          // What an unset variable leaves.
          {"fit ''", 2, "an argument is empty; is a variable not set?"},
          {"reconstruct ''", 2, "an argument is empty"},
          {"inspect ''", 2, "an argument is empty"},
          {"run ''", 2, "an argument is empty"},
          {"query a.obj --points ''", 2, "--points: what follows is empty"},
      });
}

TEST_F(Wording, OfFlagsAndTheirValues) {
  expect_said(
      "fit a.obj -o b.glb ",
      {
          {"--report ''", 2, "--report: what follows is empty; is a variable not set?"},
          {"--report r.html", 2, "r.html: a report is JSON, and its name ends in .json"},
          {"-q -v", 2, "contradict"},
          {"--tol 1", 2, "did you mean --tolerance?"},
          {"-x", 2, "-x is no flag of planish fit"},
          {"--wieghts averaged", 2, "--wieghts is no flag of planish fit; did you mean --weights?"},
          {"-j 0", 2, "--jobs: 0 is out of range"},
          {"--color sometimes", 2, "--color: \"sometimes\" is not one of auto, always, never"},
          {"--device vulkan --precision double", 2, "--precision"},
          {"--tolerance abc", 2,
           "--tolerance: \"abc\" is no number; a fraction of the bounding-box diagonal"},
          {"--tolerance 0", 2, "--tolerance: 0 is out of range"},
          {"--tolerance nan", 2, "--tolerance: \"nan\" is no number"},
          {"--tolerance 1,5", 2, "--tolerance"},
          {"--max-iterations -1", 2, "--max-iterations: -1 is out of range"},
          {"--max-iterations many", 2, "--max-iterations"},
          {"--creases 40", 2,
           "--creases: \"40\" is not one of choose, use, ignore, normals, auto:DEGREES; did you "
           "mean auto:40?"},
          {"--creases ignroe", 2, "did you mean ignore?"},
          {"--creases auto:181", 2, "--creases: \"181\" is no angle of 0 to 180"},
          {"--creases auto:", 2, "--creases: \"\" is no angle"},
          {"--repair saef", 2, "--repair: \"saef\" is not one of safe, none"},
          {"--solver chebishev", 2,
           "--solver: \"chebishev\" is not one of chebyshev, plain, cg; did you mean chebyshev?"},
          {"--interpolation fare", 2,
           "--interpolation: \"fare\" is not one of auto, progressive, fair; did you mean fair?"},
          {"--polish -1", 2, "--polish: -1 is out of range"},
          {"--polish 1001", 2, "--polish: 1001 is out of range"},
          {"--levels 7", 2, "--levels: 7 is out of range; levels are 0 to 6"},
          {"--levels 2,2", 2, "--levels: level 2 is named twice"},
          {"--levels 2;3", 2, "--levels: \"2;3\" is no list of levels"},
          {"--levels 2,", 2, "is no list of levels"},
          {"--levels automatic", 2,
           "--levels: \"automatic\" is no list of levels such as 3,1, and not auto"},
          {"--weld=-1e-6", 2, "--weld: "},
          {"--weld=nan", 2, "--weld: "},
          {"--weld=0.1", 2, "--weld: "},
          {"--weld=1e-13", 2, "--weld: "},
          {"--weld=inf", 2, "--weld: "},
          {"--weld=little", 2, "--weld: "},
          {"--within 1e-7", 2, "--within: 1e-07 is not above --tolerance 1e-06"},
          {"--within 0.1", 2, "is neither; auto, 0, or a fraction"},
          {"--within -0.001", 2, "is neither; auto, 0, or a fraction"},
          {"--within nan", 2, "is neither; auto, 0, or a fraction"},
          {"--within Auto", 2, "is neither; auto, 0, or a fraction"},
          {"--within 0.01x", 2, "is neither; auto, 0, or a fraction"},
          {"--within inf", 2, "is neither; auto, 0, or a fraction"},
          {"--chord-error 0", 2, "--chord-error: 0 is out of range"},
          {"--chord-error 1e-3,x", 2, "is no list of chord errors such as 0.01,0.001"},
          {"--chord-error 1e-3,1e-3", 2, "named twice"},
          {"--angle 200", 2, "--angle: 200 is out of range"},
          {"--angle 10,20", 2, "is no number; above 0 to 180 degrees are wanted"},
          {"--bake 15", 2, "--bake: 15"},
          {"--bake 8193", 2, "--bake: 8193", "16 to 8192"},
          {"--page-limit 8X --page p.html", 2, "--page-limit: \"8X\" is no size"},
          {"--attributes error,curvatur", 2,
           "\"curvatur\" is not one of error, deviation, fold, curvature; did you mean "
           "curvature?"},
          {"--scheme lop", 2,
           "--scheme: \"lop\" is not one of doo-sabin, catmull-clark, loop; did you mean loop?"},
      });
}

TEST_F(Wording, OfFlagsThatContradictEachOther) {
  for (const std::string scheme : {"catmull-clark", "loop"})
    expect_said(
        "fit a.obj -o b.glb --scheme " + scheme,
        {
            {" --interpolation fair", 2,
             "--interpolation: fair builds control points of Doo-Sabin's level 1, which " + scheme +
                 " does not have; take progressive, or --scheme doo-sabin"},
            {" --weights averaged", 2, "--weights: averaged belongs to --scheme doo-sabin"},
            {" --preset paper", 2,
             "--weights: averaged belongs to --scheme doo-sabin; leave it and --preset paper out "
             "with --scheme " +
                 scheme},
        });
  expect_said(
      "fit torus.obj -o b.glb ",
      {
          {"--memory much", 2, "--memory: \"much\" is no size of up to"},
          {"--memory 6T", 2, "such as 6G or 800M"},
          {"--memory 100M", 2, "--memory: 100.0 MiB are too little; the least that works is 256M"},
          {"--temporary .", 2, "--temporary: is the folder of --memory"},
          {"--levels 2 --chord-error 1e-3", 2,
           "--levels: a surface has levels or --chord-error, not both"},
          {"--levels 2 --angle 9", 2, "or --angle, not both"},
          {"--levels 2 --faces 500", 2, "or --faces, not both"},
          {"--faces 500 --chord-error 1e-3", 2,
           "--chord-error: a surface has that or --faces, not both; leave one of them out"},
          {"--edge 0.1 --pixels 1@1080", 2, "--edge: a surface has that or --pixels, not both"},
          {"--faces 0", 2, "--faces: 0 is out of range"},
          {"--edge 0", 2, "lengths above 0 are wanted, in the input's unit"},
          {"--pixels 1", 2, "--pixels: \"1\" is not N@VIEW, pixels that the surface may be off by"},
          {"--pixels 1@1080,9@4", 2, "--pixels: \"9@4\" is not N@VIEW"},
          {"--faces 500 --scheme loop", 2, "--faces: loop surfaces come in levels"},
          {"--faces 500 -o t.json", 2, "t.json: 3D Tiles have levels; take --levels instead"},
          {"--chord-error 1e-3,9e-8", 2,
           "b.glb: a chord error of 9e-08 of the diagonal is finer than the file's float32 "
           "numbers hold; take 1e-7 or more, or write .ply"},
          {"--chord-error 1e-3 --scheme catmull-clark", 2,
           "--chord-error: catmull-clark surfaces come in levels"},
          {"--chord-error 1e-3 --attributes curvature", 2,
           "--attributes: fields are made on levels"},
          {"--scheme loop --quads on", 2, "--quads: loop surfaces are of triangles; take off"},
          {"--bake 64 --levels 2", 2, "b.glb: a baked map is of level 0, the input's own mesh"},
          {"--bake 64 --levels 1,0", 2, "a baked map is of level 0"},
          {"--bake 64 --chord-error 0.01", 2, "a baked map is of level 0"},
          {"--bake 64 --refine on", 2, "--refine: a baked map is of the input's own vertices"},
      });
  expect_said("fit torus.obj ", {
                                    {"--report r.json --bake 64", 2,
                                     "--bake: no surface is written that holds a map"},
                                });
  write("asset.glb", AssetSample().glb());
  AssetSample has_levels;
  has_levels.json["nodes"][4]["extensions"]["MSFT_lod"]["ids"] = {5};
  write("lod.glb", has_levels.glb());
  expect_said("fit --levels 2,1 --lods msft -o ",
              {
                  {"a.glb cube.obj", 2, "take --lods files"},
                  {"a.glb asset.glb --asset merge", 2, "--asset keep"},
                  {"a.ply asset.glb", 2, "are of glTF alone"},
                  {"a.glb lod.glb", 2, "nodes[4] has levels of detail already"},
              });
}

TEST_F(Wording, OfOutputs) {
  for (const char* name : {"old.glb", "old.bin", "old.html", "old.json", "old.mtl"})
    write(name, "precious");
  write("red.obj", "usemtl red\n" + cube_obj());
  write("b/cube.obj", cube_obj());
  write("probes.xyz", "10 1 2\n");
  std::filesystem::create_symlink("cube.obj", path("link.obj"));
  std::filesystem::create_symlink("/dev/null", path("null.glb"));
  std::filesystem::create_directory(path("folder.json"));
  ASSERT_EQ(::mkfifo(path("pipe.obj").c_str(), 0600), 0);
  const std::string is_old = "exists; --force overwrites it",
                    stdout_glb = "\"-o -\" writes a GLB to stdout";
  expect_said(
      "fit cube.obj ",
      {
          {"-o old.glb", 7, "old.glb " + is_old},
          {"-o old.gltf", 7, "old.bin " + is_old},
          {"--page old.html", 7, "old.html " + is_old},
          {"-o cube.obj -f", 2, "is the input itself"},
          {"--cage link.obj -f", 2, "is the input itself"},
          {"-o p.ply --source p.ply", 2},
          {"-o a.obj --cage a.obj", 2, "is written twice"},
          {"-o a.obj -o ./a.obj", 2, "is written twice"},
          {"-o - --report -", 2, "stdout can take one thing only"},
          {"-o - --levels 1,2", 2, "stdout takes one level only"},
          {"-o a.fbx", 2,
           "a surface is written as .glb, .gltf, .obj, .ply, .off, .stl, .usda, .json or .step",
           "from a .glb \"assimp export "},
          {"-o a.usdz", 2, "Blender converts it"},
          {"--cage a.stl", 2, "a cage is written as .glb, .gltf, .obj, .ply, .off or .usda"},
          {"-o newdir", 2, "; a folder ends with a slash, as newdir/"},
          {"-o missing/a.glb", 7, "there is no folder"},
          {"-o a.glb --report folder.json", 7, "is a folder"},
          {"-o " + std::string(252, 'a') + ".glb", 7, "no file name is longer than 255 bytes"},
          {"-o /proc/planish_test.glb", 7, "/proc"},
          {"-o pipe.obj", 7, "is a pipe or a device"},
          {"-o pipe.obj -f", 7, stdout_glb},
          {"-o null.glb", 7, "is a pipe or a device"},
          {"-o null.glb -f", 7, stdout_glb},
          {"--page p.json", 2, "a page is an .html file"},
          {"--page p.html --report p.html", 2, "a report is JSON, and its name ends in .json"},
          {"-o p.obj --attributes fold", 2,
           "p.obj cannot hold them; .glb, .gltf, .ply and .usda can"},
          {"-o p.obj --compress meshopt", 2,
           "p.obj is not compressed; .glb, .gltf and 3D Tiles are"},
          {"-o p.glb --memory 1G --temporary no/where", 7,
           "--temporary: no/where: cannot create a file", "No such file or directory"},
          {"-o p.glb --device Voodoo", 6, "--device Voodoo names none of the devices"},
          {"-o p.glb --device 5", 6, "--device 5: there ", "cpu"},
      });
  for (const std::string name : {"p.stl", "p.obj", "p.ply", "p.step", "p.usda", "tiles.json"})
    expect_said("fit cube.obj --bake 64 -o ",
                {{name, 2, name + " holds no baked map; .glb and .gltf do"}});
  // As a dry run tells it.
  write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\n");
  const std::string several = "cube.obj -o old.gltf -o b.glb --report missing/r.json";
  expect_said(
      "fit --dry-run ",
      {
          {several, 7, "would refuse old.bin " + is_old, "would write  old.gltf"},
          {several, 7, "would write  b.glb", "would refuse missing/r.json: there is no folder"},
          {several, 7, "would end with exit code 7"},
          {"bad.obj -o a.glb --repair none", 4, "would end with exit code 4"},
          {"red.obj -o old.obj", 7, "would refuse old.mtl exists"},
          {"red.obj -o new.obj", 0, "new.mtl  (its materials)"},
          {"cube.obj -o old.gltf -f", 0},
          {"cube.obj --page p.html", 0, "would write  p.html  (page)"},
      });
  expect_said("", {
                      {"fit red.obj -o old.obj", 7, "old.mtl " + is_old},
                      {"fit cube.obj b/cube.obj -o out/", 2,
                       "cube.obj and b/cube.obj would be written under one name"},
                      {"fit cube.obj b -o x.glb", 2, "several inputs; name a folder: -o x/"},
                      {"fit cube.obj b -o -", 2},
                      {"query torus.obj --points probes.xyz -o old.json", 7, is_old},
                      {"query torus.obj --points probes.xyz -o a.txt", 2,
                       "a.txt: answers are written as .json or .ply"},
                  });
  EXPECT_EQ(read("old.glb") + read("old.mtl") + read("old.html"), "preciouspreciousprecious");
  EXPECT_TRUE(std::filesystem::is_fifo(path("pipe.obj")));
  EXPECT_TRUE(std::filesystem::is_symlink(path("null.glb")));
}

// Three faces at one edge.
constexpr const char* kFan =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n";

TEST_F(Wording, OfInputs) {
  write("goblet.obj", cube_obj());
  write("text", "hello\n");
  write("part.STEP", "ISO-10303-21;");
  write("part.fbx", "Kaydara");
  write("hill.laz", "LASF");
  write("room.e57", "ASTM-E57");
  write("nothing/notes.txt", "no mesh");
  write("random.glb", "\x02\xF1zz");
  write("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
  write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
  write("short.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n1234");
  write("no_faces.obj", "v 0 0 0\n");
  write("one_place.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
  write("fan.obj", kFan);
  const std::string assimp = "\"assimp export part.fbx part.glb\" converts it";
  expect_said(
      "fit -o out.glb --cage out.obj --report out.json ",
      {
          {"text", 3, "neither name nor content is that of a format that is read"},
          {"goblt.obj", 3,
           "goblt.obj: cannot read: No such file or directory; did you mean goblet.obj?"},
          {"GOBLET.OBJ", 3, "did you mean goblet.obj?"},
          {"~/goblet.obj", 3, "the shell puts a home folder in place of ~"},
          {"file:///tmp/a.obj", 3, "a path is wanted, not a URL: /tmp/a.obj"},
          {"part.STEP", 2,
           "STEP is not read (glb, gltf, obj, ply, off, stl, xyz, pts, pcd, las, ptx are); "
           "FreeCAD or gmsh converts it"},
          {"part.fbx", 2, assimp},
          {"hill.laz", 2, "\"pdal translate hill.laz hill.las\" converts it"},
          {"room.e57", 2,
           "\"CloudCompare -SILENT -O room.e57 -C_EXPORT_FMT PLY -SAVE_CLOUDS\" converts it"},
          {"nothing", 3,
           "this folder holds no file that is read (.glb .gltf .obj .ply .off .stl .xyz .pts "
           ".pcd .las .ptx)"},
          {"nothing --input-format obj", 3},
          {"random.glb", 3, "starts neither with glTF nor with"},
          {"nan.obj", 3, "nan.obj:2: "},
          {"index.obj", 3},
          {"short.ply", 3},
          {"no_faces.obj", 4},
          {"one_place.obj", 4, "all vertices of the faces are at (1, 2, 3)"},
          {"one_place.obj --interpolation fair --repair none", 4,
           "all vertices of the faces are at (1, 2, 3)"},
          {"fan.obj --repair none", 4, "fan.obj", "face"},
          {"plate.obj --solver cg", 2, "closed"},
          {"plate.obj --scheme loop", 4,
           "plate.obj: face 0 has 4 corners, and Loop subdivision knows triangles only; split "
           "the faces into triangles, or take catmull-clark or doo-sabin"},
          {"plate.obj --source no_faces.obj", 4, "no_faces.obj: a source has to be a mesh"},
          {"plate.obj --source missing.obj", 3},
      });
  expect_said("inspect ", {{"one_place.obj", 4, "all vertices of the faces are at (1, 2, 3)"}});
  AssetSample unmapped;
  for (nlohmann::json& primitive : unmapped.json["meshes"][0]["primitives"]) {
    primitive["attributes"].erase("TEXCOORD_0");
    primitive["attributes"].erase("TEXCOORD_1");
  }
  write("unmapped.glb", unmapped.glb());
  write("tiled.obj",
        "usemtl bark\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\n"
        "f 1/1 2/2 3/3 4/4\n");
  expect_said(
      "fit -o out.glb --bake 64 ",
      {
          {"cube.obj", 4, "cube.obj: has no texture coordinates, by which a map is baked; unwrap"},
          {"tiled.obj", 4, "tiled.obj: material `bark`: its texture repeats (face ",
           "unwrap the mesh into the square from 0 to 1"},
          {"unmapped.glb", 4, "tube: has no texture coordinates"},
      });
}

TEST_F(Wording, OfCagesAndPoints) {
  run("fit plate.obj --cage cage.obj --preset paper");
  std::string cage = read("cage.obj");
  write("broken_header.obj", cage.replace(cage.find("=averaged"), 9, "=avaraged"));
  write("four.obj", torus_obj(4));  // as many faces as the plate, fewer vertices
  write("two.xyz", "0 0 0\n1 1 1\n");
  write("nan.xyz", "0 0 0\nnan 0 0\n");
  write("word.xyz", "0 0 0\n1 1 1\n2 two 2\n");
  write("no_mesh.obj", "v 0 0 0\nf 1 2 3\n");
  write("odd.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n0 0 0 7\n");
  expect_said("", {
                      {"verify cage.obj two.xyz", 2, "holds points, and a mesh is wanted here"},
                      {"verify cage.obj cube.obj", 4, "is no cage of"},
                      {"verify cage.obj four.obj", 4, "face 0 has other corners"},
                      {"verify broken_header.obj plate.obj", 3,
                       "header weights: \"avaraged\" is not one of"},
                      {"verify cage.obj plate.obj --within auto", 2},
                      {"query torus.obj --points two.xyz --rays 0,0", 2,
                       "--rays: \"0,0\" is no direction such as 0,0,-1"},
                      {"query torus.obj --points two.xyz --rays 0,0,0", 2, "no direction"},
                      {"query torus.obj --points none.xyz", 3, "none.xyz"},
                      {"query torus.obj --points nan.xyz", 3, "1 of its points are not finite"},
                      // Before the mesh: a slip in the points must not cost a fit.
                      {"query no_mesh.obj --points word.xyz", 3, "word.xyz:3"},
                      {"query torus.obj --points odd.ply", 0, "odd.ply:8"},
                  });
#ifdef PLANISH_HAS_MESHER
  write("line.xyz", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n4 4 4\n");
  write("none.xyz", "5.6e-45 0 0\n1 0 1\n0 1 2\n1 1 3\n");
  expect_said("reconstruct -o m.obj ", {
                                           {"line.xyz", 4, "on a line"},
                                           {"none.xyz", 4, "no surface was found in 4 points"},
                                           {"word.xyz", 3, "word.xyz:3"},
                                           {"line.xyz --spacing evn", 2, "did you mean even?"},
                                       });
#endif
}

TEST_F(Wording, OfScenes) {
  const auto scene = [&](const std::string& name, const std::string& jobs) {
    write(name + ".json", R"({"version":1,"jobs":[)" + jobs + "]}");
  };
  const auto moves = [&](const std::string& name, const std::string& job) {
    scene(name, R"({"input":"torus.obj","moves":[)" + job + "}");
  };
  scene("slip", R"({"inptu":"torus.obj"})");
  scene("jobs", R"({"name":"ring","input":"torus.obj"})");
  scene("input", R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
                    {"input":"plate.obj","outputs":[{"path":"plate.obj"}]})");
  scene("twice", R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
                    {"input":"plate.obj","outputs":[{"path":"./a.glb"}]})");
  scene("tags", R"({"input":"cube.obj","report":"r.json","crease_edges":[[0,8]]})");
  moves("none", R"({"vertices":[3],"by":[0,0,1]},{"vertices":[64],"by":[0,0,1]}])");
  moves("undo", R"({"undo":1}])");
  moves("scheme", R"({"vertices":[3],"by":[0,0,1]}],"scheme":"catmull-clark")");
  moves("far", R"({"vertices":[3],"by":[0,1e300,0]}])");
  expect_said("run ",
              {
                  {"slip.json", 2, "did you mean input?"},
                  {"none_at_all.json", 2},
                  {"jobs.json rign", 2, "did you mean ring?"},
                  {"input.json -f", 2, "jobs[1].outputs[0]"},
                  {"twice.json", 2, "is written twice"},
                  {"tags.json", 8, "crease_edges of the scene names vertex 8 of 8"},
                  {"none.json", 8, "jobs[0].moves[1]: there is no vertex 64; the mesh has 0 to 63"},
                  {"undo.json", 8, "jobs[0].moves[0]: there are no 1 moves to take back"},
                  {"scheme.json", 8, "jobs[0].moves[0]: "},
                  {"far.json", 8, "jobs[0].moves[0]: move 0: "},
              });
}

}  // namespace
}  // namespace planish::test
