// Based on: Khronos Group, "glTF 2.0 Specification", section 3.5 (scenes, nodes, transformations).
#include "planish/files/gltf/gltf_nodes.h"

#include <array>
#include <cmath>

namespace planish {
namespace {

template <int Count>
std::array<double, Count> numbers_of(const JsonPlace& place) {
  if (place.array_size() != Count)
    place.fail("has " + std::to_string(place.array_size()) + " numbers, " + std::to_string(Count) +
               " are needed");
  std::array<double, Count> numbers;
  for (int i = 0; i < Count; ++i) numbers[i] = place[i].number();
  return numbers;
}

glm::dmat4 rotation_of(const JsonPlace& place) {
  auto [x, y, z, w] = numbers_of<4>(place);
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(length > 0) || !std::isfinite(length)) place.fail("is no rotation");
  x /= length, y /= length, z /= length, w /= length;
  // Columns, as everywhere in GLM.
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0},
          {0, 0, 0, 1}};
}

glm::dmat4 local_transform(const JsonPlace& node) {
  if (const auto matrix = node.find("matrix")) {
    const auto m = numbers_of<16>(*matrix);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      matrix->fail("is no affine transformation: its last row is not 0 0 0 1");
    return {{m[0], m[1], m[2], 0},
            {m[4], m[5], m[6], 0},
            {m[8], m[9], m[10], 0},
            {m[12], m[13], m[14], 1}};
  }
  glm::dmat4 transform(1.0);
  if (const auto rotation = node.find("rotation")) transform = rotation_of(*rotation);
  if (const auto scale = node.find("scale")) {
    const auto factors = numbers_of<3>(*scale);
    for (int axis = 0; axis < 3; ++axis) transform[axis] *= factors[axis];
  }
  if (const auto translation = node.find("translation")) {
    const auto [x, y, z] = numbers_of<3>(*translation);
    transform[3] = {x, y, z, 1};
  }
  return transform;
}

std::vector<std::int64_t> indices_of(const JsonPlace& array) {
  std::vector<std::int64_t> indices;
  for (std::int64_t i = 0; i < array.array_size(); ++i) indices.push_back(array[i].integer());
  return indices;
}

std::vector<std::int64_t> root_nodes(const JsonPlace& root, const JsonPlace& nodes) {
  if (const auto scenes = root.find("scenes")) {
    const JsonPlace scene = (*scenes)[root.integer_or("scene", 0)];
    const auto listed = scene.find("nodes");
    return listed ? indices_of(*listed) : std::vector<std::int64_t>();
  }
  std::vector<bool> is_child(static_cast<std::size_t>(nodes.array_size()), false);
  for (std::int64_t i = 0; i < nodes.array_size(); ++i)
    if (const auto children = nodes[i].find("children"))
      for (const std::int64_t child : indices_of(*children))
        if (child < nodes.array_size()) is_child[static_cast<std::size_t>(child)] = true;
  std::vector<std::int64_t> result;
  for (std::int64_t i = 0; i < nodes.array_size(); ++i)
    if (!is_child[static_cast<std::size_t>(i)]) result.push_back(i);
  return result;
}

}  // namespace

std::vector<GltfInstance> gltf_instances(const JsonPlace& root) {
  struct Visit {
    std::int64_t node;
    glm::dmat4 parent_to_world;
  };
  const auto nodes = root.find("nodes");
  if (!nodes) return {};
  std::vector<GltfInstance> instances;
  std::vector<bool> reached(static_cast<std::size_t>(nodes->array_size()), false);
  std::vector<Visit> pending;
  const auto push = [&](const std::vector<std::int64_t>& indices, const glm::dmat4& to_world) {
    for (auto node = indices.rbegin(); node != indices.rend(); ++node)
      pending.push_back({*node, to_world});
  };
  push(root_nodes(root, *nodes), glm::dmat4(1.0));
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const JsonPlace node = (*nodes)[visit.node];
    // Nodes form trees, so that a second visit is a cycle or a shared child.
    if (reached[static_cast<std::size_t>(visit.node)])
      node.fail("is reached twice, but nodes must form trees");
    reached[static_cast<std::size_t>(visit.node)] = true;
    const glm::dmat4 to_world = visit.parent_to_world * local_transform(node);
    if (const auto mesh = node.find("mesh"))
      instances.push_back({mesh->integer(), visit.node, to_world});
    if (const auto children = node.find("children")) push(indices_of(*children), to_world);
  }
  return instances;
}

}  // namespace planish
