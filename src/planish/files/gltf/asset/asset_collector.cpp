#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/read_gltf.h"

namespace planish {
namespace {

std::uint64_t pair_key(std::int32_t a, std::int32_t b) {
  return std::uint64_t{static_cast<std::uint32_t>(a)} << 32 | static_cast<std::uint32_t>(b);
}

// A face by its least vertex and the one after it.
std::uint64_t face_key(std::span<const std::int32_t> face) {
  const auto least = std::ranges::min_element(face);
  const auto next = std::next(least) == face.end() ? face.begin() : std::next(least);
  return pair_key(*least, *next);
}

// How far `other` is turned against `face`; -1: it is another face.
std::ptrdiff_t turn_of(std::span<const std::int32_t> face, std::span<const std::int32_t> other) {
  if (face.size() != other.size()) return -1;
  const auto begin = std::ranges::find(other, face.front());
  const bool is_same = std::equal(begin, other.end(), face.begin()) &&
                       std::equal(other.begin(), begin, face.begin() + (other.end() - begin));
  return is_same ? begin - other.begin() : -1;
}

// Values of width numbers each, by other numbers; those of negative ones are `missing`.
template <class Value>
std::vector<Value> gathered(const std::vector<Value>& values, std::size_t width,
                            std::span<const std::int32_t> numbers, const Value& missing) {
  std::vector<Value> made(width * numbers.size(), missing);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] >= 0)
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(width) * numbers[i], width,
                  made.begin() + static_cast<std::ptrdiff_t>(width * i));
  return made;
}

AssetArray gathered(const AssetArray& array, std::span<const std::int32_t> numbers) {
  AssetArray made = array;
  made.values =
      gathered(array.values, static_cast<std::size_t>(array.width), numbers, array.missing());
  return made;
}

}  // namespace

void AssetLayers::begin_kind(std::int32_t first_face, int kind) {
  kinds_.push_back({first_face, kind});
}

int AssetLayers::kind_of(std::int32_t face) const {
  return std::prev(std::ranges::upper_bound(kinds_, face, {}, &Kind::first_face))->kind;
}

int AssetLayers::uv_sets_at(int depth) const {
  int sets = 0;
  for (const Layer& one : layers_)
    if (one.made.depth == depth) sets = std::max(sets, one.made.uv_sets);
  return sets;
}

AssetLayers::Found AssetLayers::face_of(const PolygonMesh& mesh,
                                        std::span<const std::int32_t> vertices) {
  for (; known_faces_ < mesh.face_count(); ++known_faces_)
    faces_.emplace(face_key(mesh.face(known_faces_)), known_faces_);
  Found first;
  const auto [begin, end] = faces_.equal_range(face_key(vertices));
  for (auto one = begin; one != end; ++one) {
    if (first.face >= 0 && one->second > first.face) continue;
    const std::ptrdiff_t turn = turn_of(mesh.face(one->second), vertices);
    if (turn >= 0) first = {one->second, static_cast<std::size_t>(turn)};
  }
  return first;
}

bool AssetLayers::find(const PolygonMesh& mesh, const PrimitiveFaces& faces,
                       std::span<const std::int32_t> vertices, int kind) {
  found_.clear();
  depth_ = 0;
  std::vector<std::int32_t> face;
  for (std::size_t f = 0; f < faces.count(); ++f) {
    face.clear();
    for (const std::int32_t corner : faces.face(f)) face.push_back(vertices[corner]);
    const Found found = face_of(mesh, face);
    const std::int32_t base = found.face;
    if (base < 0 || kind_of(base) == kind) return false;
    for (std::size_t depth = 0; depth < depths_.size(); ++depth) {
      const std::vector<std::int32_t>& layers = depths_[depth].layer_of_face;
      if (static_cast<std::size_t>(base) >= layers.size() || layers[base] < 0) continue;
      if (layers_[layers[base]].kind == kind) return false;
      depth_ = std::max(depth_, depth + 1);
    }
    found_.push_back(found);
  }
  return !found_.empty();
}

void AssetLayers::add(const PolygonMesh& mesh, const PrimitiveFaces& faces,
                      std::span<const std::int32_t> numbers, AssetLayer layer, int kind) {
  layer.depth = static_cast<int>(depth_) + 1;
  depths_.resize(std::max(depths_.size(), depth_ + 1));
  Depth& depth = depths_[depth_];
  depth.layer_of_face.resize(static_cast<std::size_t>(mesh.face_count()), -1);
  depth.numbers.resize(mesh.face_vertices.size(), -1);
  for (std::size_t f = 0; f < found_.size(); ++f) {
    const std::span<const std::int32_t> corners = faces.face(f);
    const auto [base, turn] = found_[f];
    depth.layer_of_face[base] = static_cast<std::int32_t>(layers_.size());
    for (std::size_t k = 0; k < corners.size(); ++k)
      depth.numbers[static_cast<std::size_t>(mesh.face_offsets[base]) + k] =
          numbers[corners[(turn + k) % corners.size()]];
  }
  layers_.push_back({layer, kind});
}

