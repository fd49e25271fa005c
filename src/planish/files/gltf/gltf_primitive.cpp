// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7.2 (meshes), and
// "KHR_draco_mesh_compression", 2018.
#include "planish/files/gltf/gltf_primitive.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/core/number_text.h"

namespace planish {
namespace {

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

GltfAccessor SourcePrimitive::target(const JsonPlace& place) const {
  GltfAccessor found(root_, place.integer(), GltfAccessor::Use::Positions, source_);
  if (found.count() != positions().count())
    place.fail("{} elements for {} vertices", found.count(), positions().count());
  return found;
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
