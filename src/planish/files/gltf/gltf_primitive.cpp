// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7.2 (meshes), and
// "KHR_draco_mesh_compression", 2018.
#include "planish/files/gltf/gltf_primitive.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/core/number_text.h"

namespace planish {
namespace {

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

}  // namespace planish
