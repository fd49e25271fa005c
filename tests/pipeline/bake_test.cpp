#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "files/gltf/parsed_gltf.h"
#include "planish/core/json.h"
#include "planish/files/images.h"
#include "planish/files/write_surface.h"
#include "planish/pipeline/bake_maps.h"
#include "support/calls.h"
#include "support/fitted_level.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  const double cosine = glm::dot(a, b) / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
  return glm::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

// A primitive of a GLB as a renderer shows it, with its normal texture: see glTF 2.0,
// section 3.9.3.
class BakedLook {
 public:
  struct Place {
    glm::dvec3 position{0.0}, shown{0.0}, interpolated{0.0}, texel{0.0};
    double sign = 0;
  };

  explicit BakedLook(const tinygltf::Model& model, std::size_t mesh = 0, std::size_t primitive = 0)
      : model_(model), primitive_(model.meshes.at(mesh).primitives.at(primitive)) {
    const tinygltf::Material& material =
        model.materials.at(static_cast<std::size_t>(primitive_.material));
    const auto texture = static_cast<std::size_t>(material.normalTexture.index);
    const auto set = std::to_string(material.normalTexture.texCoord);
    const auto image = static_cast<std::size_t>(model.textures.at(texture).source);
    const auto& view =
        model.bufferViews.at(static_cast<std::size_t>(model.images.at(image).bufferView));
    const auto* bytes =
        reinterpret_cast<const std::byte*>(model.buffers.at(0).data.data()) + view.byteOffset;
    image_ = read_image({bytes, view.byteLength}).value();
    positions_ = floats("POSITION", 3), normals_ = floats("NORMAL", 3);
    tangents_ = floats("TANGENT", 4), uvs_ = floats("TEXCOORD_" + set, 2);
    const auto& accessor = model.accessors.at(static_cast<std::size_t>(primitive_.indices));
    const auto& indices = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    const bool is_short = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    for (std::size_t i = 0; i < accessor.count; ++i) {
      std::uint32_t index = 0;
      std::memcpy(&index,
                  model.buffers.at(0).data.data() + indices.byteOffset + i * (is_short ? 2 : 4),
                  is_short ? 2 : 4);
      indices_.push_back(index);
    }
  }

  [[nodiscard]] const RgbImage& image() const { return image_; }
  [[nodiscard]] std::size_t triangle_count() const { return indices_.size() / 3; }
  [[nodiscard]] const std::vector<float>& tangents() const { return tangents_; }

