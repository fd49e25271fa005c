// Catmull-Clark cages beside Doo-Sabin surfaces, read back as other programs read them and
// evaluated by OpenSubdiv.

#include <gmock/gmock.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/test_files.h"

namespace planish::test {
namespace {

using glm::dvec3;
using nlohmann::json;
using testing::HasSubstr;
namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// What a file says of a subdivision surface, by readers that know nothing of planish.
struct FoundCage {
  std::string scheme, boundary = "edgeOnly";
  std::vector<dvec3> points;
  std::vector<int> counts, indices;
  std::vector<int> crease_ends, corners;
  std::vector<float> crease_sharpness, corner_sharpness;
  std::size_t copies = 0;  // of vertices at seams and between groups, in glTF

  [[nodiscard]] std::size_t sharp_count() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(crease_sharpness, [](float s) { return s >= 10; }));
  }
};

// The numbers of `text` behind `name`, up to the closing bracket.
template <class T>
std::vector<T> numbers_behind(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name + " = [");
  if (at == std::string::npos) return {};
  std::string list = text.substr(at + name.size() + 4);
  list.resize(list.find(']'));
  std::ranges::replace_if(
      list, [](char c) { return c == ',' || c == '(' || c == ')'; }, ' ');
  std::istringstream in(list);
  std::vector<T> values;
  for (T value; in >> value;) values.push_back(value);
  return values;
}

std::string word_behind(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name + " = \"");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 4;
  return text.substr(begin, text.find('"', begin) - begin);
}

FoundCage of_usd(const std::string& text) {
  FoundCage cage;
  cage.scheme = word_behind(text, "uniform token subdivisionScheme");
  cage.boundary = word_behind(text, "uniform token interpolateBoundary");
  const auto coordinates = numbers_behind<double>(text, "point3f[] points");
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3)
    cage.points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  cage.counts = numbers_behind<int>(text, "int[] faceVertexCounts");
  cage.indices = numbers_behind<int>(text, "int[] faceVertexIndices");
  const auto lengths = numbers_behind<int>(text, "int[] creaseLengths");
  EXPECT_TRUE(std::ranges::all_of(lengths, [](int length) { return length == 2; }));
  cage.crease_ends = numbers_behind<int>(text, "int[] creaseIndices");
  cage.crease_sharpness = numbers_behind<float>(text, "float[] creaseSharpnesses");
  cage.corners = numbers_behind<int>(text, "int[] cornerIndices");
  cage.corner_sharpness = numbers_behind<float>(text, "float[] cornerSharpnesses");
  return cage;
}

FoundCage of_obj(const std::string& text) {
  FoundCage cage;
  cage.scheme = "catmullClark";  // OBJ does not say
  for (const std::string& line : lines_of(text)) {
    std::istringstream in(line);
    std::string word, kind, counts;
    in >> word;
    if (word == "v") {
      dvec3& p = cage.points.emplace_back();
      in >> p.x >> p.y >> p.z;
    } else if (word == "f") {
      cage.counts.push_back(0);
      for (std::string corner; in >> corner; ++cage.counts.back())
        cage.indices.push_back(std::stoi(corner) - 1);
    } else if (word == "t") {
      in >> kind >> counts;
      int a = 0, b = 0;
      float sharpness = 0;
      if (kind == "crease" && in >> a >> b >> sharpness) {
        cage.crease_ends.insert(cage.crease_ends.end(), {a, b});
        cage.crease_sharpness.push_back(sharpness);
      } else if (kind == "corner" && in >> a >> sharpness) {
        cage.corners.push_back(a);
        cage.corner_sharpness.push_back(sharpness);
      }
    }
  }
  return cage;
}

// The triangles of FB_ngon_encoding: fans of one first vertex follow each other, and the next
// polygon begins with another. `vertex_of`: the cage's vertex of each.
void add_polygons(const std::vector<int>& triangles, const std::vector<float>& vertex_of,
                  FoundCage& cage) {
  const auto add = [&](int vertex) {
    cage.indices.push_back(static_cast<int>(vertex_of[static_cast<std::size_t>(vertex)]));
    ++cage.counts.back();
  };
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
    if (i == 0 || triangles[i] != triangles[i - 3]) {
      cage.counts.push_back(0);
      add(triangles[i]);
      add(triangles[i + 1]);
    }
    add(triangles[i + 2]);
  }
}

