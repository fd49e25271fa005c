#include "planish/files/gltf/read_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/materials.h"

namespace planish {
namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", section 3.5 (scenes, nodes, transformations).

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

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7.2 (meshes), and
// "KHR_draco_mesh_compression", 2018.

// Joints that a vertex names beyond so many sets of four are an error of the file.
constexpr int kMostSets = 4;
constexpr int kJointsOfSet = 4;

bool is_finite_place(const glm::dvec3& position) {
  return std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z);
}

}  // namespace

SourcePrimitive::SourcePrimitive(const JsonPlace& root, const JsonPlace& primitive,
                                 GltfSource& source)
    : root_(root), place_(primitive), source_(source) {
  unpack();
  positions_.emplace(
      accessor(place_["attributes"]["POSITION"], "POSITION", GltfAccessor::Use::Positions));
}

void SourcePrimitive::unpack() {
  constexpr std::int64_t kTriangles = 4;
  const auto extensions = place_.find("extensions");
  const auto packed = extensions ? extensions->find(kDracoExtension) : std::nullopt;
  const JsonPlace accessors = root_["accessors"];
  const JsonPlace positions = accessors[place_["attributes"]["POSITION"].integer()];
  if (!packed || positions.find("bufferView")) return;
  if (place_.integer_or("mode", kTriangles) != kTriangles)
    place_["mode"].fail("only triangles are read of Draco streams");
  const JsonPlace attributes = (*packed)["attributes"];
  for (const std::string& name : attributes.keys())
    identifiers_.emplace(name, attributes[name].integer());
  const DracoCounts wanted{accessors[place_["indices"].integer()]["count"].integer(1),
                           positions["count"].integer(1)};
  unpacked_ = decode_draco(*packed, source_.view((*packed)["bufferView"].integer()), wanted);
}

GltfAccessor SourcePrimitive::accessor(const JsonPlace& place, std::string_view name,
                                       GltfAccessor::Use use) const {
  const UnpackedElements* elements = nullptr;
  if (const auto identifier = identifiers_.find(name); identifier != identifiers_.end()) {
    const auto found = unpacked_->by_identifier.find(identifier->second);
    if (found == unpacked_->by_identifier.end())
      place.fail("the Draco stream has no attribute {}", identifier->second);
    elements = &found->second;
  }
  return {root_, place.integer(), use, source_, elements};
}

std::optional<GltfAccessor> SourcePrimitive::indices() const {
  const auto place = place_.find("indices");
  if (!place) return std::nullopt;
  return GltfAccessor(root_, place->integer(), GltfAccessor::Use::Indices, source_,
                      unpacked_ ? &unpacked_->corners : nullptr);
}

std::optional<GltfAccessor> SourcePrimitive::attribute(std::string_view name,
                                                       GltfAccessor::Use use) const {
  const auto place = place_["attributes"].find(name);
  if (!place) return std::nullopt;
  GltfAccessor found = accessor(*place, name, use);
  if (found.count() != positions().count())
    place->fail("{} elements for {} vertices", found.count(), positions().count());
  return found;
}

GltfAccessor SourcePrimitive::target(const JsonPlace& place, GltfAccessor::Use use) const {
  GltfAccessor found(root_, place.integer(), use, source_);
  if (found.count() != positions().count())
    place.fail("{} elements for {} vertices", found.count(), positions().count());
  return found;
}

std::vector<JointSet> SourcePrimitive::joint_sets() const {
  std::vector<JointSet> sets;
  for (int set = 0; set < kMostSets; ++set) {
    const std::string number = std::to_string(set);
    auto joints = attribute("JOINTS_" + number, GltfAccessor::Use::Vectors);
    auto weights = attribute("WEIGHTS_" + number, GltfAccessor::Use::Vectors);
    if (!joints && !weights) break;
    const JsonPlace place = place_["attributes"][(joints ? "JOINTS_" : "WEIGHTS_") + number];
    if (!joints || !weights) place.fail("joints and weights come in pairs, and one is missing");
    if (joints->number_count() != kJointsOfSet || weights->number_count() != kJointsOfSet)
      place.fail("joints and weights are four of a vertex");
    sets.push_back({place, *joints, *weights});
  }
  return sets;
}