  // What triangle t shows at a place of it, with the mean of `box` x `box` texels for one.
  [[nodiscard]] Place at(std::size_t t, const glm::dvec3& weights, int box = 1) const {
    Place place;
    glm::dvec3 tangent(0.0);
    glm::dvec2 uv(0.0);
    for (int k = 0; k < 3; ++k) {
      const std::size_t v = indices_[3 * t + static_cast<std::size_t>(k)];
      for (int axis = 0; axis < 3; ++axis) {
        const auto of = [&](const std::vector<float>& rows, std::size_t width) {
          return weights[k] * rows[width * v + static_cast<std::size_t>(axis)];
        };
        place.position[axis] += of(positions_, 3);
        place.interpolated[axis] += of(normals_, 3);
        tangent[axis] += of(tangents_, 4);
        if (axis < 2) uv[axis] += of(uvs_, 2);
      }
      place.sign += weights[k] * tangents_[4 * v + 3];
    }
    place.texel = texel_at(uv, box);
    const glm::dvec3 bitangent =
        (place.sign < 0 ? -1.0 : 1.0) * glm::cross(place.interpolated, tangent);
    place.shown = glm::normalize(place.texel.x * tangent + place.texel.y * bitangent +
                                 place.texel.z * place.interpolated);
    place.interpolated = glm::normalize(place.interpolated);
    return place;
  }
  // At texture coordinates whose v runs upwards, on the triangle that is there and is next to a
  // point; empty: there is none.
  [[nodiscard]] std::optional<Place> at(const glm::dvec2& uv, const glm::dvec3& near,
                                        int box = 1) const {
    std::optional<Place> best;
    for (std::size_t t = 0; t < triangle_count(); ++t) {
      std::array<glm::dvec2, 3> c;
      for (std::size_t k = 0; k < 3; ++k)
        c[k] = {uvs_[2 * indices_[3 * t + k]], 1 - uvs_[2 * indices_[3 * t + k] + 1]};
      const auto twice = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
      };
      const glm::dvec3 weights =
          glm::dvec3(twice(c[1], c[2], uv), twice(c[2], c[0], uv), twice(c[0], c[1], uv)) /
          twice(c[0], c[1], c[2]);
      constexpr double kRounding = 1e-6;
      if (!(std::min({weights.x, weights.y, weights.z}) >= -kRounding)) continue;
      const Place place = at(t, weights, box);
      if (!best || glm::length(place.position - near) < glm::length(best->position - near))
        best = place;
    }
    return best;
  }

 private:
  [[nodiscard]] std::vector<float> floats(const std::string& name, std::size_t width) const {
    const auto& accessor =
        model_.accessors.at(static_cast<std::size_t>(primitive_.attributes.at(name)));
    const auto& view = model_.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT) << name;
    std::vector<float> values(width * accessor.count);
    std::memcpy(values.data(),
                model_.buffers.at(0).data.data() + view.byteOffset + accessor.byteOffset,
                sizeof(float) * values.size());
    return values;
  }

  // Bilinear, by glTF's coordinates; the texture repeats.
  [[nodiscard]] glm::dvec3 texel_at(const glm::dvec2& uv, int box) const {
    const int width = image_.width / box, height = image_.height / box;
    const double x = uv.x * width - 0.5, y = uv.y * height - 0.5;
    glm::dvec3 sum(0.0);
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int left = static_cast<int>(std::floor(x)) + i,
                  top = static_cast<int>(std::floor(y)) + j;
        const double weight = (i == 0 ? 1 - (x - std::floor(x)) : x - std::floor(x)) *
                              (j == 0 ? 1 - (y - std::floor(y)) : y - std::floor(y));
        for (int dy = 0; dy < box; ++dy)
          for (int dx = 0; dx < box; ++dx) {
            const std::uint8_t* rgb =
                image_.at((left + width) % width * box + dx, (top + height) % height * box + dy);
            sum += weight / (box * box) * (glm::dvec3(rgb[0], rgb[1], rgb[2]) / 127.5 - 1.0);
          }
      }
    return sum;
  }

  const tinygltf::Model& model_;
  const tinygltf::Primitive& primitive_;
  RgbImage image_;
  std::vector<float> positions_, normals_, tangents_, uvs_;
  std::vector<std::uint32_t> indices_;
};

// Baked normal maps, read back by tinygltf and drawn by formulas of their own.

using nlohmann::json;
using std::numbers::pi;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A grid of quads with (columns + 1) x (rows + 1) texture coordinates; `at` gives the points of
// (u, v) in 0 to 1, one for those that fall together.
PolygonMesh mapped(int columns, int rows, bool closes_u, bool closes_v,
                   const std::function<glm::dvec3(double, double)>& at,
                   const std::function<glm::dvec2(double, double)>& uv_at) {
  PolygonMesh mesh;
  const int across = columns + (closes_u ? 0 : 1), up = rows + (closes_v ? 0 : 1);
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < across; ++i)
      mesh.positions.push_back(at(double(i) / columns, double(j) / rows));
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      mesh.uvs.push_back(uv_at(double(i) / columns, double(j) / rows));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      std::vector<std::int32_t> face;
      for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        face.push_back((j + dj) % up * across + (i + di) % across);
        mesh.face_uvs.push_back((j + dj) * (columns + 1) + i + di);
      }
      mesh.add_face(face);
    }
  return mesh;
}

glm::dvec2 as_it_is(double u, double v) { return {u, v}; }

glm::dvec3 on_torus(double u, double v) {
  const double a = 2 * pi * u, b = 2 * pi * v;
  return {(1 + 0.4 * std::cos(b)) * std::cos(a), 0.4 * std::sin(b),
          -(1 + 0.4 * std::cos(b)) * std::sin(a)};
}

PolygonMesh mapped_torus(int around, int across,
                         const std::function<glm::dvec2(double, double)>& uv_at = as_it_is) {
  return mapped(around, across, true, true, on_torus, uv_at);
}

struct Baked {
  FittedMesh fitted;
  std::vector<std::byte> glb;
  std::vector<Warning> warnings;
  std::vector<BakedMap> maps;
};

