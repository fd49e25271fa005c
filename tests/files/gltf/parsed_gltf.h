#pragma once

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace planish::test {

/// What tinygltf, an independent reader, finds in a GLB, and in the first primitive of it.
inline tinygltf::Model parsed(const std::vector<std::byte>& glb) {
  tinygltf::Model model;
  std::string error, warning;
  const bool read = tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
      static_cast<unsigned>(glb.size()));
  EXPECT_TRUE(read) << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

inline std::vector<glm::vec3> vectors_of(const tinygltf::Model& model, int accessor_index) {
  const auto& accessor = model.accessors.at(accessor_index);
  const auto& view = model.bufferViews.at(accessor.bufferView);
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_VEC3);
  EXPECT_EQ(accessor.byteOffset, 0u);
  EXPECT_EQ(view.target, TINYGLTF_TARGET_ARRAY_BUFFER);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(glm::vec3));
  std::vector<glm::vec3> values(accessor.count);
  std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
  return values;
}

template <class Index>
std::vector<std::uint32_t> indices_as(const tinygltf::Model& model) {
  const auto& accessor = model.accessors.at(model.meshes.at(0).primitives.at(0).indices);
  const auto& view = model.bufferViews.at(accessor.bufferView);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_SCALAR);
  EXPECT_EQ(view.target, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(Index));
  std::vector<Index> values(accessor.count);
  std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
  return {values.begin(), values.end()};
}

inline std::vector<std::uint32_t> indices_of(const tinygltf::Model& model) {
  const auto& accessor = model.accessors.at(model.meshes.at(0).primitives.at(0).indices);
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    return indices_as<std::uint16_t>(model);
  }
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  return indices_as<std::uint32_t>(model);
}

inline int attribute(const tinygltf::Model& model, const std::string& name) {
  return model.meshes.at(0).primitives.at(0).attributes.at(name);
}

}  // namespace planish::test
