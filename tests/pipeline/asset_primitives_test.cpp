#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "pipeline/asset_fixture.h"

namespace planish::test {
namespace {

// A GLB with one mesh, whose primitives a test adds, and the accessors that they name.
struct GlbDraft {
  std::string bytes;
  nlohmann::json document = {{"asset", {{"version", "2.0"}}},
                             {"scenes", {{{"nodes", {0}}}}},
                             {"nodes", {{{"mesh", 0}}}},
                             {"bufferViews", nlohmann::json::array()},
                             {"accessors", nlohmann::json::array()}};

  // The number of the accessor.
  std::size_t add(int component, std::size_t count, std::size_t width, const std::string& view) {
    constexpr std::array kTypes{"SCALAR", "VEC2", "VEC3", "VEC4"};
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", view.size()}});
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"count", count},
                                     {"type", kTypes[width - 1]}});
    bytes += view;
    return document["accessors"].size() - 1;
  }
  // `width` a vertex.
  std::size_t add_floats(const std::vector<double>& values, std::size_t width) {
    std::string view;
    for (const double value : values) append<float>(view, static_cast<float>(value));
    return add(5126, values.size() / width, width, view);
  }
  std::size_t add_positions(std::span<const glm::dvec3> positions) {
    std::vector<double> values;
    glm::dvec3 low(positions.front()), high(low);
    for (const glm::dvec3& p : positions) {
      values.insert(values.end(), {p.x, p.y, p.z});
      low = glm::min(low, p), high = glm::max(high, p);
    }
    const std::size_t number = add_floats(values, 3);
    document["accessors"][number]["min"] = {low.x, low.y, low.z};
    document["accessors"][number]["max"] = {high.x, high.y, high.z};
    return number;
  }
  std::size_t add_indices(std::span<const std::int32_t> indices) {
    std::string view;
    for (const std::int32_t v : indices) append<std::uint32_t>(view, static_cast<std::uint32_t>(v));
    return add(5125, indices.size(), 1, view);
  }
  void add_primitive(nlohmann::json primitive) {
    document["meshes"][0]["primitives"].push_back(std::move(primitive));
  }
  [[nodiscard]] std::string glb() {
    document["buffers"] = {{{"byteLength", bytes.size()}}};
    return glb_of(document.dump(), bytes);
  }
};

// Attributes of a glTF's vertices that differ at one place: each corner of the surface has those of
// its own side.

using nlohmann::json;

// A mesh whose every vertex has numbers of its own.
struct Corners {
  struct Numbers {
    std::string name;
    int width;
    std::vector<double> values;  // of each vertex
  };
  std::vector<glm::dvec3> positions;
  std::vector<std::vector<std::int32_t>> triangles;  // vertices of each primitive
  std::vector<Numbers> attributes;                   // of all primitives but the ones named
  std::set<std::size_t> bare;                        // primitives without
  json extensions;                                   // of each primitive

  [[nodiscard]] std::string glb() const {
    GlbDraft draft;
    const std::size_t at = draft.add_positions(positions);
    json given = {{"POSITION", at}};
    json targets = json::array();
    for (const Numbers& one : attributes) {
      const std::size_t number = draft.add_floats(one.values, static_cast<std::size_t>(one.width));
      if (one.name.starts_with("target/")) {
        targets.push_back({{one.name.substr(9), number}});
      } else {
        given[one.name] = number;
      }
    }
    for (std::size_t p = 0; p < triangles.size(); ++p) {
      json primitive = {{"indices", draft.add_indices(triangles[p])},
                        {"attributes", given},
                        {"extras", {{"part", p}}}};
      if (bare.contains(p)) primitive["attributes"] = {{"POSITION", at}};
      if (!targets.empty()) primitive["targets"] = targets;
      if (!extensions.is_null()) primitive["extensions"] = extensions;
      draft.add_primitive(primitive);
    }
    if (!extensions.is_null())
      for (const auto& [name, value] : extensions.items())
        draft.document["extensionsUsed"].push_back(name);
    return draft.glb();
  }
};