Baked bake(PolygonMesh mesh, int size, const GltfMaterials& materials = {}) {
  const auto backend = make_cpu_backend({});
  Baked made;
  MeshFitOptions how;
  how.refine = RefineChoice::Off;
  how.chooses_creases = false;
  how.quads = QuadChoice::Off;
  made.fitted = fit_mesh(mesh, "mesh", *backend, how);
  const FittedLevel low(made.fitted, *backend, 0);
  const FittedLevel fine(made.fitted, *backend, bake_level(made.fitted.mesh, size));
  BakeFileOptions options{.size = size, .name = "in.obj", .callbacks = {}};
  options.callbacks.warning = [&](const Warning& warning) { made.warnings.push_back(warning); };
  const BakedSurface baked(made.fitted, low.blocks(), fine.blocks(), materials, options);
  GltfOptions gltf;
  baked.add_to(gltf);
  made.glb = encode_glb(low.blocks(), gltf);
  made.maps.assign(baked.maps().begin(), baked.maps().end());
  return made;
}

struct Angles {
  double mean = 0, largest = 0, mean_interpolated = 0;
};

// Between what is shown at texture coordinates of the surface, at a level of its own, and its exact
// normals there. turn(normal, uv) where something else is wanted.
Angles against_surface(
    const Baked& made,
    const std::function<glm::dvec3(const glm::dvec3&, const glm::dvec2&)>& turn = {}) {
  constexpr int kLevel = 5;
  constexpr std::size_t kPlaces = 4000;
  const auto backend = make_cpu_backend({});
  const FittedLevel exact(made.fitted, *backend, kLevel);
  const SurfaceMesh surface = collect(exact.blocks(), {});
  const tinygltf::Model model = parsed(made.glb);
  const BakedLook look(model);
  std::mt19937 random(1);
  Angles angles;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const std::size_t corner = random() % surface.face_vertices.size();
    const auto row = static_cast<std::size_t>(surface.face_vertices[corner]);
    const glm::dvec2 uv = surface.uvs[static_cast<std::size_t>(surface.face_uvs[corner])];
    const auto place = look.at(uv, surface.positions[row]);
    if (!place) continue;  // past the mesh's own chart
    ++count;
    glm::dvec3 wanted(surface.normals[row]);
    if (turn) wanted = turn(wanted, uv);
    const double angle = degrees_between(place->shown, wanted);
    angles.mean += angle;
    angles.largest = std::max(angles.largest, angle);
    angles.mean_interpolated += degrees_between(place->interpolated, wanted);
  }
  EXPECT_GT(count, kPlaces * 9 / 10);
  angles.mean /= static_cast<double>(count);
  angles.mean_interpolated /= static_cast<double>(count);
  return angles;
}

std::vector<std::string> codes_of(const std::vector<Warning>& warnings) {
  std::vector<std::string> codes;
  for (const Warning& warning : warnings) codes.push_back(warning.code);
  return codes;
}

TEST(Bake, FlatSquareIsFlat) {
  const Baked made = bake(
      mapped(
          4, 3, false, false, [](double u, double v) { return glm::dvec3(u, v, 0); }, as_it_is),
      64);
  const tinygltf::Model model = parsed(made.glb);
  const BakedLook look(model);
  ASSERT_EQ(look.image().width, 64);
  ASSERT_EQ(look.image().height, 64);
  for (std::size_t i = 0; i < look.image().pixels.size(); ++i)
    ASSERT_NEAR(look.image().pixels[i], i % 3 == 2 ? 255 : 128, 1) << i;
  EXPECT_NEAR(made.maps.at(0).map.covered, 1, 1e-12);
  EXPECT_EQ(made.maps.at(0).map.overlapped, 0);
  EXPECT_THAT(made.warnings, IsEmpty());
}

TEST(Bake, ShowsTheSurface) {
  const Angles angles = against_surface(bake(mapped_torus(8, 6), 512));
  RecordProperty("mean", std::to_string(angles.mean));
  RecordProperty("interpolated", std::to_string(angles.mean_interpolated));
  EXPECT_LT(angles.mean, 0.4);
  EXPECT_LT(angles.largest, 2);
  EXPECT_GT(angles.mean_interpolated, 10 * angles.mean);
}

