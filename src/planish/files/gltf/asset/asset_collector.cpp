// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7.2 (meshes), 3.7.3 (skins).
#include "planish/files/gltf/asset/asset_collector.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/primitive_parts.h"

namespace planish {
namespace {

constexpr int kNumbersOfSet = 8;  // four joints and their weights

bool is_vertex_color(std::string_view name) { return name.starts_with("COLOR_"); }
// What a primitive without the attribute has, and the fourth number of a colour of three.
float missing(std::string_view name) { return is_vertex_color(name) ? 1.0f : 0.0f; }

}  // namespace

int AssetCollector::begin_primitive(const JsonPlace& place, const SourcePrimitive& primitive,
                                    GltfBudget& budget) {
  const JsonPlace attributes = place["attributes"];
  uvs_.clear();
  uv_places_.clear();
  arrays_.clear();
  uv_moves_.clear();
  targets_.clear();
  find_uvs(attributes, primitive, budget);
  find_arrays(attributes, primitive, budget);
  find_joints(primitive, budget);
  find_targets(place, primitive, budget);
  const auto next = static_cast<int>(made_.groups.size());
  const auto [group, is_new] =
      group_of_.try_emplace(without_vertices(place.value()).dump(-1, ' ', true), next);
  const std::int64_t number = primitive_number(place.path());
  if (is_new) made_.groups.push_back({.primitive = number});
  int& sets = made_.groups[group->second].uv_sets;
  sets = std::max(sets, uv_set_count());
  return group->second;
}

void AssetCollector::find_uvs(const JsonPlace& attributes, const SourcePrimitive& primitive,
                              GltfBudget& budget) {
  for (int set = 0;; ++set) {
    const std::string name = formatted("TEXCOORD_{}", set);
    auto uvs = primitive.attribute(name, GltfAccessor::Use::TextureCoordinates);
    if (!uvs) return;
    budget.add_uvs(attributes[name], uvs->count());
    uvs_.push_back(*uvs);
    uv_places_.push_back(attributes[name]);
  }
}

std::int64_t AssetCollector::number_vertices(std::int64_t count, std::vector<glm::dvec2>& first) {
  const std::int64_t begin = number_count_;
  number_count_ += count;
  numbered_.push_back({begin, count, !uvs_.empty(), arrays_});
  const auto before = static_cast<std::size_t>(begin);
  if (!uvs_.empty()) made_.further_uvs.resize(std::max(made_.further_uvs.size(), uvs_.size() - 1));
  for (std::size_t set = 0; set < uvs_.size(); ++set) {
    std::vector<glm::dvec2>& to = set == 0 ? first : made_.further_uvs[set - 1];
    to.resize(before, glm::dvec2(0.0));
    for (std::int64_t i = 0; i < uvs_[set].count(); ++i) {
      const glm::dvec2 uv = uvs_[set].texture_coordinate(i);
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
        uv_places_[set].fail("the texture coordinate of vertex {} is not finite", i);
      // Ours run upwards, glTF's down.
      to.emplace_back(uv.x, 1.0 - uv.y);
    }
  }
  for (const UvSource& source : uv_moves_) {
    std::vector<glm::dvec2>& to = made_.uv_moves[source.of].values;
    to.resize(before, glm::dvec2(0.0));
    for (std::int64_t i = 0; i < source.moves.count(); ++i) {
      const glm::dvec2 move = source.moves.texture_coordinate(i);
      if (!std::isfinite(move.x) || !std::isfinite(move.y))
        source.place.fail("the move of vertex {} is not finite", i);
      to.push_back(move);
    }
  }
  return begin;
}

void AssetCollector::find_arrays(const JsonPlace& attributes, const SourcePrimitive& primitive,
                                 GltfBudget& budget) {
  for (const std::string& name : attributes.keys()) {
    const bool is_color = is_vertex_color(name);
    if (!is_color && !name.starts_with("_")) continue;
    const auto values = primitive.attribute(name, GltfAccessor::Use::Vectors);
    add_array(attributes[name], *values,
              {.name = name,
               .width = is_color ? 4 : static_cast<int>(values->number_count()),
               .values = {},
               .is_of_things = values->is_integer() || name.starts_with("_FEATURE_ID_"),
               .is_integer = values->is_short()},
              budget);
  }
}

void AssetCollector::add_array(const JsonPlace& place, const GltfAccessor& values,
                               const AssetArray& kind, GltfBudget& budget) {
  budget.add_numbers(place, kind.width * values.count());
  auto known = std::ranges::find(made_.arrays, kind.name, &AssetArray::name);
  if (known == made_.arrays.end()) {
    made_.arrays.push_back(kind);
    differs_.push_back(false);
    known = made_.arrays.end() - 1;
    known->values.resize(static_cast<std::size_t>(kind.width * vertex_count_), missing(kind.name));
  } else if (known->width != kind.width) {
    place.fail("{} numbers a vertex, and another primitive of the mesh has {}", kind.width,
               known->width);
  }
  known->is_of_things |= kind.is_of_things;
  known->is_integer &= kind.is_integer;
  arrays_.push_back({values, static_cast<std::size_t>(known - made_.arrays.begin())});
}

void AssetCollector::find_joints(const SourcePrimitive& primitive, GltfBudget& budget) {
  joints_ = primitive.joint_sets();
  for (const JointSet& set : joints_)
    budget.add_numbers(set.place, kNumbersOfSet * set.joints.count());
  made_.joint_sets = std::max(made_.joint_sets, static_cast<int>(joints_.size()));
  if (!joints_.empty() && made_.first_influence.empty())
    made_.first_influence.assign(static_cast<std::size_t>(vertex_count_) + 1, 0);
}

void AssetCollector::find_targets(const JsonPlace& place, const SourcePrimitive& primitive,
                                  GltfBudget& budget) {
  const auto targets = place.find("targets");
  const auto count = static_cast<std::size_t>(targets ? targets->array_size() : 0);
  if (next_primitive_++ > 0 && count != made_.targets.size())
    place.fail(
        "{} morph targets, and another primitive of the mesh has {}; all of a mesh need the same",
        count, made_.targets.size());
  made_.targets.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const JsonPlace target = (*targets)[static_cast<std::int64_t>(k)];
    const auto moves = target.find("POSITION");
    targets_.emplace_back();
    find_target(target, k, primitive, budget);
    if (!moves) continue;
    budget.add_numbers(*moves, 6 * primitive.positions().count());
    targets_.back() = Target{*moves, primitive.target(*moves, GltfAccessor::Use::Positions)};
  }
}