void append_influences(std::span<const JointSet> sets, std::int64_t vertex,
                       std::vector<JointWeight>& to) {
  for (const JointSet& set : sets) {
    for (std::int64_t k = 0; k < kJointsOfSet; ++k) {
      const double weight = set.weights.value(vertex, k), joint = set.joints.value(vertex, k);
      if (!std::isfinite(weight) || weight < 0 || joint < 0 || joint != std::floor(joint))
        set.place.fail("vertex {} is no joint with a weight from 0", vertex);
      if (weight > 0) to.push_back({static_cast<std::int32_t>(joint), static_cast<float>(weight)});
    }
  }
}

glm::dmat4 posed(std::span<const JointSet> sets, std::int64_t vertex,
                 std::span<const glm::dmat4> joints) {
  std::vector<JointWeight> influences;
  append_influences(sets, vertex, influences);
  if (influences.empty()) return joints.front();
  glm::dmat4 sum(0.0);
  double weights = 0;
  for (const JointWeight& one : influences) {
    if (one.joint >= std::ssize(joints))
      sets.front().place.fail("vertex {} names joint {}, and the skin has {}", vertex, one.joint,
                              joints.size());
    sum += static_cast<double>(one.weight) * joints[one.joint];
    weights += one.weight;
  }
  return sum / weights;
}

glm::dvec3 SourcePrimitive::position(std::int64_t vertex, const GltfInstance& instance) const {
  const glm::dvec3 stored = positions().position(vertex);
  const glm::dvec3 placed(instance.to_world * glm::dvec4(stored, 1.0));
  if (!is_finite_place(placed)) {
    const glm::dvec3& shown = is_finite_place(stored) ? placed : stored;
    place_["attributes"]["POSITION"].fail("vertex {} is at ({}, {}, {})", vertex, shortest(shown.x),
                                          shortest(shown.y), shortest(shown.z));
  }
  return placed;
}

glm::vec4 SourcePrimitive::color(const GltfAccessor& colors, std::int64_t vertex) const {
  const glm::vec4 color = colors.color(vertex);
  // Negated, so that NaN fails too.
  const bool in_range = color.r >= 0 && color.g >= 0 && color.b >= 0 && color.a >= 0 &&
                        color.r <= 1 && color.g <= 1 && color.b <= 1 && color.a <= 1;
  if (!in_range)
    place_["attributes"]["COLOR_0"].fail("the colour of vertex {} is not within 0 and 1", vertex);
  return color;
}

// Cofactors stay finite where there is no inverse; mirrors turn their sign.
glm::dvec3 placed_normal(const glm::dvec3& normal, const GltfInstance& instance) {
  const glm::dmat3 m(instance.to_world);
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                             glm::cross(m[0], m[1]));
  const glm::dvec3 placed = cofactors * normal;
  return glm::dot(m[0], cofactors[0]) < 0 ? -placed : placed;
}

namespace {

constexpr glm::vec3 kNoPointNormal(0.0f);
constexpr glm::vec4 kPlainWhite(1.0f);

}  // namespace

void GltfPoints::add(const SourcePrimitive& primitive, const GltfInstance& instance) {
  const std::size_t before = positions_.size();
  const std::int64_t count = primitive.positions().count();
  for (std::int64_t i = 0; i < count; ++i) positions_.push_back(primitive.position(i, instance));
  if (const auto normals = primitive.attribute("NORMAL", GltfAccessor::Use::Normals)) {
    normals_.resize(before, kNoPointNormal);
    for (std::int64_t i = 0; i < count; ++i)
      normals_.emplace_back(placed_normal(normals->position(i), instance));
  }
  if (const auto colors = primitive.attribute("COLOR_0", GltfAccessor::Use::Colors)) {
    colors_.resize(before, kPlainWhite);
    for (std::int64_t i = 0; i < count; ++i) colors_.push_back(primitive.color(*colors, i));
  }
}