// Of a ball, whose normals a formula gives.
TEST(Bake, ShowsTheShape) {
  const auto on_ball = [](double u, double v) {
    // Without the poles: the coordinates have no place there.
    const double a = 2 * pi * u, b = pi * (0.8 * v - 0.4);
    return glm::dvec3(std::cos(b) * std::cos(a), std::sin(b), -std::cos(b) * std::sin(a));
  };
  const Baked made = bake(mapped(12, 6, true, false, on_ball, as_it_is), 512);
  const tinygltf::Model model = parsed(made.glb);
  const BakedLook look(model);
  double shown = 0, interpolated = 0;
  int count = 0;
  // Towards its borders the surface is no ball any more.
  for (int j = 15; j <= 45; ++j)
    for (int i = 1; i < 60; ++i) {
      const glm::dvec2 uv(i / 60.0, j / 60.0);
      const glm::dvec3 wanted = on_ball(uv.x, uv.y);
      const auto place = look.at(uv, wanted);
      ASSERT_TRUE(place);
      shown += degrees_between(place->shown, wanted);
      interpolated += degrees_between(place->interpolated, wanted);
      ++count;
    }
  RecordProperty("mean", std::to_string(shown / count));
  RecordProperty("interpolated", std::to_string(interpolated / count));
  EXPECT_LT(shown / count, 1);
  EXPECT_GT(interpolated / count, 2 * shown / count);
}

// Each quad in two, mirrored in the second half around.
PolygonMesh cut_mirrored(const PolygonMesh& quads, int around) {
  PolygonMesh mesh = quads;
  mesh.face_offsets = {0};
  mesh.face_vertices.clear(), mesh.face_uvs.clear();
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    const bool is_second = f % around >= around / 2;
    for (const int c : is_second ? std::vector{0, 1, 3, 1, 2, 3} : std::vector{0, 1, 2, 0, 2, 3}) {
      mesh.face_vertices.push_back(quads.face(f)[static_cast<std::size_t>(c)]);
      mesh.face_uvs.push_back(quads.face_uvs[static_cast<std::size_t>(4 * f + c)]);
    }
    for (int k = 0; k < 2; ++k) mesh.face_offsets.push_back(mesh.face_offsets.back() + 3);
  }
  return mesh;
}

TEST(Bake, MirroredChartsShareTheirTexels) {
  const PolygonMesh quads =
      mapped_torus(8, 6, [](double u, double v) { return glm::dvec2(std::abs(1 - 2 * u), v); });
  const Baked made = bake(cut_mirrored(quads, 8), 256);
  EXPECT_THAT(codes_of(made.warnings), ElementsAre("bake-overlap"));
  EXPECT_THAT(made.warnings.at(0).message,
              AllOf(HasSubstr("in.obj: "), HasSubstr("100 %"), HasSubstr("unwrap them apart")));
  EXPECT_NEAR(made.maps.at(0).map.overlapped, 1, 1e-9);
  const tinygltf::Model model = parsed(made.glb);
  const BakedLook look(model);
  int left = 0, right = 0;
  for (std::size_t v = 3; v < look.tangents().size(); v += 4)
    ++(look.tangents()[v] > 0 ? left : right);
  EXPECT_GT(left, 20);
  EXPECT_GT(right, 20);
  // The two halves are mirrored shapes.
  const Angles angles = against_surface(made);
  EXPECT_LT(angles.mean, 0.5);
  EXPECT_GT(angles.mean_interpolated, 10 * angles.mean);
}

// Two charts with room between them.
TEST(Bake, BordersOfChartsAreFilled) {
  PolygonMesh mesh = mapped_torus(8, 6);
  const std::vector<glm::dvec2> given = mesh.uvs;
  mesh.uvs.clear();
  for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c) {
    // By halves around the torus, each with texture coordinates of its own.
    const bool is_second = (c / 4) % 8 >= 4;
    const glm::dvec2 uv = given[static_cast<std::size_t>(mesh.face_uvs[c])];
    const glm::dvec2 moved(is_second ? 0.55 + 0.7 * (uv.x - 0.5) : 0.1 + 0.7 * uv.x,
                           0.1 + 0.8 * uv.y);
    const auto known = std::find(mesh.uvs.begin(), mesh.uvs.end(), moved);
    mesh.face_uvs[c] = static_cast<std::int32_t>(known - mesh.uvs.begin());
    if (known == mesh.uvs.end()) mesh.uvs.push_back(moved);
  }
  constexpr int kSize = 1024;
  const Baked made = bake(mesh, kSize);
  EXPECT_THAT(made.warnings, IsEmpty());
  const tinygltf::Model model = parsed(made.glb);
  const BakedLook look(model);
  // Along the seams both charts show one normal, in full and by mipmaps of 8 x 8 texels.
  for (const int box : {1, 8}) {
    double largest = 0;
    for (int i = 0; i <= 200; ++i) {
      const double v = 0.1 + 0.8 * i / 200;
      for (const auto& [left, right] : {std::pair{0.45, 0.55}, {0.1, 0.9}}) {
        const double a = 2 * pi * (left == 0.1 ? 0.0 : 0.5);
        const double b = 2 * pi * (v - 0.1) / 0.8;
        const glm::dvec3 near((1 + 0.4 * std::cos(b)) * std::cos(a), 0.4 * std::sin(b), 0);
        const auto from = look.at({left, v}, near, box), to = look.at({right, v}, near, box);
        ASSERT_TRUE(from && to) << v;
        largest = std::max(largest, degrees_between(from->shown, to->shown));
      }
    }
    EXPECT_LT(largest, box == 1 ? 1.0 : 4.0) << box;
  }
  // At least 8 texels, and flat far away.
  const auto* near_border = look.image().at(static_cast<int>(0.1 * kSize) - 9, kSize / 3);
  const auto* at_border = look.image().at(static_cast<int>(0.1 * kSize) + 1, kSize / 3);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(near_border[k], at_border[k], 3);
  const auto* far_away = look.image().at(20, 20);
  EXPECT_THAT(std::vector<int>(far_away, far_away + 3), ElementsAre(128, 128, 255));
}