// A cube of 24 vertices, a face a side: of face 2 axis + (1 on its upper side).
Corners face_coloured_cube() {
  Corners made;
  made.triangles.resize(1);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::int32_t>(made.positions.size());
      for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        glm::dvec3 p;
        p[axis] = side, p[(axis + 1) % 3] = u * side, p[(axis + 2) % 3] = v;
        made.positions.push_back(p);
      }
      for (const int k : {0, 1, 2, 0, 2, 3}) made.triangles[0].push_back(first + k);
    }
  return made;
}

glm::dvec4 colour_of(int face) {
  return {0.2 * face, 1 - 0.15 * face, face % 2 == 0 ? 1 : 0, 1 - 0.1 * face};
}

// A flat plate of uneven triangles from 0 to 2, every vertex at x = 1 twice: one for each side.
Corners plate() {
  constexpr int kAcross = 4, kUp = 4;
  Corners made;
  made.triangles.resize(2);
  for (int half = 0; half < 2; ++half) {
    const auto first = static_cast<std::int32_t>(made.positions.size());
    for (int j = 0; j <= kUp; ++j)
      for (int i = 0; i <= kAcross; ++i) {
        const double moved = i % kAcross == 0 ? 0 : 0.06 * std::sin(7.0 * i + 3 * j + half);
        const double up = j % kUp == 0 ? 0 : 0.05 * std::cos(5.0 * (i + half * kAcross) - 2 * j);
        made.positions.emplace_back(half + static_cast<double>(i) / kAcross + moved,
                                    static_cast<double>(j) / kUp + up, 0);
      }
    for (int j = 0; j < kUp; ++j)
      for (int i = 0; i < kAcross; ++i) {
        const std::int32_t a = first + j * (kAcross + 1) + i, c = a + kAcross + 1;
        const bool turned = (i + j) % 3 == 0;
        for (const std::int32_t v : turned ? std::array{a, a + 1, c + 1, a, c + 1, c}
                                           : std::array{a, a + 1, c, a + 1, c + 1, c})
          made.triangles[static_cast<std::size_t>(half)].push_back(v);
      }
  }
  return made;
}

class AssetCorners : public Asset {
 protected:
  // visit(corner positions of a triangle, their numbers of an accessor, primitive).
  template <class Visit>
  static void for_triangles(const tinygltf::Model& model, const std::string& name,
                            const Visit& visit) {
    for (std::size_t p = 0; p < model.meshes.at(0).primitives.size(); ++p) {
      const tinygltf::Primitive& part = model.meshes[0].primitives[p];
      const auto points = points_of(model, part.attributes.at("POSITION"));
      ASSERT_TRUE(part.attributes.contains(name)) << name;
      const auto numbers = numbers_of(model, part.attributes.at(name));
      const std::size_t width = numbers.size() / points.size();
      const auto indices = numbers_of(model, part.indices);
      for (std::size_t i = 0; i < indices.size(); i += 3) {
        std::array<glm::dvec3, 3> corners;
        std::array<std::vector<double>, 3> of;
        for (std::size_t k = 0; k < 3; ++k) {
          const auto v = static_cast<std::size_t>(indices[i + k]);
          corners[k] = points[v];
          of[k].assign(numbers.begin() + static_cast<std::ptrdiff_t>(width * v),
                       numbers.begin() + static_cast<std::ptrdiff_t>(width * (v + 1)));
        }
        visit(corners, of, p);
      }
    }
  }
  static int face_of(const std::array<glm::dvec3, 3>& corners) {
    const glm::dvec3 middle = corners[0] + corners[1] + corners[2];
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(middle[k]) > std::abs(middle[axis])) axis = k;
    return 2 * axis + (middle[axis] > 0 ? 1 : 0);
  }
  static FitFileOptions at_level(int level, Scheme scheme = Scheme::DooSabin) {
    FitFileOptions options;
    options.settings.set_levels({level});
    options.settings.scheme = scheme;
    return options;
  }
};

