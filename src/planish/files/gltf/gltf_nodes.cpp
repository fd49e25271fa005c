// Based on: Khronos Group, "glTF 2.0 Specification", section 3.5 (scenes, nodes, transformations).
#include "planish/files/gltf/gltf_nodes.h"

#include <array>
#include <cmath>
#include <optional>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
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

bool hides(const JsonPlace& node) {
  const auto extensions = node.find("extensions");
  const auto visibility = extensions ? extensions->find("KHR_node_visibility") : std::nullopt;
  const auto visible = visibility ? visibility->find("visible") : std::nullopt;
  return visible && !visible->boolean();
}

// A node of the default scene that has a mesh.
struct PlacedMesh {
  std::int64_t mesh, node;
  glm::dmat4 to_world;
  bool is_hidden;
};

std::vector<PlacedMesh> placed_meshes(const JsonPlace& root) {
  struct Visit {
    std::int64_t node;
    glm::dmat4 parent_to_world;
    bool is_hidden;  // its parent is
  };
  const auto nodes = root.find("nodes");
  if (!nodes) return {};
  std::vector<PlacedMesh> placed;
  std::vector<bool> reached(static_cast<std::size_t>(nodes->array_size()), false);
  std::vector<Visit> pending;
  const auto push = [&](const std::vector<std::int64_t>& indices, const glm::dmat4& to_world,
                        bool is_hidden) {
    for (auto node = indices.rbegin(); node != indices.rend(); ++node)
      pending.push_back({*node, to_world, is_hidden});
  };
  push(root_nodes(root, *nodes), glm::dmat4(1.0), false);
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const JsonPlace node = (*nodes)[visit.node];
    // Nodes form trees, so that a second visit is a cycle or a shared child.
    if (reached[visit.node]) node.fail("is reached twice, but nodes must form trees");
    reached[visit.node] = true;
    const glm::dmat4 to_world = visit.parent_to_world * local_transform(node);
    const bool is_hidden = visit.is_hidden || hides(node);
    if (const auto mesh = node.find("mesh"))
      placed.push_back({mesh->integer(), visit.node, to_world, is_hidden});
    if (const auto children = node.find("children"))
      push(indices_of(*children), to_world, is_hidden);
  }
  return placed;
}

}  // namespace

GltfScene gltf_scene(const JsonPlace& root, GltfSource& source) {
  GltfScene scene;
  for (const auto& [mesh, number, to_world, is_hidden] : placed_meshes(root)) {
    if (is_hidden) {
      ++scene.hidden_count;
      continue;
    }
    const auto extensions = root["nodes"][number].find("extensions");
    const auto instancing = extensions ? extensions->find(kInstancing) : std::nullopt;
    const auto attributes = instancing ? instancing->find("attributes") : std::nullopt;
    if (!attributes) {
      scene.instances.push_back({mesh, number, to_world});
    } else {
      for (const glm::dmat4& place : places_of(root, *attributes, source))
        scene.instances.push_back({mesh, number, to_world * place});
    }
  }
  return scene;
}

std::optional<Warning> empty_scene_warning(const JsonPlace& root) {
  const auto meshes = root.find("meshes");
  const std::int64_t count = meshes ? meshes->array_size() : 0;
  if (count == 0 || !placed_meshes(root).empty()) return std::nullopt;
  return Warning{
      "empty-scene",
      formatted("the scene shows nothing: no node of it has the {} of the file, which {} "
                "fitted where it stays a glTF and left out where it becomes one mesh",
                counted(count, "mesh"), count == 1 ? "is" : "are"),
      count};
}

std::vector<glm::dmat4> joint_matrices(const JsonPlace& root, std::int64_t skin,
                                       GltfSource& source) {
  const JsonPlace place = root["skins"][skin], nodes = root["nodes"];
  const std::vector<std::int64_t> joints = indices_of(place["joints"]);
  std::vector<std::int64_t> parents(static_cast<std::size_t>(nodes.array_size()), -1);
  for (std::int64_t i = 0; i < nodes.array_size(); ++i)
    if (const auto children = nodes[i].find("children"))
      for (const std::int64_t child : indices_of(*children))
        if (child < nodes.array_size()) parents[child] = i;
  std::optional<GltfAccessor> binds;
  if (const auto number = place.find("inverseBindMatrices")) {
    binds.emplace(root, number->integer(), GltfAccessor::Use::Matrices, source);
    if (binds->count() < std::ssize(joints))
      number->fail("{} matrices for {} joints", binds->count(), joints.size());
  }
  std::vector<glm::dmat4> matrices;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    glm::dmat4 matrix = local_transform(nodes[joints[k]]);
    std::size_t way = 0;
    for (std::int64_t at = parents[joints[k]]; at >= 0; at = parents[at]) {
      if (++way > parents.size()) nodes[at].fail("is its own ancestor, but nodes must form trees");
      matrix = local_transform(nodes[at]) * matrix;
    }
    glm::dmat4 bind(1.0);
    for (int column = 0; binds && column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        bind[column][row] = binds->value(static_cast<std::int64_t>(k), 4 * column + row);
    matrices.push_back(matrix * bind);
  }
  return matrices;
}

}  // namespace planish