// A material that tilts all normals towards u, or towards v, upwards in the image.
GltfMaterials tilted(double degrees, const std::string& name = "", bool along_v = false) {
  GltfMaterials materials;
  const double x = std::sin(glm::radians(degrees)), z = std::cos(glm::radians(degrees));
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < 16; ++i)
    for (const double value : {along_v ? 0.0 : x, along_v ? x : 0.0, z})
      pixels.push_back(static_cast<std::uint8_t>(std::lround(127.5 * value + 127.5)));
  materials.lists = {{"materials", {{{"name", name}, {"normalTexture", {{"index", 0}}}}}},
                     {"textures", {{{"source", 0}}}},
                     {"images", {{{"mimeType", "image/png"}}}}};
  materials.images.push_back({"image/png", {}, {}});
  const std::vector<std::byte> png = png_of(4, 3, pixels);
  materials.images.back().bytes.assign(png.begin(), png.end());
  return materials;
}

TEST(Bake, KeepsWhatNormalTexturesShow) {
  constexpr double kTilt = 25;
  for (const bool along_v : {false, true}) {
    const Baked made = bake(mapped_torus(8, 6), 512, tilted(kTilt, "", along_v));
    const auto tilt = [&](const glm::dvec3& normal, const glm::dvec2& uv) {
      const double a = 2 * pi * uv.x, b = 2 * pi * uv.y;
      glm::dvec3 along(-std::sin(a), 0, -std::cos(a));
      if (along_v) along = {-std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)};
      along = glm::normalize(along - normal * glm::dot(along, normal));
      return std::cos(glm::radians(kTilt)) * normal + std::sin(glm::radians(kTilt)) * along;
    };
    const Angles angles = against_surface(made, tilt);
    RecordProperty(along_v ? "along_v" : "along_u", std::to_string(angles.mean));
    EXPECT_LT(angles.mean, 1) << along_v;
    EXPECT_GT(angles.mean_interpolated, kTilt - 5) << along_v;
    const json document =
        document_of(std::string(reinterpret_cast<const char*>(made.glb.data()), made.glb.size()));
    EXPECT_EQ(document["images"].size(), 2U);
    EXPECT_EQ(document["materials"][0]["normalTexture"], (json{{"index", 1}}));
  }
}

TEST(Bake, NormalTexturesThatCannotBeReadAreTold) {
  GltfMaterials materials = tilted(20);
  materials.images.at(0).bytes.resize(20);
  const Baked made = bake(mapped_torus(8, 6), 128, materials);
  EXPECT_THAT(codes_of(made.warnings), ElementsAre("bake-unread-texture"));
  EXPECT_THAT(made.warnings.at(0).message, HasSubstr("convert it to PNG"));
  EXPECT_FALSE(made.maps.at(0).png.empty());
}