// A colour a face: no vertex of the surface has another one, to the bit.
TEST_F(AssetCorners, ColoursOfFacesStayTheirs) {
  Corners given = face_coloured_cube();
  Corners::Numbers colours{"COLOR_0", 4, {}};
  for (int v = 0; v < 24; ++v)
    for (int k = 0; k < 4; ++k) colours.values.push_back(colour_of(v / 4)[k]);
  given.attributes = {colours};
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark})
    for (const int level : {0, 1, 3}) {
      FitFileOptions options = at_level(level, scheme);
      int warned = 0;
      options.callbacks.warning = [&](const Warning& one) {
        warned += one.code == "shared-attributes" ? 1 : 0;
      };
      const tinygltf::Model model = fitted(given.glb(), options);
      EXPECT_EQ(warned, 0);
      std::set<int> seen;
      for_triangles(model, "COLOR_0", [&](const auto& corners, const auto& numbers, std::size_t) {
        const int face = face_of(corners);
        seen.insert(face);
        for (const std::vector<double>& of : numbers)
          for (int k = 0; k < 4; ++k)
            ASSERT_EQ(static_cast<float>(of[static_cast<std::size_t>(k)]),
                      static_cast<float>(colour_of(face)[k]))
                << face;
      });
      EXPECT_EQ(seen.size(), 6U);
    }
}

// Smooth on each side of a border, and affine where it was, within the range of those given.
TEST_F(AssetCorners, BordersOfColoursAreSharpAndTheirSidesSmooth) {
  Corners given = plate();
  const auto colour_at = [](const glm::dvec3& p, std::size_t half) {
    return half == 0 ? glm::dvec4(0.8 * p.x, 0.5 * p.y, 0, 1)
                     : glm::dvec4(0.2, 1 - 0.4 * p.x, 0.9 * p.y, 0.5);
  };
  Corners::Numbers colours{"COLOR_0", 4, {}};
  glm::dvec4 low(9), high(-9);
  for (std::size_t v = 0; v < given.positions.size(); ++v) {
    const glm::dvec4 of = colour_at(given.positions[v], 2 * v / given.positions.size());
    low = glm::min(low, of), high = glm::max(high, of);
    for (int k = 0; k < 4; ++k) colours.values.push_back(of[k]);
  }
  given.attributes = {colours};
  for (const int level : {1, 2}) {
    FitFileOptions options = at_level(level);
    options.settings.refine = RefineChoice::Off;
    const tinygltf::Model model = fitted(given.glb(), options);
    ASSERT_EQ(model.meshes.at(0).primitives.size(), 2U);
    for_triangles(model, "COLOR_0",
                  [&](const auto& corners, const auto& numbers, std::size_t half) {
                    for (std::size_t i = 0; i < 3; ++i) {
                      const glm::dvec4 wanted = glm::clamp(colour_at(corners[i], half), low, high);
                      for (int k = 0; k < 4; ++k)
                        ASSERT_NEAR(numbers[i][static_cast<std::size_t>(k)], wanted[k], 2e-6)
                            << half << " at " << corners[i].x << ' ' << corners[i].y;
                    }
                  });
  }
}

// What a primitive has not, the format says: white.
TEST_F(AssetCorners, APrimitiveWithoutColoursStaysWhite) {
  Corners given = plate();
  given.bare = {1};
  Corners::Numbers colours{"COLOR_0", 4, {}};
  for (std::size_t v = 0; v < given.positions.size(); ++v)
    colours.values.insert(colours.values.end(), {0.25, 0, 0.5, 1});
  given.attributes = {colours};
  const tinygltf::Model model = fitted(given.glb(), at_level(2));
  for_triangles(model, "COLOR_0", [&](const auto&, const auto& numbers, std::size_t half) {
    for (const std::vector<double>& of : numbers)
      ASSERT_EQ(of, half == 0 ? (std::vector<double>{0.25, 0, 0.5, 1})
                              : (std::vector<double>{1, 1, 1, 1}));
  });
}