void AssetLayers::join(PolygonMesh& mesh, AssetVertices& made, const Given& given) const {
  join_groups(mesh, made);
  join_corners(mesh, made, given);
}

// One depth after another: an index stands for one that was before and a number of the layer.
void AssetLayers::join_corners(PolygonMesh& mesh, AssetVertices& made, const Given& given) const {
  if (mesh.face_uvs.empty()) mesh.face_uvs.assign(mesh.face_vertices.size(), -1);
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const std::vector<std::int32_t>& numbers = depths_[d].numbers;
    std::unordered_map<std::uint64_t, std::int32_t> known;
    std::vector<std::int32_t> before, of_layer;
    for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c) {
      const std::int32_t number = c < numbers.size() ? numbers[c] : -1;
      if (mesh.face_uvs[c] < 0 && number < 0) continue;
      const auto [index, is_new] = known.try_emplace(pair_key(mesh.face_uvs[c], number),
                                                     static_cast<std::int32_t>(before.size()));
      if (is_new) {
        before.push_back(mesh.face_uvs[c]);
        of_layer.push_back(number);
      }
      mesh.face_uvs[c] = index->second;
    }
    constexpr glm::dvec2 kNone(0.0);
    mesh.uvs = gathered(mesh.uvs, 1, before, kNone);
    for (std::vector<glm::dvec2>& set : made.further_uvs) set = gathered(set, 1, before, kNone);
    for (AssetUvMoves& moves : made.uv_moves)
      moves.values = gathered(moves.values, 1, before, kNone);
    for (AssetArray& array : made.arrays)
      if (array.of_corners) array = gathered(array, before);
    const int layer = static_cast<int>(d) + 1;
    for (int set = 0; set < uv_sets_at(layer); ++set)
      made.further_uvs.push_back(gathered(given.uvs[set], 1, of_layer, kNone));
    for (const AssetUvMoves& moves : given.uv_moves)
      made.uv_moves.push_back(
          {moves.name, moves.set, gathered(moves.values, 1, of_layer, kNone), layer});
    for (const AssetArray& array : given.arrays)
      made.arrays.emplace_back(gathered(array, of_layer)).layer = layer;
  }
}

void AssetLayers::join_groups(PolygonMesh& mesh, AssetVertices& made) const {
  // The first set is that whose indices all have.
  int next_set = static_cast<int>(made.further_uvs.size()) + 1;
  std::vector<AssetLayer> layers;
  for (const Layer& one : layers_) layers.push_back(one.made);
  for (int depth = 1; depth <= static_cast<int>(depths_.size()); ++depth) {
    for (AssetLayer& one : layers)
      if (one.depth == depth) one.first_uv_set = next_set;
    next_set += uv_sets_at(depth);
  }
  // A group by itself and the layers on it. The first of each is that group, the others are new.
  std::map<std::vector<std::int32_t>, std::int32_t> known;
  std::vector<bool> is_taken(made.groups.size(), false);
  const std::vector<AssetGroup> bare = made.groups;
  std::vector<std::int32_t> key;
  for (std::size_t f = 0; f < mesh.face_groups.size(); ++f) {
    key = {mesh.face_groups[f]};
    for (const Depth& depth : depths_)
      key.push_back(f < depth.layer_of_face.size() ? depth.layer_of_face[f] : -1);
    const auto [group, is_new] = known.try_emplace(key, key.front());
    if (is_new) {
      if (is_taken[key.front()]) {
        group->second = static_cast<std::int32_t>(made.groups.size());
        made.groups.push_back(bare[key.front()]);
        mesh.groups.push_back({.name = std::to_string(group->second), .material = ""});
      }
      is_taken[key.front()] = true;
      for (std::size_t d = 1; d < key.size(); ++d)
        if (key[d] >= 0) made.groups[group->second].layers.push_back(layers[key[d]]);
    }
    mesh.face_groups[f] = group->second;
  }
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7.2 (meshes), 3.7.3 (skins).

constexpr int kNumbersOfSet = 8;  // four joints and their weights

bool is_vertex_color(std::string_view name) { return name.starts_with("COLOR_"); }

}  // namespace