TEST(Bake, EachMaterialHasItsMap) {
  PolygonMesh mesh = mapped_torus(8, 6);
  mesh.groups = {{"upper", "bark"}, {"lower", "moss"}, {"more", "bark"}, {"nothing", "air"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) mesh.face_groups.push_back(f % 3);
  const Baked made = bake(mesh, 128, tilted(20, "moss"));
  EXPECT_THAT(made.warnings, IsEmpty());
  ASSERT_EQ(made.maps.size(), 3U);
  EXPECT_TRUE(made.maps[2].png.empty());
  EXPECT_NEAR(made.maps[0].map.covered, 2 / 3.0, 0.01);
  EXPECT_NEAR(made.maps[1].map.covered, 1 / 3.0, 0.01);
  const tinygltf::Model model = parsed(made.glb);
  std::vector<int> images;
  for (const tinygltf::Primitive& primitive : model.meshes.at(0).primitives) {
    const auto& material = model.materials.at(static_cast<std::size_t>(primitive.material));
    const auto texture = static_cast<std::size_t>(material.normalTexture.index);
    images.push_back(model.textures.at(texture).source);
  }
  EXPECT_THAT(images, ElementsAre(1, 2, 1));
}

TEST(Bake, MaterialsWithoutCoordinatesAreTold) {
  PolygonMesh mesh = mapped_torus(8, 6);
  mesh.groups = {{"", "bark"}, {"", "moss"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) mesh.face_groups.push_back(f == 5 ? 1 : 0);
  for (int c = 20; c < 24; ++c) mesh.face_uvs[static_cast<std::size_t>(c)] = -1;
  const Baked made = bake(mesh, 64);
  EXPECT_THAT(codes_of(made.warnings), ElementsAre("bake-left-out"));
  EXPECT_EQ(made.warnings.at(0).first, 5);
  EXPECT_TRUE(made.maps.at(1).png.empty());
  EXPECT_FALSE(made.maps.at(0).png.empty());
}

TEST(Bake, RefusesWhatNoMapHolds) {
  PolygonMesh bare = mapped_torus(8, 6);
  bare.uvs.clear(), bare.face_uvs.clear();
  EXPECT_THAT(message_of(ErrorCode::UnusableMesh, [&] { (void)bake(bare, 64); }),
              HasSubstr("in.obj: has no texture coordinates"));
  const auto thrice = [](double u, double v) { return glm::dvec2(3 * u, v); };
  EXPECT_THAT(
      message_of(ErrorCode::UnusableMesh, [&] { (void)bake(mapped_torus(8, 6, thrice), 64); }),
      HasSubstr("in.obj: its texture repeats (face 2, texture coordinates 1.12 "));
  const auto far_away = [](double u, double v) { return glm::dvec2(3e9 * u, v); };
  EXPECT_THAT(
      message_of(ErrorCode::UnusableMesh, [&] { (void)bake(mapped_torus(8, 6, far_away), 64); }),
      HasSubstr("its texture repeats"));
  const auto line = [](double u, double) { return glm::dvec2(u, 0.5); };
  EXPECT_THAT(
      message_of(ErrorCode::UnusableMesh, [&] { (void)bake(mapped_torus(8, 6, line), 64); }),
      HasSubstr("in.obj: its texture coordinates have no area"));
}

TEST(Bake, WrapsWhatLeavesTheSquareAlone) {
  const auto moved = [](double u, double v) { return glm::dvec2(u + 0.25, v - 2); };
  const Baked made = bake(mapped_torus(8, 6, moved), 256);
  EXPECT_THAT(codes_of(made.warnings), ElementsAre("bake-wrapped"));
  EXPECT_THAT(made.warnings.at(0).message, HasSubstr("texture coordinates 0.25 -2"));
  const Angles angles = against_surface(made);
  EXPECT_LT(angles.mean, 0.5);
  EXPECT_GT(angles.mean_interpolated, 10 * angles.mean);
}

TEST(Bake, IsTheSameForAnyNumberOfThreads) {
  const std::vector<std::byte> glb = bake(mapped_torus(8, 6), 256, tilted(10)).glb;
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(bake(mapped_torus(8, 6), 256, tilted(10)).glb == glb);
}

TEST(Bake, FinenessFollowsTheTexels) {
  const PolygonMesh mesh = mapped_torus(32, 24);
  EXPECT_EQ(bake_level(mesh, 64), 2);
  // 3,072 corners: 49,152 quads of level 3, of 2 x 2 texels.
  EXPECT_EQ(bake_level(mesh, 443), 3);
  EXPECT_EQ(bake_level(mesh, 444), 4);
  // Four million facets, at most.
  EXPECT_EQ(bake_level(mesh, 8192), 6);
  // 80,000 corners: 1.3 of the quads of level 3, 5.1 of level 4.
  EXPECT_EQ(bake_level(mapped_torus(200, 100), 8192), 3);
}

}  // namespace
}  // namespace planish::test