// Ids of faces are whole, each its own face's, and what names them stays.
TEST_F(AssetCorners, IdsOfFacesStayTheirs) {
  Corners given = face_coloured_cube();
  Corners::Numbers ids{"_FEATURE_ID_0", 1, {}};
  for (int v = 0; v < 24; ++v) ids.values.push_back(7 + v / 4);
  given.attributes = {ids};
  given.extensions = {
      {"EXT_mesh_features", {{"featureIds", {{{"featureCount", 13}, {"attribute", 0}}}}}}};
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark}) {
    const tinygltf::Model model = fitted(given.glb(), at_level(2, scheme));
    for_triangles(model, "_FEATURE_ID_0",
                  [&](const auto& corners, const auto& numbers, std::size_t) {
                    for (const std::vector<double>& of : numbers)
                      ASSERT_EQ(of.front(), 7 + face_of(corners));
                  });
    EXPECT_EQ(written_json()["meshes"][0]["primitives"][0]["extensions"], given.extensions);
  }
}

// Moves of colours that differ at one place are of each side, too.
TEST_F(AssetCorners, MorphTargetsMoveColoursOfFaces) {
  Corners given = face_coloured_cube();
  Corners::Numbers moves{"target/0/COLOR_0", 4, {}}, colours{"COLOR_0", 4, {}};
  for (int v = 0; v < 24; ++v)
    for (int k = 0; k < 4; ++k) {
      colours.values.push_back(0.5);
      moves.values.push_back(0.5 * colour_of(v / 4)[k] - 0.25);
    }
  given.attributes = {colours, moves};
  const tinygltf::Model model = fitted(given.glb(), at_level(1));
  const tinygltf::Primitive& part = model.meshes.at(0).primitives.at(0);
  const auto points = points_of(model, part.attributes.at("POSITION"));
  const auto made = numbers_of(model, part.targets.at(0).at("COLOR_0"));
  const auto indices = numbers_of(model, part.indices);
  ASSERT_EQ(made.size(), 4 * points.size());
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    std::array<std::size_t, 3> v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = static_cast<std::size_t>(indices[i + k]);
    const int face = face_of({points[v[0]], points[v[1]], points[v[2]]});
    for (const std::size_t vertex : v)
      for (std::size_t k = 0; k < 4; ++k)
        ASSERT_EQ(static_cast<float>(made[4 * vertex + k]),
                  static_cast<float>(0.5 * colour_of(face)[static_cast<int>(k)] - 0.25));
  }
}

// Vertices that files repeat for their normals alone cut nothing.
TEST_F(AssetCorners, NothingIsCutWhereNothingDiffers) {
  Corners given = face_coloured_cube();
  const tinygltf::Model plain = fitted(given.glb(), at_level(2));
  Corners::Numbers colours{"COLOR_0", 4, {}};
  for (const glm::dvec3& p : given.positions)
    colours.values.insert(colours.values.end(), {0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y, 0, 1});
  given.attributes = {colours};
  const tinygltf::Model coloured = fitted(given.glb(), at_level(2));
  const auto count = [](const tinygltf::Model& model) {
    return points_of(model, model.meshes.at(0).primitives.at(0).attributes.at("POSITION")).size();
  };
  EXPECT_EQ(count(coloured), count(plain));
}

// Primitives on triangles that others have: their materials are layers of one surface.
using testing::ElementsAre;
using testing::UnorderedElementsAre;

// A primitive of a GLB, by its vertices.
struct Part {
  int material = 0;
  std::vector<glm::dvec3> positions;
  std::map<std::string, std::vector<std::vector<double>>> attributes;
  std::vector<std::int32_t> indices;
};