// What a target moves besides positions; normals are made anew.
void AssetCollector::find_target(const JsonPlace& target, std::size_t number,
                                 const SourcePrimitive& primitive, GltfBudget& budget) {
  for (const std::string& name : target.keys()) {
    if (name == "POSITION" || name == "NORMAL") continue;
    const JsonPlace place = target[name];
    const std::string full = formatted("target/{}/{}", number, name);
    if (is_vertex_color(name)) {
      add_array(place, primitive.target(place, GltfAccessor::Use::Colors),
                {.name = full, .width = 4, .values = {}}, budget);
    } else if (name.starts_with("TEXCOORD_") && uv_set_count() > 0) {
      const GltfAccessor moves = primitive.target(place, GltfAccessor::Use::TextureCoordinates);
      budget.add_uvs(place, moves.count());
      auto known = std::ranges::find(made_.uv_moves, full, &AssetUvMoves::name);
      if (known == made_.uv_moves.end()) {
        made_.uv_moves.push_back({full, {}});
        known = made_.uv_moves.end() - 1;
      }
      uv_moves_.push_back({place, moves, static_cast<std::size_t>(known - made_.uv_moves.begin())});
    } else {
      lost_targets_.insert(name);
    }
  }
}

void AssetCollector::read_motion(std::int64_t vertex) {
  influences_.clear();
  moves_.clear();
  append_influences(joints_, vertex, influences_);
  for (const std::optional<Target>& target : targets_) {
    const glm::dvec3 move = target ? target->moves.position(vertex) : glm::dvec3(0.0);
    if (!std::isfinite(move.x) || !std::isfinite(move.y) || !std::isfinite(move.z))
      target->place.fail("the move of vertex {} is not finite", vertex);
    moves_.push_back(move);
  }
}