void GltfPoints::finish(MeshFile& file) {
  if (!normals_.empty()) normals_.resize(positions_.size(), kNoPointNormal);
  if (!colors_.empty()) colors_.resize(positions_.size(), kPlainWhite);
  file.mesh.positions = std::move(positions_);
  file.normals = std::move(normals_);
  file.mesh.colors = std::move(colors_);
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7 (meshes).

// A few bytes of nodes can place any number of them.
constexpr std::int64_t kMaxPrimitives = std::int64_t{1} << 20;

// Extensions that change nothing about the triangles, are read, or are seen to where an asset is
// written; any other that a file requires is refused. One list, so that whatever is fitted can be
// inspected.
constexpr std::array<std::string_view, 16> kReadExtensions = {"KHR_materials_",
                                                              "KHR_texture_",
                                                              "EXT_texture_",
                                                              "KHR_lights_",
                                                              "KHR_mesh_quantization",
                                                              "EXT_meshopt_compression",
                                                              "EXT_mesh_gpu_instancing",
                                                              "KHR_animation_pointer",
                                                              "KHR_node_",
                                                              "KHR_xmp_json_ld",
                                                              "MSFT_lod",
                                                              "KHR_interactivity",
                                                              "MSFT_texture_dds",
                                                              kNgonExtension,
                                                              "EXT_mesh_features",
                                                              "EXT_structural_metadata"};

// A file may say which version its reader must know at least.
void require_known_version(const JsonPlace& least) {
  constexpr double kKnown = 2.0;
  double number = 0;
  if (!parse_number(least.text(), number)) least.fail(quote(least.text()) + " is no version");
  if (number > kKnown)
    least.fail("the file needs a reader of glTF {}, and 2.0 is read; save it as glTF 2.0",
               least.text());
}

bool encodes_polygons(const JsonPlace& primitive) {
  const auto extensions = primitive.find("extensions");
  return extensions && extensions->is_object() && extensions->find(kNgonExtension);
}

}  // namespace

void require_gltf_version(const JsonPlace& root) {
  const JsonPlace asset = root["asset"], version = asset["version"];
  if (!version.text().starts_with("2.")) version.fail(quote(version.text()) + " is not 2.x");
  if (const auto least = asset.find("minVersion")) require_known_version(*least);
  const auto required = root.find("extensionsRequired");
  for (std::int64_t i = 0; required && i < required->array_size(); ++i) {
    const std::string_view extension = (*required)[i].text();
    const bool is_read = std::ranges::any_of(
        kReadExtensions, [&](std::string_view known) { return extension.starts_with(known); });
    if (!is_read && !(reads_draco() && extension == kDracoExtension))
      (*required)[i].fail(quote(extension) + " cannot be read; save the file without it");
  }
}

MeshFile SceneReader::read(FileFormat format) {
  const GltfScene scene = gltf_scene(root_, source_);
  if (scene.hidden_count > 0)
    file_.warnings.push_back(
        {.code = "hidden-nodes",
         .message =
             formatted("{} that the file hides (KHR_node_visibility) {} left out",
                       counted(scene.hidden_count, "mesh"), scene.hidden_count == 1 ? "is" : "are"),
         .count = scene.hidden_count});
  if (auto warning = empty_scene_warning(root_)) file_.warnings.push_back(*std::move(warning));
  return read(format, scene.instances);
}

MeshFile SceneReader::read_mesh(FileFormat format, std::int64_t mesh, AssetCollector& asset) {
  constexpr std::int64_t kNoNode = -1;
  asset_ = &asset;
  const GltfInstance itself{mesh, kNoNode, glm::dmat4(1.0)};
  return read(format, {&itself, 1});
}

