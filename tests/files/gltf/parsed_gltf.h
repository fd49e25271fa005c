#pragma once

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace planish::test {

/// What tinygltf, an independent reader, finds in a GLB.
inline tinygltf::Model parsed(std::span<const std::byte> glb) {
  tinygltf::Model model;
  std::string error, warning;
  const bool read = tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
      static_cast<unsigned>(glb.size()));
  EXPECT_TRUE(read) << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

/// The numbers of an accessor that has a buffer view for itself.
template <class Value>
std::vector<Value> values_of(const tinygltf::Model& model, int accessor_index) {
  const auto& accessor = model.accessors.at(accessor_index);
  const auto& view = model.bufferViews.at(accessor.bufferView);
  EXPECT_EQ(accessor.byteOffset, 0u);
  EXPECT_EQ(view.byteOffset % 4, 0u);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(Value));
  std::vector<Value> values(accessor.count);
  std::memcpy(values.data(), model.buffers.at(view.buffer).data.data() + view.byteOffset,
              view.byteLength);
  return values;
}

inline std::vector<glm::vec3> vectors_of(const tinygltf::Model& model, int accessor_index) {
  const auto& accessor = model.accessors.at(accessor_index);
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_VEC3);
  EXPECT_EQ(model.bufferViews.at(accessor.bufferView).target, TINYGLTF_TARGET_ARRAY_BUFFER);
  return values_of<glm::vec3>(model, accessor_index);
}

/// Of a primitive of the first mesh.
inline std::vector<std::uint32_t> indices_of(const tinygltf::Model& model,
                                             std::size_t primitive = 0) {
  const int index = model.meshes.at(0).primitives.at(primitive).indices;
  const auto& accessor = model.accessors.at(index);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_SCALAR);
  EXPECT_EQ(model.bufferViews.at(accessor.bufferView).target, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    const auto indices = values_of<std::uint16_t>(model, index);
    return {indices.begin(), indices.end()};
  }
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  return values_of<std::uint32_t>(model, index);
}

inline int attribute(const tinygltf::Model& model, const std::string& name,
                     std::size_t primitive = 0) {
  return model.meshes.at(0).primitives.at(primitive).attributes.at(name);
}

}  // namespace planish::test