std::string glb_of_parts(const std::vector<Part>& parts, int materials) {
  GlbDraft draft;
  for (const Part& part : parts) {
    json primitive = {{"material", part.material}};
    primitive["attributes"]["POSITION"] = draft.add_positions(part.positions);
    for (const auto& [name, values] : part.attributes) {
      std::vector<double> all;
      for (const std::vector<double>& of : values) all.insert(all.end(), of.begin(), of.end());
      const std::size_t number = draft.add_floats(all, values.front().size());
      if (name.starts_with("target/")) {
        primitive["targets"] = {{{name.substr(9), number}}};
      } else {
        primitive["attributes"][name] = number;
      }
    }
    primitive["indices"] = draft.add_indices(part.indices);
    draft.add_primitive(primitive);
  }
  for (int m = 0; m < materials; ++m)
    draft.document["materials"].push_back({{"name", "material " + std::to_string(m)}});
  return draft.glb();
}

constexpr int kSide = 6;

// Cells [first, last) of a flat plate of kSide by kSide cells both ways, each of two triangles that
// begin with their corner number `turn`; uv = scale * (x, y).
Part cut_plate(int material, int first, int last, std::size_t turn, double scale) {
  Part made{.material = material, .positions = {}, .attributes = {}, .indices = {}};
  const int across = last - first + 1;
  for (int j = first; j <= last; ++j)
    for (int i = first; i <= last; ++i) {
      const double moved = i % kSide == 0 || j % kSide == 0 ? 0 : 0.15 * std::sin(5.0 * i + 3 * j);
      made.positions.emplace_back(i + moved, j - moved, 0);
      const glm::dvec3& p = made.positions.back();
      made.attributes["TEXCOORD_0"].push_back({scale * p.x, scale * p.y});
    }
  const auto add = [&](std::array<int, 3> triangle) {
    for (std::size_t k = 0; k < 3; ++k) made.indices.push_back(triangle[(k + turn) % 3]);
  };
  for (int j = 0; j + 1 < across; ++j)
    for (int i = 0; i + 1 < across; ++i) {
      const int a = j * across + i;
      add({a, a + 1, a + across + 1});
      add({a, a + across + 1, a + across});
    }
  return made;
}

class AssetLayersTest : public Asset {
 protected:
  static const tinygltf::Primitive& of_material(const tinygltf::Model& model, int material) {
    const auto& primitives = model.meshes.at(0).primitives;
    const auto found = std::ranges::find(primitives, material, &tinygltf::Primitive::material);
    if (found == primitives.end()) throw std::runtime_error("no primitive has the material");
    return *found;
  }
  static std::vector<int> materials_of(const tinygltf::Model& model) {
    std::vector<int> materials;
    for (const tinygltf::Primitive& primitive : model.meshes.at(0).primitives)
      materials.push_back(primitive.material);
    return materials;
  }
  // The largest distance of texture coordinates from scale * (x, y), in parts of the plate's.
  static double worst_uv(const tinygltf::Model& model, const tinygltf::Primitive& of,
                         double scale) {
    const auto points = points_of(model, of.attributes.at("POSITION"));
    const auto uvs = numbers_of(model, of.attributes.at("TEXCOORD_0"));
    double worst = 0;
    for (const double index : numbers_of(model, of.indices)) {
      const auto i = static_cast<std::size_t>(index);
      worst = std::max({worst, std::abs(uvs[2 * i] - scale * points[i].x),
                        std::abs(uvs[2 * i + 1] - scale * points[i].y)});
    }
    return worst / (scale * kSide);
  }
  tinygltf::Model fitted_parts(const std::vector<Part>& parts, int materials = 3, int level = 2) {
    FitFileOptions options;
    options.settings.set_levels({level});
    warnings_.clear();
    options.callbacks.warning = [&](const Warning& one) { warnings_.insert(one.code); };
    return fitted(glb_of_parts(parts, materials), options);
  }
  std::set<std::string> warnings_;
};