bool AssetCollector::moves_like(std::int32_t welded, const glm::dvec3& position) const {
  if (!made_.first_influence.empty() &&
      !std::ranges::equal(made_.influences_of(welded), influences_))
    return false;
  const auto largest = [](const glm::dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  for (std::size_t k = 0; k < moves_.size(); ++k) {
    const glm::dvec3 apart = made_.targets[k][welded] - moves_[k];
    if (largest(apart) > kRemainder * std::max(largest(position), largest(moves_[k]))) return false;
  }
  return true;
}

std::int32_t AssetCollector::weld(Welder& welder, const glm::dvec3& position, std::int64_t vertex) {
  const std::int32_t before = welder.count();
  std::int32_t welded = welder.insert(position);
  read_motion(vertex);
  if (welded == before) {
    append(vertex);
    return welded;
  }
  if (!made_.moves()) {
    compare(welded, vertex);
    return welded;
  }
  while (!moves_like(welded, position)) {
    const auto [next, is_new] = apart_.try_emplace(welded, before);
    if (is_new) {
      append(vertex);
      return welder.insert_apart(position);
    }
    welded = next->second;
  }
  compare(welded, vertex);
  return welded;
}

float AssetCollector::number(const Source& source, std::int64_t vertex, int k) const {
  return k < source.accessor.number_count() ? static_cast<float>(source.accessor.value(vertex, k))
                                            : missing(made_.arrays[source.array].name);
}

// What the primitive has, and what it lacks.
void AssetCollector::compare(std::int32_t welded, std::int64_t vertex) {
  for (std::size_t i = 0; i < made_.arrays.size(); ++i) {
    if (differs_[i]) continue;
    const AssetArray& array = made_.arrays[i];
    const auto source = std::ranges::find(arrays_, i, &Source::array);
    for (int k = 0; k < array.width; ++k) {
      const float own = source == arrays_.end() ? missing(array.name) : number(*source, vertex, k);
      if (array.values[static_cast<std::size_t>(array.width * welded + k)] != own)
        differs_[i] = true;
    }
  }
}

void AssetCollector::append(std::int64_t vertex) {
  ++vertex_count_;
  for (const Source& source : arrays_) {
    AssetArray& array = made_.arrays[source.array];
    for (int k = 0; k < array.width; ++k) array.values.push_back(number(source, vertex, k));
  }
  // Of those that this primitive lacks.
  for (AssetArray& array : made_.arrays)
    array.values.resize(static_cast<std::size_t>(array.width * vertex_count_), missing(array.name));
  if (!made_.first_influence.empty()) {
    made_.influences.insert(made_.influences.end(), influences_.begin(), influences_.end());
    made_.first_influence.push_back(std::ssize(made_.influences));
  }
  for (std::size_t k = 0; k < moves_.size(); ++k) made_.targets[k].push_back(moves_[k]);
}

void AssetCollector::give_corners(AssetArray& array, std::size_t index) const {
  array.of_corners = true;
  array.values.assign(static_cast<std::size_t>(array.width * number_count_), missing(array.name));
  for (const Numbered& of : numbered_) {
    const auto source = std::ranges::find(of.sources, index, &Source::array);
    if (source == of.sources.end()) continue;
    auto to = array.values.begin() + array.width * of.first;
    for (std::int64_t i = 0; i < of.count; ++i)
      for (int k = 0; k < array.width; ++k) *to++ = number(*source, i, k);
  }
}

// Vertices without texture coordinates that have the same of what differs are one.
void AssetCollector::keep_numbers(PolygonMesh& mesh) const {
  std::vector<const AssetArray*> differing;
  for (const AssetArray& array : made_.arrays)
    if (array.of_corners) differing.push_back(&array);
  const auto is_alike = [&](std::int32_t a, std::int32_t b) {
    return std::ranges::all_of(differing, [&](const AssetArray* array) {
      const auto at = [&](std::int32_t number) {
        return std::span(array->values)
            .subspan(static_cast<std::size_t>(array->width * number),
                     static_cast<std::size_t>(array->width));
      };
      return std::ranges::equal(at(a), at(b));
    });
  };
  std::unordered_map<std::int32_t, std::vector<std::int32_t>> known;  // by vertex
  bool has_any = false;
  for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c) {
    std::int32_t& number = mesh.face_uvs[c];
    const auto of = std::ranges::upper_bound(numbered_, std::int64_t{number}, {}, &Numbered::first);
    if (!std::prev(of)->has_uvs) {
      if (differing.empty()) {
        number = -1;
        continue;
      }
      std::vector<std::int32_t>& here = known[mesh.face_vertices[c]];
      const auto same =
          std::ranges::find_if(here, [&](std::int32_t one) { return is_alike(one, number); });
      if (same == here.end()) {
        here.push_back(number);
      } else {
        number = *same;
      }
    }
    has_any = true;
  }
  if (!has_any) {
    mesh.uvs.clear();
    mesh.face_uvs.clear();
  }
}

AssetVertices AssetCollector::finish(PolygonMesh& mesh) {
  const auto numbers = static_cast<std::size_t>(number_count_);
  for (std::vector<glm::dvec2>& set : made_.further_uvs) set.resize(numbers, glm::dvec2(0.0));
  for (AssetUvMoves& moves : made_.uv_moves) moves.values.resize(numbers, glm::dvec2(0.0));
  mesh.uvs.resize(numbers, glm::dvec2(0.0));
  for (std::size_t i = 0; i < made_.arrays.size(); ++i)
    if (differs_[i]) give_corners(made_.arrays[i], i);
  keep_numbers(mesh);
  // Colours that do not differ are the mesh's own.
  const auto colors = std::ranges::find(made_.arrays, "COLOR_0", &AssetArray::name);
  if (colors != made_.arrays.end() && colors->of_corners) {
    mesh.colors.clear();
  } else if (colors != made_.arrays.end()) {
    made_.arrays.erase(colors);
  }
  if (!lost_targets_.empty()) {
    std::string names;
    for (const std::string& name : lost_targets_) names += (names.empty() ? "" : ", ") + name;
    made_.warnings.push_back(
        {"left-out-targets",
         formatted("morph targets move no {} any more; positions, normals, colours and texture "
                   "coordinates they move",
                   names),
         std::ssize(lost_targets_)});
  }
  return std::move(made_);
}

}  // namespace planish
