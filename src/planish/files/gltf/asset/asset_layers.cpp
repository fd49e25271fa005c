#include "planish/files/gltf/asset/asset_layers.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>

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

}  // namespace planish