template <class T>
std::vector<T> accessor_values(const json& document, const std::string& bytes, int accessor,
                               std::size_t width) {
  const json& given = document["accessors"][accessor];
  const json& view = document["bufferViews"][given["bufferView"].get<int>()];
  std::vector<T> values(given["count"].get<std::size_t>() * width);
  std::memcpy(values.data(), bytes.data() + view.value("byteOffset", 0), values.size() * sizeof(T));
  return values;
}

FoundCage of_glb(const std::string& file) {
  std::uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, 4);
  const json document = json::parse(file.substr(20, length));
  const std::string bytes = file.substr(20 + length + 8);
  FoundCage cage;
  const json& mesh = document["meshes"][0];
  const json& given = mesh["extras"]["subdivision"];
  cage.scheme = given["subdivisionScheme"];
  cage.boundary = given["interpolateBoundary"];
  cage.crease_ends = given.value("creaseIndices", std::vector<int>());
  cage.crease_sharpness = given.value("creaseSharpnesses", std::vector<float>());
  cage.corners = given.value("cornerIndices", std::vector<int>());
  cage.corner_sharpness = given.value("cornerSharpnesses", std::vector<float>());
  EXPECT_EQ(given.value("creaseLengths", json::array()).size(), cage.crease_sharpness.size());
  EXPECT_THAT(document["extensionsUsed"], testing::Contains("FB_ngon_encoding"));
  for (const json& primitive : mesh["primitives"]) {
    EXPECT_TRUE(primitive["extensions"].contains("FB_ngon_encoding"));
    const int indices = primitive["indices"];
    std::vector<int> triangles;
    if (document["accessors"][indices]["componentType"] == 5123) {
      for (const std::uint16_t i : accessor_values<std::uint16_t>(document, bytes, indices, 1))
        triangles.push_back(i);
    } else {
      for (const std::uint32_t i : accessor_values<std::uint32_t>(document, bytes, indices, 1))
        triangles.push_back(static_cast<int>(i));
    }
    const json& attributes = primitive["attributes"];
    const auto vertex_of =
        accessor_values<float>(document, bytes, attributes["_CAGE_VERTEX"].get<int>(), 1);
    const auto coordinates =
        accessor_values<float>(document, bytes, attributes["POSITION"].get<int>(), 3);
    for (std::size_t i = 0; i < vertex_of.size(); ++i) {
      const auto vertex = static_cast<std::size_t>(vertex_of[i]);
      if (cage.points.size() <= vertex) cage.points.resize(vertex + 1, dvec3(HUGE_VAL));
      cage.copies += cage.points[vertex].x == HUGE_VAL ? 0 : 1;
      cage.points[vertex] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    }
    add_polygons(triangles, vertex_of, cage);
  }
  return cage;
}

// A primvar of OpenSubdiv's protocol.
struct Point {
  dvec3 value{0.0};
  void Clear() { value = dvec3(0.0); }
  void AddWithWeight(const Point& other, double weight) { value += weight * other.value; }
};

// Where OpenSubdiv's surface has the cage's vertices: after so many steps all sharpness below 10 is
// gone, and what its limit masks do not know is too small to count.
std::vector<dvec3> limits_by_opensubdiv(const FoundCage& cage) {
  constexpr int kSteps = 4;
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(cage.points.size());
  descriptor.numFaces = static_cast<int>(cage.counts.size());
  descriptor.numVertsPerFace = cage.counts.data();
  descriptor.vertIndicesPerFace = cage.indices.data();
  descriptor.numCreases = static_cast<int>(cage.crease_sharpness.size());
  descriptor.creaseVertexIndexPairs = cage.crease_ends.data();
  descriptor.creaseWeights = cage.crease_sharpness.data();
  descriptor.numCorners = static_cast<int>(cage.corners.size());
  descriptor.cornerVertexIndices = cage.corners.data();
  descriptor.cornerWeights = cage.corner_sharpness.data();
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(cage.boundary == "edgeAndCorner"
                                          ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                          : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, options)));
  if (!refiner) return {};
  Far::TopologyRefiner::UniformOptions uniform(kSteps);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  std::vector<Point> points(cage.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i].value = cage.points[i];
  const Far::PrimvarRefinerReal<double> primvars(*refiner);
  std::vector<int> place(points.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<int>(i);
  for (int l = 1; l <= kSteps; ++l) {
    std::vector<Point> finer(static_cast<std::size_t>(refiner->GetLevel(l).GetNumVertices()));
    primvars.Interpolate(l, points, finer);
    points = std::move(finer);
    for (int& v : place) v = refiner->GetLevel(l - 1).GetVertexChildVertex(v);
  }
  std::vector<Point> limit(points.size());
  primvars.Limit(points, limit);
  std::vector<dvec3> result;
  for (const int v : place) result.push_back(limit[static_cast<std::size_t>(v)].value);
  return result;
}

