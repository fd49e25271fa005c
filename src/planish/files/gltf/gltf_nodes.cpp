// Based on: Khronos Group, "glTF 2.0 Specification", section 3.5 (scenes, nodes, transformations).
#include "planish/files/gltf/gltf_nodes.h"

#include <array>
#include <cmath>

#include "planish/files/gltf/gltf_accessor.h"

namespace planish {
namespace {

template <int Count>
std::array<double, Count> numbers_of(const JsonPlace& place) {
  if (place.array_size() != Count)
    place.fail("has {} numbers, {} are needed", place.array_size(), Count);
  std::array<double, Count> numbers;
  for (int i = 0; i < Count; ++i) numbers[i] = place[i].number();
  return numbers;
}

glm::dmat4 rotation_of(const JsonPlace& place, const std::array<double, 4>& quaternion) {
  auto [x, y, z, w] = quaternion;
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(length > 0) || !std::isfinite(length)) place.fail("is no rotation");
  x /= length, y /= length, z /= length, w /= length;
  // Columns, as everywhere in GLM.
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0},
          {0, 0, 0, 1}};
}

}  // namespace

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
  if (const auto rotation = node.find("rotation"))
    transform = rotation_of(*rotation, numbers_of<4>(*rotation));
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

namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
// A few bytes of accessors stand for any number of places.
constexpr std::int64_t kMostPlaces = std::int64_t{1} << 20;

// Where the extension places a node's mesh in the node, each place for itself.
std::vector<glm::dmat4> places_of(const JsonPlace& root, const JsonPlace& attributes,
                                  GltfSource& source) {
  std::vector<glm::dmat4> places;
  // Each begins with the rotation, as a node does.
  for (const char* name : {"ROTATION", "SCALE", "TRANSLATION"}) {
    const auto number = attributes.find(name);
    if (!number) continue;
    const GltfAccessor values(root, number->integer(), GltfAccessor::Use::Vectors, source);
    const bool is_rotation = number->path().ends_with("ROTATION");
    if (values.number_count() != (is_rotation ? 4 : 3))
      number->fail("has {} numbers for each place", values.number_count());
    if (values.count() > kMostPlaces) number->fail("places more than {} meshes", kMostPlaces);
    if (places.empty()) places.resize(static_cast<std::size_t>(values.count()), glm::dmat4(1.0));
    if (std::ssize(places) != values.count())
      number->fail("{} places, and another attribute has {}", values.count(), places.size());
    for (std::int64_t i = 0; i < values.count(); ++i) {
      glm::dmat4& place = places[i];
      const auto value = [&](std::int64_t k) { return values.value(i, k); };
      if (is_rotation) {
        place = rotation_of(*number, {value(0), value(1), value(2), value(3)});
        continue;
      }
      for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(value(axis))) number->fail("place {} is not finite", i);
        if (name[0] == 'S') place[axis] *= value(axis);
        if (name[0] == 'T') place[3][axis] = value(axis);
      }
    }
  }
  return places;
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
        if (child < nodes.array_size()) is_child[child] = true;
  std::vector<std::int64_t> result;
  for (std::int64_t i = 0; i < nodes.array_size(); ++i)
    if (!is_child[i]) result.push_back(i);
  return result;
}

}  // namespace

std::vector<GltfInstance> gltf_instances(const JsonPlace& root, GltfSource& source) {
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
    if (reached[visit.node]) node.fail("is reached twice, but nodes must form trees");
    reached[visit.node] = true;
    const glm::dmat4 to_world = visit.parent_to_world * local_transform(node);
    if (const auto mesh = node.find("mesh")) {
      const auto extensions = node.find("extensions");
      const auto instancing = extensions ? extensions->find(kInstancing) : std::nullopt;
      const auto attributes = instancing ? instancing->find("attributes") : std::nullopt;
      if (!attributes) {
        instances.push_back({mesh->integer(), visit.node, to_world});
      } else {
        for (const glm::dmat4& place : places_of(root, *attributes, source))
          instances.push_back({mesh->integer(), visit.node, to_world * place});
      }
    }
    if (const auto children = node.find("children")) push(indices_of(*children), to_world);
  }
  return instances;
}

}  // namespace planish