TEST_F(AssetLayersTest, ADecalLiesOnTheSurfaceOfWhatItCovers) {
  for (const std::size_t turn : {0U, 1U, 2U}) {
    const tinygltf::Model model =
        fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(1, 2, 4, turn, 0.5)});
    // What is covered, what is not, and the decal.
    ASSERT_THAT(materials_of(model), ElementsAre(0, 0, 1));
    const auto& primitives = model.meshes[0].primitives;
    const tinygltf::Primitive& decal = primitives[2];
    const auto under = std::ranges::find(primitives, decal.indices, &tinygltf::Primitive::indices);
    ASSERT_LT(under - primitives.begin(), 2);
    for (const char* const shared : {"POSITION", "NORMAL"})
      EXPECT_EQ(decal.attributes.at(shared), under->attributes.at(shared));
    for (const tinygltf::Primitive& base : {primitives[0], primitives[1]}) {
      EXPECT_LT(worst_uv(model, base, 0.125), 1e-6);
      EXPECT_EQ(base.attributes.size(), 3U);
    }
    EXPECT_LT(worst_uv(model, decal, 0.5), 1e-6);
    EXPECT_EQ(decal.attributes.size(), 3U);
    const double covered = static_cast<double>(numbers_of(model, decal.indices).size());
    double all = 0;
    for (const tinygltf::Primitive& base : {primitives[0], primitives[1]})
      all += static_cast<double>(numbers_of(model, base.indices).size());
    EXPECT_NEAR(covered / all, 4.0 / 36, 0.02);
    EXPECT_FALSE(warnings_.contains("duplicate-faces"));
  }
}

TEST_F(AssetLayersTest, ACoatOverAllChangesNothingUnderIt) {
  const Part base = cut_plate(0, 0, kSide, 0, 0.125);
  Part coat = cut_plate(1, 0, kSide, 1, 3);
  for (std::size_t i = 0; i < coat.positions.size(); ++i)
    coat.attributes["COLOR_0"].push_back({i % 2 == 0 ? 1.0 : 0.25, 0.5, 0, 1});
  const tinygltf::Model alone = fitted_parts({base}), both = fitted_parts({base, coat});
  ASSERT_THAT(materials_of(both), ElementsAre(0, 1));
  const auto &before = alone.meshes[0].primitives[0], &after = both.meshes[0].primitives[0];
  EXPECT_EQ(numbers_of(alone, before.indices), numbers_of(both, after.indices));
  ASSERT_EQ(before.attributes.size(), after.attributes.size());
  for (const auto& [name, accessor] : before.attributes)
    EXPECT_EQ(numbers_of(alone, accessor), numbers_of(both, after.attributes.at(name))) << name;
  const tinygltf::Primitive& layer = both.meshes[0].primitives[1];
  EXPECT_EQ(layer.indices, after.indices);
  EXPECT_LT(worst_uv(both, layer, 3), 1e-6);
  const std::vector<double> colours = numbers_of(both, layer.attributes.at("COLOR_0"));
  EXPECT_EQ(*std::ranges::min_element(colours), 0);
  std::set<double> reds;
  for (std::size_t i = 0; i < colours.size(); i += 4) reds.insert(colours[i]);
  EXPECT_EQ(*reds.begin(), 0.25);
  EXPECT_EQ(*reds.rbegin(), 1);
}

TEST_F(AssetLayersTest, LayersLieOnLayers) {
  const tinygltf::Model model =
      fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(1, 1, 5, 1, 0.25),
                    cut_plate(2, 2, 4, 2, 0.5), cut_plate(3, 0, 1, 2, 2)},
                   4);
  ASSERT_THAT(materials_of(model), testing::UnorderedElementsAre(0, 0, 0, 0, 1, 1, 2, 3));
  const std::map<int, double> scales = {{0, 0.125}, {1, 0.25}, {2, 0.5}, {3, 2}};
  std::map<int, std::size_t> corners;
  for (const tinygltf::Primitive& primitive : model.meshes[0].primitives) {
    EXPECT_EQ(primitive.attributes.size(), 3U);
    EXPECT_LT(worst_uv(model, primitive, scales.at(primitive.material)), 1e-6);
    corners[primitive.material] += numbers_of(model, primitive.indices).size();
  }
  EXPECT_GT(corners[0], corners[1]);
  EXPECT_GT(corners[1], corners[2]);
  EXPECT_GT(corners[2], corners[3]);
  // What lies on others comes after them.
  const std::vector<int> order = materials_of(model);
  EXPECT_EQ(order.back(), 2);
}