void AssetCollector::begin_primitive(const JsonPlace& place, const SourcePrimitive& primitive,
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
  number_ = primitive_number(place.path());
  kind_ = kinds_
              .try_emplace(without_vertices(place.value()).dump(-1, ' ', true),
                           static_cast<int>(kinds_.size()))
              .first->second;
  count_ = primitive.positions().count();
  is_on_others_ = true;
}

bool AssetCollector::add_layer(const Faces& faces, std::vector<glm::dvec2>& first) {
  if (!is_on_others_ || !layers_.find(faces.mesh, faces.faces, faces.vertices, kind_)) return false;
  number_vertices(faces, true, first);
  std::vector<std::int32_t> numbers;
  for (const std::int32_t vertex : faces.corners)
    numbers.push_back(static_cast<std::int32_t>(first_number()) + vertex);
  const AssetLayer layer{.primitive = number_, .uv_sets = static_cast<int>(uvs_.size())};
  layers_.add(faces.mesh, faces.faces, numbers, layer, kind_);
  return true;
}

int AssetCollector::add_faces(const Faces& faces, std::vector<glm::dvec2>& first) {
  const auto [group, is_new] = group_of_.try_emplace(kind_, static_cast<int>(made_.groups.size()));
  if (is_new) made_.groups.push_back({.primitive = number_});
  int& sets = made_.groups[group->second].uv_sets;
  sets = std::max(sets, static_cast<int>(uvs_.size()));
  layers_.begin_kind(faces.mesh.face_count(), kind_);
  number_vertices(faces, false, first);
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

void AssetCollector::number_vertices(const Faces& faces, bool is_layer,
                                     std::vector<glm::dvec2>& first) {
  const std::size_t before = vertex_of_.size();
  numbered_.push_back(
      {static_cast<std::int64_t>(before), count_, is_layer, !uvs_.empty(), arrays_, {}});
  vertex_of_.resize(before + static_cast<std::size_t>(count_), -1);
  for (std::size_t c = 0; !is_layer && c < faces.corners.size(); ++c)
    vertex_of_[before + static_cast<std::size_t>(faces.corners[c])] = faces.vertices[c];
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
    numbered_.back().uv_moves.push_back(source.of);
    std::vector<glm::dvec2>& to = made_.uv_moves[source.of].values;
    to.resize(before, glm::dvec2(0.0));
    for (std::int64_t i = 0; i < source.moves.count(); ++i) {
      const glm::dvec2 move = source.moves.texture_coordinate(i);
      if (!std::isfinite(move.x) || !std::isfinite(move.y))
        source.place.fail("the move of vertex {} is not finite", i);
      to.push_back(move);
    }
  }
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
               .is_integer = values->is_short(),
               .of_corners = true},
              budget);
  }
}