double diagonal_of(const std::vector<dvec3>& points) {
  dvec3 least = points.front(), most = points.front();
  for (const dvec3& p : points) {
    least = glm::min(least, p);
    most = glm::max(most, p);
  }
  return glm::length(most - least);
}

// Of the diagonal, the largest distance of given vertices from their places on the surface.
double distance_of(const FoundCage& cage, const std::vector<dvec3>& given) {
  const std::vector<dvec3> limits = limits_by_opensubdiv(cage);
  if (limits.size() < given.size()) return HUGE_VAL;
  double largest = 0;
  for (std::size_t v = 0; v < given.size(); ++v)
    largest = std::max(largest, glm::length(limits[v] - given[v]));
  return largest / diagonal_of(given);
}

class EngineCage : public FolderTest {
 protected:
  // Fits `input` and reads its cage from all three formats; returns that of USD. All say the same,
  // and the report says how far OpenSubdiv's surface of them is off.
  FoundCage cage_of(const std::string& input, const std::string& flags = "", int exit_code = 0) {
    SCOPED_TRACE(input + " " + flags);
    const std::string fit =
        "fit " + input + " -f --cage-scheme catmull-clark " + flags + " --cage ";
    FoundCage first;
    for (const std::string format : {"usda", "obj", "glb"}) {
      SCOPED_TRACE(format);
      const json report = report_of(fit + "cage." + format, exit_code);
      const std::string text = read("cage." + format);
      const FoundCage cage = format == "usda"  ? of_usd(text)
                             : format == "obj" ? of_obj(text)
                                               : of_glb(text);
      const json& output = report["outputs"][0];
      distance_ = output["as_written_error"];
      EXPECT_EQ(output["scheme"], "catmull-clark");
      EXPECT_EQ(output["creases"], cage.crease_sharpness.size());
      EXPECT_EQ(cage.scheme, "catmullClark");
      // OpenSubdiv refines semi-sharp edges in single precision.
      EXPECT_NEAR(distance_of(cage, given_), distance_, 2e-6);
      if (first.points.empty()) {
        first = cage;
        continue;
      }
      EXPECT_EQ(cage.points.size(), first.points.size());
      EXPECT_EQ(std::multiset<int>(cage.counts.begin(), cage.counts.end()),
                std::multiset<int>(first.counts.begin(), first.counts.end()));
      EXPECT_EQ(cage.crease_ends, first.crease_ends);
      EXPECT_EQ(cage.crease_sharpness, first.crease_sharpness);
      EXPECT_EQ(cage.corners, first.corners);
    }
    return first;
  }
  FoundCage cage_of_text(const std::string& obj, const std::string& flags = "", int exit_code = 0) {
    write("in.obj", obj);
    given_ = of_obj(obj).points;
    return cage_of("in.obj", flags, exit_code);
  }
  FoundCage cage_of_scene(const std::string& name, const std::string& flags = "",
                          int exit_code = 0) {
    std::ifstream file(std::string(PLANISH_SCENES) + "/" + name);
    return cage_of_text({std::istreambuf_iterator<char>(file), {}}, flags, exit_code);
  }

  std::vector<dvec3> given_;
  double distance_ = 0;  ///< of the last cage
};

TEST_F(EngineCage, PassesTheVerticesOfSmoothShapes) {
  const FoundCage torus = cage_of_text(torus_obj(12));
  EXPECT_TRUE(torus.crease_sharpness.empty());
  EXPECT_LT(distance_, 1e-6);
  const FoundCage plate = cage_of_text(bumpy_plate_obj(9));
  EXPECT_EQ(plate.boundary, "edgeOnly");
  EXPECT_LT(distance_, 1e-6);
}

TEST_F(EngineCage, HasTheCreasesOfTheDefaultChoice) {
  const FoundCage box = cage_of_text(cube_obj());
  EXPECT_EQ(box.sharp_count(), 12u);
  EXPECT_LT(distance_, 1e-12);
  const FoundCage round = cage_of_text(cube_obj(), "--creases ignore");
  EXPECT_TRUE(round.crease_sharpness.empty());
  EXPECT_LT(distance_, 1e-6);
  const FoundCage block = cage_of_scene("bearing_block.obj");
  EXPECT_GT(block.sharp_count(), 100u);
  EXPECT_GT(block.crease_sharpness.size(), block.sharp_count());  // semi-sharp ones
  EXPECT_LT(distance_, 2e-6);
}