MeshFile SceneReader::read(FileFormat format, std::span<const GltfInstance> instances) {
  for (const GltfInstance& instance : instances) read_instance(instance, bytes_ / instances.size());
  file_.format = format;
  triangles_.finish(welder_, file_);
  attributes_.finish(std::move(uvs_), file_.mesh);
  if (file_.mesh.face_count() == 0 && !points_.empty()) {
    points_.finish(file_);
  } else {
    file_.dropped_element_count += point_primitive_count_;
  }
  if (creases_from_normals_) mark_split_normals(file_.mesh, normals_);
  if (shared_count_ > 0 && asset_ == nullptr)
    file_.warnings.push_back(
        {.code = "shared-attributes",
         .message = formatted("{} of {} {} another colour at a place they share: there the first "
                              "one's is taken",
                              with_separators(shared_count_), counted(colored_count_, "vertex"),
                              shared_count_ == 1 ? "has" : "have"),
         .count = shared_count_,
         .first = first_shared_});
  if (!lost_of_points_.empty() && file_.mesh.face_count() == 0) {
    std::string names;
    for (const std::string& name : lost_of_points_) names += (names.empty() ? "" : ", ") + name;
    file_.warnings.push_back({.code = "left-out-attributes",
                              .message = "left out of the points: " + names +
                                         "; the mesh that is made of them has normals and colours",
                              .count = std::ssize(lost_of_points_)});
  }
  if (deformed_count_ > 0)
    file_.warnings.push_back({.code = "ignored-deformation",
                              .message = "skins and morph targets move the mesh no more: it is "
                                         "read as the file's nodes pose it, at rest",
                              .count = deformed_count_});
  return std::move(file_);
}

// Where the same bytes are placed often, or only some of them, each place has an equal share of
// the file's.
void SceneReader::read_instance(const GltfInstance& instance, std::size_t bytes) {
  const JsonPlace mesh = root_["meshes"][instance.mesh];
  joints_.clear();
  const auto skin = asset_ == nullptr ? root_["nodes"][instance.node].find("skin") : std::nullopt;
  if (skin) {
    ++deformed_count_;
    joints_ = joint_matrices(root_, skin->integer(), source_);
  }
  const JsonPlace primitives = mesh["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i) {
    if (++primitive_count_ > kMaxPrimitives)
      primitives.fail("the scene places more than {} primitives", kMaxPrimitives);
    read_primitive(primitives[i], instance,
                   bytes / static_cast<std::size_t>(primitives.array_size()));
  }
}

void SceneReader::read_primitive(const JsonPlace& place, const GltfInstance& instance,
                                 std::size_t bytes) {
  constexpr std::int64_t kPoints = 0, kTriangles = 4, kFan = 6;
  constexpr std::int64_t kPiece = 4096;  // corners
  const std::int64_t mode = place.integer_or("mode", kTriangles);
  if (mode > kFan) place["mode"].fail("{} is no mode of primitives", mode);
  const bool has_positions = place["attributes"].find("POSITION").has_value();
  if (mode == kPoints && has_positions && asset_ == nullptr)
    return read_point_primitive(place, instance);
  if (mode < kTriangles || !has_positions) {
    if (asset_ == nullptr) ++file_.dropped_element_count;
    return;
  }
  if (asset_ == nullptr && place.find("targets")) ++deformed_count_;
  const SourcePrimitive primitive(root_, place, source_);
  const std::optional<GltfAccessor> indices = primitive.indices();
  const std::int64_t vertex_count = primitive.positions().count();
  const std::int64_t count = indices ? indices->count() : vertex_count;
  // Fewer corners than a triangle has, as exporters leave of an empty mesh.
  if (count < 3) {
    if (asset_ == nullptr) ++file_.dropped_element_count;
    return;
  }
  budget_.add_triangles(place, vertex_count, count * (mode == kTriangles ? 1 : 3));
  if (stamps_.size() < static_cast<std::size_t>(vertex_count)) {
    stamps_.resize(static_cast<std::size_t>(vertex_count), 0);
    welded_vertices_.resize(stamps_.size());
  }
  ++stamp_;
  if (asset_ != nullptr) asset_->begin_primitive(place, primitive, budget_);
  joint_sets_.clear();
  if (!joints_.empty()) joint_sets_ = primitive.joint_sets();
  corners_.resize(static_cast<std::size_t>(count));
  vertices_.resize(corners_.size());
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t vertex = indices ? indices->index(i) : i;
    if (vertex >= vertex_count)
      place["indices"].fail("entry {} names vertex {} of {}", i, vertex, vertex_count);
    corners_[i] = static_cast<std::int32_t>(vertex);
    vertices_[i] = welded(primitive, vertex, instance);
    if ((i + 1) % kPiece != 0) continue;
    check_stop();
    count_read(progress_,
               bytes * static_cast<std::size_t>(kPiece) / static_cast<std::size_t>(count));
  }
  find_faces(place, mode, glm::determinant(glm::dmat3(placed(0, instance).to_world)) < 0);
  if (faces_.count() == 0) return;
  if (asset_ != nullptr) {
    const AssetCollector::Faces faces{triangles_.mesh(), faces_, corners_, vertices_};
    if (asset_->add_layer(faces, uvs_)) return;
    const int group = asset_->add_faces(faces, uvs_);
    attributes_.use_group({.name = std::to_string(group), .material = ""});
    first_uv_ = asset_->first_number();
  } else {
    name_group(place);
    read_uvs(place, primitive);
  }
  if (creases_from_normals_) read_normals(primitive, instance);
  color_vertices(primitive);
  add_faces();
}

