#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <string>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "files/gltf/parsed_gltf.h"
#include "planish/job/fit_file.h"
#include "support/files.h"

namespace planish::test {

// Numbers of an accessor, one after another.
inline std::vector<double> numbers_of(const tinygltf::Model& model, int accessor) {
  const tinygltf::Accessor& of = model.accessors.at(static_cast<std::size_t>(accessor));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(of.bufferView));
  const auto width = static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(of.type)));
  const auto size = static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(of.componentType)));
  const std::size_t stride = view.byteStride > 0 ? view.byteStride : width * size;
  std::vector<double> numbers;
  for (std::size_t i = 0; i < of.count; ++i) {
    for (std::size_t k = 0; k < width; ++k) {
      const unsigned char* at =
          model.buffers.at(0).data.data() + view.byteOffset + of.byteOffset + i * stride + k * size;
      if (of.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
        float value = 0;
        std::memcpy(&value, at, size);
        numbers.push_back(value);
      } else {
        std::uint16_t value = 0;
        std::memcpy(&value, at, size);
        numbers.push_back(value);
      }
    }
  }
  return numbers;
}

inline std::vector<glm::dvec3> points_of(const tinygltf::Model& model, int accessor) {
  const std::vector<double> numbers = numbers_of(model, accessor);
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return points;
}

/// Fits an asset to a GLB, which tinygltf reads.
class Asset : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  tinygltf::Model fitted(const std::string& glb, const FitFileOptions& options = {}) {
    result_ = fit_file(write("in.glb", glb), folder_ / "out.glb", options);
    const std::string bytes = read("out.glb");
    const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
    return parsed({begin, begin + bytes.size()});
  }
  nlohmann::json written_json() const { return document_of(read("out.glb")); }
  static FitFileOptions progressive() {
    FitFileOptions options;
    options.settings.interpolation = InterpolationChoice::Progressive;
    options.settings.quads = QuadChoice::Off;
    options.settings.creases.chooses = false;
    return options;
  }
  /// A morphed surface is that through the morphed points, within these bounds of positions and
  /// normals: holds where the surface is linear in the given points.
  void expect_exact_morphs(const FitFileOptions& options, double bound, double normal_bound) {
    const tinygltf::Model model = fitted(sample_.glb(), options);
    ASSERT_TRUE(result_.fitted.fit.interpolation.converged);
    // The same file whose rest pose is the morphed one.
    AssetSample posed = sample_;
    posed.move_tube([&](std::size_t v, std::size_t k) { return posed.moves[v][k]; });
    const tinygltf::Model wanted = fitted(posed.glb(), options);
    for (int p = 0; p < 2; ++p) {
      const tinygltf::Primitive &rest = model.meshes[0].primitives[p],
                                &there = wanted.meshes[0].primitives[p];
      const auto from = points_of(model, rest.attributes.at("POSITION"));
      const auto by = points_of(model, rest.targets.at(0).at("POSITION"));
      const auto to = points_of(wanted, there.attributes.at("POSITION"));
      const auto from_normals = points_of(model, rest.attributes.at("NORMAL"));
      const auto by_normals = points_of(model, rest.targets.at(0).at("NORMAL"));
      const auto to_normals = points_of(wanted, there.attributes.at("NORMAL"));
      ASSERT_EQ(from.size(), to.size());
      double moved_by = 0;
      for (std::size_t i = 0; i < to.size(); ++i) {
        EXPECT_LE(glm::length(from[i] + by[i] - to[i]), bound);
        EXPECT_LE(glm::length(from_normals[i] + by_normals[i] - to_normals[i]), normal_bound);
        moved_by = std::max(moved_by, glm::length(by[i]));
      }
      EXPECT_GT(moved_by, 0.3);
    }
  }

  TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
  AssetSample sample_;
  FileFit result_;
};

}  // namespace planish::test