TEST_F(EngineCage, HasTheFacesOfTheDefaultChoice) {
  std::string halves;  // a torus as two triangles a quad
  for (const std::string& line : lines_of(torus_obj(12))) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty() || words[0] != "f") {
      halves += line + "\n";
      continue;
    }
    halves += "f " + words[1] + " " + words[2] + " " + words[3] + "\n";
    halves += "f " + words[1] + " " + words[3] + " " + words[4] + "\n";
  }
  const FoundCage quads = cage_of_text(halves);
  EXPECT_EQ(quads.counts, std::vector<int>(144, 4));
  EXPECT_LT(distance_, 1e-6);
  const FoundCage triangles = cage_of_text(halves, "--quads off --refine off");
  EXPECT_EQ(triangles.counts, std::vector<int>(288, 3));
  EXPECT_LT(distance_, 1e-6);
}

TEST_F(EngineCage, KeepsGroupsAndTextureCoordinates) {
  const FoundCage cube = cage_of_scene("mapped_cube.obj");
  EXPECT_EQ(cube.counts, std::vector<int>(96, 4));
  // GLB: two primitives with coordinates, vertices doubled where they meet and at seams.
  const std::string file = read("cage.glb");
  EXPECT_THAT(file, HasSubstr("TEXCOORD_0"));
  EXPECT_GT(of_glb(file).copies, 0u);
  EXPECT_EQ(of_glb(file).points.size(), given_.size());
}

TEST_F(EngineCage, ComesAsNearAsItCanWhereThereIsNone) {
  std::string prism;
  for (int i = 0; i < 12; ++i)
    prism += "v " + std::to_string(std::cos(i * 1.0471975512) + 0.03 * (i % 5)) + " " +
             std::to_string(std::sin(i * 1.0471975512) - 0.02 * (i % 4)) + " " +
             std::to_string(i / 6 + 0.05 * (i % 3)) + "\n";
  for (int i = 1; i <= 6; ++i) {
    const int next = i % 6 + 1;
    prism += "f " + std::to_string(i) + " " + std::to_string(next) + " " +
             std::to_string(next + 6) + " " + std::to_string(i + 6) + "\n";
  }
  prism += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
  const FoundCage cage = cage_of_text(prism, "--creases ignore --quads off", 5);
  EXPECT_GT(distance_, 1e-4);
  EXPECT_LT(distance_, 2e-2);
  // The iteration would have gone tens of diagonals away.
  EXPECT_LT(diagonal_of(cage.points), 4 * diagonal_of(given_));
  EXPECT_THAT(said_, HasSubstr("in.obj: the control cage's surface is off by "));
  EXPECT_THAT(said_, HasSubstr("catmull-clark has none through these vertices"));
}

TEST_F(EngineCage, StandsBesideASurfaceThatItDoesNotChange) {
  write("in.obj", bumpy_plate_obj(7));
  run("fit in.obj -o alone.ply");
  const json report =
      report_of("fit in.obj -o beside.ply --cage cage.usda --cage-scheme catmull-clark");
  EXPECT_EQ(read("alone.ply"), read("beside.ply"));
  EXPECT_THAT(said_, HasSubstr("catmull-clark control cage, 0 crease edges, within "));
  EXPECT_EQ(report["solve"]["scheme"], "doo-sabin");
  // What verify reads in the header is enough for it.
  run("fit in.obj --cage cage.obj --cage-scheme catmull-clark");
  EXPECT_THAT(read("cage.obj"), HasSubstr("planish scheme=catmull-clark"));
  run("verify cage.obj in.obj");
  run("fit in.obj --cage cage.obj --cage-scheme catmull-clark --within 0.01 -f");
  run("verify cage.obj in.obj");
  run("verify cage.obj in.obj --within 0", 5);
}

TEST_F(EngineCage, OfGltfStandsInOneFile) {
  write("in.obj", bumpy_plate_obj(5));
  run("fit in.obj --cage cage.gltf");  // of Doo-Sabin: its scheme is none
  const json document = read_json("cage.gltf");
  EXPECT_EQ(document["meshes"][0]["extras"]["subdivision"]["subdivisionScheme"], "none");
  EXPECT_TRUE(exists("cage.bin"));
  run("fit in.obj --cage cage.obj --cage-scheme loop", 2);
  EXPECT_THAT(said_, HasSubstr("--cage-scheme"));
}

}  // namespace
}  // namespace planish::test
