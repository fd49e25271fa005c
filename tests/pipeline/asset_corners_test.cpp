// Attributes of a glTF's vertices that differ at one place: each corner of the surface has those of
// its own side.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <set>
#include <utility>

#include "pipeline/asset_fixture.h"
#include "pipeline/glb_draft.h"

namespace planish::test {
namespace {

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

}  // namespace
}  // namespace planish::test