// Where a vertex of the current primitive stands. The place of a node with a skin means nothing.
GltfInstance SceneReader::placed(std::int64_t vertex, const GltfInstance& instance) const {
  if (joint_sets_.empty()) return instance;
  return {instance.mesh, instance.node, posed(joint_sets_, vertex, joints_)};
}

void SceneReader::name_group(const JsonPlace& place) {
  FaceGroup group;
  if (const auto material = place.find("material")) {
    const std::int64_t number = material->integer();
    (void)root_["materials"][number];
    if (material_names_.empty()) material_names_ = material_names(root_);
    group.material = material_names_[number];
  }
  if (const auto extras = place.find("extras"); extras && extras->is_object()) {
    if (const auto name = extras->find("group"); name && name->is_text()) group.name = name->text();
  }
  attributes_.use_group(std::move(group));
}

// Appended for the whole primitive; OBJ's v runs upwards, glTF's down.
void SceneReader::read_uvs(const JsonPlace& place, const SourcePrimitive& primitive) {
  first_uv_ = -1;
  const auto uvs = primitive.attribute("TEXCOORD_0", GltfAccessor::Use::TextureCoordinates);
  if (!uvs) return;
  const JsonPlace attribute = place["attributes"]["TEXCOORD_0"];
  budget_.add_uvs(attribute, uvs->count());
  first_uv_ = static_cast<std::int64_t>(uvs_.size());
  for (std::int64_t i = 0; i < uvs->count(); ++i) {
    const glm::dvec2 uv = uvs->texture_coordinate(i);
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      attribute.fail("the texture coordinate of vertex {} is not finite", i);
    uvs_.emplace_back(uv.x, 1.0 - uv.y);
  }
}

void SceneReader::read_normals(const SourcePrimitive& primitive, const GltfInstance& instance) {
  first_normal_ = -1;
  const auto normals = primitive.attribute("NORMAL", GltfAccessor::Use::Normals);
  if (!normals) return;
  budget_.add_normals(root_["meshes"], normals->count());
  first_normal_ = static_cast<std::int64_t>(normals_.values.size());
  for (std::int64_t i = 0; i < normals->count(); ++i)
    normals_.values.emplace_back(placed_normal(normals->position(i), placed(i, instance)));
}

void SceneReader::color_vertices(const SourcePrimitive& primitive) {
  const auto colors = primitive.attribute("COLOR_0", GltfAccessor::Use::Colors);
  if (!colors) return;
  std::vector<bool> differs(static_cast<std::size_t>(colors->count()), false);
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    if (attributes_.color_vertex(vertices_[i], primitive.color(*colors, corners_[i]))) continue;
    differs[corners_[i]] = true;
    if (first_shared_ < 0) first_shared_ = vertices_[i];
  }
  colored_count_ += colors->count();
  shared_count_ += std::ranges::count(differs, true);
}

// All vertices: indices would only leave some out, or name some twice.
void SceneReader::read_point_primitive(const JsonPlace& place, const GltfInstance& instance) {
  const SourcePrimitive primitive(root_, place, source_);
  ++point_primitive_count_;
  budget_.add_points(place, primitive.positions().count());
  points_.add(primitive, instance);
  if (place.find("material")) lost_of_points_.insert("material");
  for (const std::string& name : place["attributes"].keys())
    if (name != "POSITION" && name != "NORMAL" && name != "COLOR_0") lost_of_points_.insert(name);
}