void AssetCollector::add_array(const JsonPlace& place, const GltfAccessor& values,
                               const AssetArray& kind, GltfBudget& budget) {
  budget.add_numbers(place, kind.width * values.count());
  auto known = std::ranges::find(made_.arrays, kind.name, &AssetArray::name);
  if (known == made_.arrays.end()) {
    made_.arrays.push_back(kind);
    known = made_.arrays.end() - 1;
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
                {.name = full, .width = 4, .values = {}, .of_corners = true}, budget);
    } else if (const int set = uv_set(name); set >= 0 && set < std::ssize(uvs_)) {
      const GltfAccessor moves = primitive.target(place, GltfAccessor::Use::TextureCoordinates);
      budget.add_uvs(place, moves.count());
      auto known = std::ranges::find(made_.uv_moves, full, &AssetUvMoves::name);
      if (known == made_.uv_moves.end()) {
        made_.uv_moves.push_back({full, set, {}});
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
  if (welded == before) {
    read_motion(vertex);
    append();
    return welded;
  }
  if (!made_.moves()) return welded;
  read_motion(vertex);
  while (!moves_like(welded, position)) {
    const auto [next, is_new] = apart_.try_emplace(welded, before);
    if (is_new) {
      append();
      return welder.insert_apart(position);
    }
    welded = next->second;
  }
  return welded;
}

void AssetCollector::append() {
  ++vertex_count_;
  is_on_others_ = false;
  if (!made_.first_influence.empty()) {
    made_.influences.insert(made_.influences.end(), influences_.begin(), influences_.end());
    made_.first_influence.push_back(std::ssize(made_.influences));
  }
  for (std::size_t k = 0; k < moves_.size(); ++k) made_.targets[k].push_back(moves_[k]);
}

// What a primitive lacks is missing, as is the fourth number of a colour of three.
std::vector<float> AssetCollector::by_numbers(std::size_t index) const {
  const AssetArray& array = made_.arrays[index];
  const auto width = static_cast<std::size_t>(array.width);
  std::vector<float> values(width * vertex_of_.size(), array.missing());
  for (const Numbered& of : numbered_) {
    const auto source = std::ranges::find(of.arrays, index, &Source::array);
    if (source == of.arrays.end()) continue;
    const int count = std::min(array.width, static_cast<int>(source->accessor.number_count()));
    auto to = values.begin() + array.width * of.first;
    for (std::int64_t i = 0; i < of.count; ++i, to += array.width)
      for (int k = 0; k < count; ++k) to[k] = static_cast<float>(source->accessor.value(i, k));
  }
  return values;
}

// Numbers that are the same wherever vertices are at one place are of vertices.
void AssetCollector::settle(AssetArray& array) const {
  const auto width = static_cast<std::size_t>(array.width);
  std::vector<float> values(width * static_cast<std::size_t>(vertex_count_), array.missing());
  std::vector<bool> is_known(static_cast<std::size_t>(vertex_count_), false);
  for (std::size_t number = 0; number < vertex_of_.size(); ++number) {
    if (vertex_of_[number] < 0) continue;
    const auto vertex = static_cast<std::size_t>(vertex_of_[number]);
    const auto own = std::span(array.values).subspan(width * number, width);
    const auto known = std::span(values).subspan(width * vertex, width);
    if (!is_known[vertex]) std::ranges::copy(own, known.begin());
    is_known[vertex] = true;
    if (!std::ranges::equal(own, known)) return;
  }
  array.values = std::move(values);
  array.of_corners = false;
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

// What layers alone have is not the mesh's own.
AssetLayers::Given AssetCollector::take_layers(const std::vector<glm::dvec2>& uvs) {
  AssetLayers::Given given{.uvs = {uvs}, .uv_moves = {}, .arrays = {}};
  given.uvs.insert(given.uvs.end(), made_.further_uvs.begin(), made_.further_uvs.end());
  int sets = 1;
  for (const AssetGroup& group : made_.groups) sets = std::max(sets, group.uv_sets);
  made_.further_uvs.resize(static_cast<std::size_t>(sets - 1));
  const auto is_in = [&](bool is_layer, const auto& has) {
    return std::ranges::any_of(
        numbered_, [&](const Numbered& of) { return of.is_layer == is_layer && has(of); });
  };
  std::vector<AssetUvMoves> moves;
  for (std::size_t i = 0; i < made_.uv_moves.size(); ++i) {
    const auto has = [&](const Numbered& of) { return std::ranges::count(of.uv_moves, i) > 0; };
    if (is_in(true, has)) given.uv_moves.push_back(made_.uv_moves[i]);
    if (is_in(false, has)) moves.push_back(std::move(made_.uv_moves[i]));
  }
  made_.uv_moves = std::move(moves);
  std::vector<AssetArray> arrays;
  for (std::size_t i = 0; i < made_.arrays.size(); ++i) {
    const auto has = [&](const Numbered& of) {
      return std::ranges::count(of.arrays, i, &Source::array) > 0;
    };
    if (is_in(true, has)) given.arrays.push_back(made_.arrays[i]);
    if (is_in(false, has)) arrays.push_back(std::move(made_.arrays[i]));
  }
  made_.arrays = std::move(arrays);
  return given;
}

AssetVertices AssetCollector::finish(PolygonMesh& mesh) {
  const std::size_t numbers = vertex_of_.size();
  for (std::vector<glm::dvec2>& set : made_.further_uvs) set.resize(numbers, glm::dvec2(0.0));
  for (AssetUvMoves& moves : made_.uv_moves) moves.values.resize(numbers, glm::dvec2(0.0));
  mesh.uvs.resize(numbers, glm::dvec2(0.0));
  for (std::size_t i = 0; i < made_.arrays.size(); ++i) made_.arrays[i].values = by_numbers(i);
  AssetLayers::Given of_layers;
  if (!layers_.empty()) of_layers = take_layers(mesh.uvs);
  for (AssetArray& array : made_.arrays) settle(array);
  keep_numbers(mesh);
  // Colours that do not differ are the mesh's own.
  const auto colors = std::ranges::find(made_.arrays, "COLOR_0", &AssetArray::name);
  if (colors != made_.arrays.end() && colors->of_corners) {
    mesh.colors.clear();
  } else if (colors != made_.arrays.end()) {
    made_.arrays.erase(colors);
  }
  if (!layers_.empty()) layers_.join(mesh, made_, of_layers);
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