// Sets of texture coordinates, morphed ones among them, and none.
TEST_F(AssetLayersTest, EachHasSetsOfItsOwn) {
  Part base = cut_plate(0, 0, kSide, 0, 0.125), decal = cut_plate(1, 2, 4, 0, 0.5);
  base.attributes.erase("TEXCOORD_0");
  decal.attributes["TEXCOORD_1"] = decal.attributes["TEXCOORD_0"];
  for (Part* part : {&base, &decal})
    for (const glm::dvec3& p : part->positions)
      part->attributes["target/0/POSITION"].push_back({0, 0, 0.1 * p.x});
  tinygltf::Model model = fitted_parts({base, decal});
  const auto names = [&](const tinygltf::Primitive& of) {
    std::set<std::string> found;
    for (const auto& [name, accessor] : of.attributes) found.insert(name);
    for (const auto& target : of.targets)
      for (const auto& [name, accessor] : target) found.insert("target " + name);
    return found;
  };
  EXPECT_THAT(names(of_material(model, 0)),
              ElementsAre("NORMAL", "POSITION", "target NORMAL", "target POSITION"));
  EXPECT_THAT(names(of_material(model, 1)),
              ElementsAre("NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1", "target NORMAL",
                          "target POSITION"));
  EXPECT_LT(worst_uv(model, of_material(model, 1), 0.5), 1e-6);

  // And a layer without any on a base of two.
  base = cut_plate(0, 0, kSide, 0, 0.125), decal = cut_plate(1, 2, 4, 0, 0.5);
  base.attributes["TEXCOORD_1"] = base.attributes["TEXCOORD_0"];
  decal.attributes.erase("TEXCOORD_0");
  model = fitted_parts({base, decal});
  EXPECT_THAT(names(of_material(model, 0)),
              ElementsAre("NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1"));
  EXPECT_THAT(names(of_material(model, 1)), ElementsAre("NORMAL", "POSITION"));
}

TEST_F(AssetLayersTest, OtherTrianglesAreNone) {
  // The same material once more: faces are repeated.
  EXPECT_THAT(
      materials_of(fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(0, 2, 4, 1, 0.5)})),
      ElementsAre(0));
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
  // Turned round, and only in part on others: as they were before.
  Part back = cut_plate(1, 2, 4, 0, 0.5);
  for (std::size_t i = 0; i < back.indices.size(); i += 3)
    std::swap(back.indices[i], back.indices[i + 1]);
  fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), back});
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
  Part wider = cut_plate(1, 2, 4, 0, 0.5);
  const auto next = static_cast<std::int32_t>(wider.positions.size());
  wider.positions.emplace_back(3, 3, 5);
  wider.attributes["TEXCOORD_0"].push_back({0, 0});
  for (const std::int32_t v : {0, 1, next}) wider.indices.push_back(v);
  EXPECT_THAT(materials_of(fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), wider})),
              ElementsAre(0, 1));
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
}

// Whatever has no face shifts no material.
TEST_F(AssetLayersTest, PrimitivesWithoutAreaShiftNoMaterial) {
  Part flat = cut_plate(1, 0, 1, 0, 1);
  for (std::size_t i = 0; i < flat.indices.size(); i += 3) flat.indices[i + 1] = flat.indices[i];
  const tinygltf::Model model =
      fitted_parts({flat, cut_plate(0, 0, kSide, 0, 0.125), cut_plate(2, 2, 4, 1, 0.5)});
  EXPECT_THAT(materials_of(model), UnorderedElementsAre(0, 0, 2));
}

}  // namespace
}  // namespace planish::test