std::int32_t SceneReader::welded(const SourcePrimitive& primitive, std::int64_t vertex,
                                 const GltfInstance& instance) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (stamps_[slot] != stamp_) {
    stamps_[slot] = stamp_;
    const glm::dvec3 position = primitive.position(vertex, placed(vertex, instance));
    welded_vertices_[slot] =
        asset_ != nullptr ? asset_->weld(welder_, position, vertex) : welder_.insert(position);
  }
  return welded_vertices_[slot];
}

void SceneReader::add_faces() {
  const auto numbered = [&](std::int64_t first, std::int32_t corner) {
    return first < 0 ? -1 : static_cast<std::int32_t>(first + corners_[corner]);
  };
  std::vector<std::int32_t> face;
  for (std::size_t f = 0; f < faces_.count(); ++f) {
    face.clear();
    for (const std::int32_t corner : faces_.face(f)) {
      face.push_back(vertices_[corner]);
      attributes_.add_corner(numbered(first_uv_, corner));
      if (creases_from_normals_) normals_.of_corners.push_back(numbered(first_normal_, corner));
    }
    triangles_.add_polygon(face);
  }
  attributes_.add_faces(faces_.count());
}

void SceneReader::find_faces(const JsonPlace& place, std::int64_t mode, bool mirrored) {
  constexpr std::int64_t kTriangles = 4, kStrip = 5;
  faces_.clear();
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    // A mirror turns front faces into back faces.
    if (mirrored) std::swap(b, c);
    if (triangles_.has_area(vertices_[a], vertices_[b], vertices_[c]))
      faces_.add(std::array{static_cast<std::int32_t>(a), static_cast<std::int32_t>(b),
                            static_cast<std::int32_t>(c)});
  };
  if (mode == kTriangles) {
    if (vertices_.size() % 3 != 0)
      place.fail("{} corners make no whole triangles", vertices_.size());
    if (encodes_polygons(place)) return find_polygons(mirrored);
    for (std::size_t i = 0; i < vertices_.size(); i += 3) add(i, i + 1, i + 2);
    return;
  }
  for (std::size_t i = 0; i + 2 < vertices_.size(); ++i) {
    if (mode == kStrip) {
      add(i, i + 1 + i % 2, i + 2 - i % 2);
    } else {
      add(i + 1, i + 2, 0);
    }
  }
}

// FB_ngon_encoding: the triangles of a polygon follow each other, a fan around its first corner.
// Where they are none, as of a writer that did not know the extension, each stays a triangle.
void SceneReader::find_polygons(bool mirrored) {
  std::vector<std::int32_t> polygon;  // corners
  polygon_of_.resize(static_cast<std::size_t>(welder_.count()), 0);
  const auto extend = [&](std::size_t corner) {
    polygon.push_back(static_cast<std::int32_t>(corner));
    polygon_of_[vertices_[corner]] = polygon_number_;
  };
  const auto end = [&] {
    if (polygon.empty()) return;
    if (mirrored) std::reverse(polygon.begin() + 1, polygon.end());
    faces_.add(polygon);
    polygon.clear();
  };
  for (std::size_t i = 0; i < vertices_.size(); i += 3) {
    if (!triangles_.has_area(vertices_[i], vertices_[i + 1], vertices_[i + 2])) continue;
    const bool goes_on = !polygon.empty() && corners_[i] == corners_[polygon.front()] &&
                         vertices_[i + 1] == vertices_[polygon.back()] &&
                         polygon_of_[vertices_[i + 2]] != polygon_number_;
    if (!goes_on) {
      end();
      ++polygon_number_;
      extend(i);
      extend(i + 1);
    }
    extend(i + 2);
  }
  end();
}

// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7 (meshes) and 4 (GLB).

MeshFile read_gltf(const FileBytes& file) { return read_gltf_within(file, {}); }

MeshFile read_gltf_within(const FileBytes& file, const GltfLimits& limits) {
  const GlbParts parts = split_glb(file.bytes, file.name);
  const nlohmann::json document = parse_json(parts.json, file.name);
  const JsonPlace root(document, file.name, "");
  require_gltf_version(root);
  GltfSource source(root, parts.chunk, file);
  return SceneReader(root, source, GltfBudget(limits, file.name), file).read(parts.format);
}

}  // namespace planish
