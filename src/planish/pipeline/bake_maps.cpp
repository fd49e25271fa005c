#include "planish/pipeline/bake_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_json.h"
#include "planish/files/gltf/gltf_tangents.h"
#include "planish/files/images.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

constexpr std::int64_t kFacesAtOnce = std::int64_t{1} << 12;
constexpr int kLeastLevel = 2, kMostLevel = 6;
// Normals are exact at the corners of facets and linear between them: four texels of a facet bring
// no more error than rounding to 8 bits does.
constexpr double kTexelsOfFacet = 2;

// Of what a map covers. Charts that touch have samples in common by rounding, which nobody sees.
constexpr double kToldOverlap = 1e-5;

// The triangles that write_gltf() writes of these groups.
BakeSheet sheet_of(const SurfaceBlocks& surface, const LevelUvs& uvs, std::span<const int> sets,
                   const SurfaceTangents* tangents) {
  GltfAttribute values{.name = {}, .width = 4, .of_uvs = true};
  if (tangents != nullptr) {
    values.values = tangents->values;
    values.further = tangents->further;
    values.further_values = tangents->further_values;
  }
  struct Piece : TangentClusters {
    RawVector<std::int32_t> faces;  // of the mesh, by face of the piece
  };
  BakeSheet sheet;
  in_order<Piece>(
      ranges_of(surface.info().face_count, kFacesAtOnce),
      [&](RowRange faces, Piece& piece) {
        TangentClusterMaker(surface, sets)(faces, piece);
        piece.faces.resize(static_cast<std::size_t>(faces.count));
        surface.ancestors(faces, piece.faces);
      },
      [&](RowRange faces, const Piece& piece) {
        const std::size_t first = sheet.vertices.size();
        sheet.vertices.resize(first + piece.rows.size());
        for (const TangentCluster& cluster : piece.clusters) {
          const TangentShape& shape = piece.shapes[cluster.shape];
          for (std::size_t v = 0; v < shape.first.size(); ++v) {
            const std::size_t at = cluster.first_vertex + v;
            const auto uv = static_cast<std::size_t>(std::max(piece.uvs[at], 0));
            BakeVertex& vertex = sheet.vertices[first + at];
            vertex = {.uv = glm::vec2(uvs.sets[static_cast<std::size_t>(cluster.set)][uv]),
                      .normal = piece.normals[at]};
            if (tangents == nullptr) continue;
            const float* numbers = values.numbers(piece.uvs[at], piece.rows[at]);
            vertex.tangent = {numbers[0], numbers[1], numbers[2], numbers[3]};
          }
          const auto vertex_of = [&](std::size_t corner) {
            return static_cast<std::int32_t>(first + cluster.first_vertex + shape.corners[corner]);
          };
          for (std::size_t q = 0; 4 * q < shape.corners.size(); ++q) {
            const std::size_t c = 4 * q;
            const bool is_from_1 = piece.cuts[cluster.first_cut + q] != 0;
            const std::int32_t face = piece.faces[static_cast<std::size_t>(
                cluster.face - faces.first + static_cast<std::int64_t>(q))];
            for (const std::array<std::int32_t, 3>& triangle :
                 {std::array{vertex_of(c), vertex_of(c + 1), vertex_of(c + (is_from_1 ? 3 : 2))},
                  std::array{vertex_of(c + (is_from_1 ? 1 : 0)), vertex_of(c + 2),
                             vertex_of(c + 3)}}) {
              // A triangle's quad has one corner twice.
              if (triangle[1] == triangle[2]) continue;
              sheet.triangles.push_back(triangle);
              sheet.faces.push_back(face);
            }
          }
        }
      });
  return sheet;
}

bool has_uvs(const PolygonMesh& mesh, std::int32_t face) {
  if (mesh.face_uvs.empty()) return false;
  for (std::int32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c)
    if (mesh.face_uvs[static_cast<std::size_t>(c)] < 0) return false;
  return true;
}

std::size_t group_of(const PolygonMesh& mesh, std::int32_t face) {
  return mesh.face_groups.empty() ? 0 : static_cast<std::size_t>(mesh.face_groups[face]);
}

// "face 12, texture coordinates 1.5 0.25".
std::string place_text(const PolygonMesh& mesh, std::span<const glm::dvec2> uvs,
                       std::int32_t face) {
  glm::dvec2 farthest(0.5);
  const auto out_by = [](const glm::dvec2& uv) {
    return std::max(std::abs(uv.x - 0.5), std::abs(uv.y - 0.5));
  };
  for (std::int32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
    const glm::dvec2& uv =
        uvs[static_cast<std::size_t>(mesh.face_uvs[static_cast<std::size_t>(c)])];
    if (out_by(uv) > out_by(farthest)) farthest = uv;
  }
  return formatted("face {}, texture coordinates {} {}", face, short_number(farthest.x),
                   short_number(farthest.y));
}

// Why a map stands for no place, or several at once; empty: it does not.
std::string why_useless(const NormalMap& map, const PolygonMesh& mesh,
                        std::span<const glm::dvec2> uvs) {
  if (map.repeating_face >= 0)
    return formatted(
        "its texture repeats ({}), and a baked map holds each place once; unwrap the mesh into the "
        "square from 0 to 1",
        place_text(mesh, uvs, map.repeating_face));
  if (map.covered > 0) return {};
  return "its texture coordinates have no area; unwrap the mesh into the square from 0 to 1";
}

// Warns of what a map cannot show.
void tell_of_map(const NormalMap& map, const PolygonMesh& mesh, std::span<const glm::dvec2> uvs,
                 const std::string& where, const Callbacks& callbacks) {
  if (map.overlapped >= kToldOverlap)
    callbacks.warn(
        {"bake-overlap",
         formatted("{}: {} of the texels that it covers belong to several places "
                   "(first {}), which share the normals of the first: right where these "
                   "are mirrored or copied shapes, else unwrap them apart",
                   where, percent(map.overlapped), place_text(mesh, uvs, map.overlapping_face)),
         1, map.overlapping_face});
  if (map.outside_face >= 0)
    callbacks.warn({"bake-wrapped",
                    formatted("{}: texture coordinates leave the square from 0 to 1 (first {}) and "
                              "are wrapped into it, as samplers that repeat do",
                              where, place_text(mesh, uvs, map.outside_face)),
                    1, map.outside_face});
}

void require_free(std::int64_t face_count, int size) {
  const std::uint64_t bytes = bake_bytes(face_count, size);
  const std::uint64_t free = available_memory_bytes();
  if (bytes <= free) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("a map of {} x {} texels takes {} MB while it is baked, and {} are free; "
                        "take a smaller one",
                        size, size, bytes >> 20, free >> 20));
}

}  // namespace

LevelUvs::LevelUvs(const SurfaceBlocks& surface, std::span<const std::vector<glm::dvec2>> further) {
  const auto count = static_cast<std::size_t>(surface.info().uv_count);
  sets.emplace_back(count);
  surface.uvs({0, surface.info().uv_count}, sets.front());
  for (const std::vector<glm::dvec2>& given : further) {
    sets.emplace_back(count);
    if (!surface.uvs_of(given, sets.back()))
      throw Error(ErrorCode::InvalidArgument,
                  "maps by further sets of texture coordinates are of doo-sabin surfaces alone");
  }
}

TangentSource LevelUvs::tangents(std::span<const int> set_of_group) const {
  TangentSource source{.sets = {}, .set_of_group = {set_of_group.begin(), set_of_group.end()}};
  for (const std::vector<glm::dvec2>& set : sets) source.sets.emplace_back(set);
  return source;
}

int bake_level(const PolygonMesh& mesh, int size) {
  double area = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!has_uvs(mesh, f)) continue;
    double twice = 0;
    const std::int32_t begin = mesh.face_offsets[f], count = mesh.face_size(f);
    for (std::int32_t k = 0; k < count; ++k) {
      const auto uv = [&](std::int32_t corner) {
        return mesh.uvs[static_cast<std::size_t>(
            mesh.face_uvs[static_cast<std::size_t>(begin + corner % count)])];
      };
      twice += uv(k).x * uv(k + 1).y - uv(k).y * uv(k + 1).x;
    }
    area += std::abs(twice) / 2;
  }
  const double texels = area * size * size;
  const auto quads_of = [&](int level) {
    return std::ldexp(static_cast<double>(mesh.face_vertices.size()), 2 * (level - 1));
  };
  int level = kLeastLevel;
  while (level < kMostLevel && quads_of(level) * kTexelsOfFacet * kTexelsOfFacet < texels) ++level;
  while (level > 0 && quads_of(level) > static_cast<double>(kMostBakedFaces)) --level;
  return level;
}

// Two triangles with their vertices in an array that may double as it grows, and where they lie; a
// texel as it is packed, which takes more than what is known of it before.
std::uint64_t bake_bytes(std::int64_t face_count, int size) {
  constexpr std::uint64_t kFaceBytes = 240, kTexelBytes = 16;
  const auto side = static_cast<std::uint64_t>(size);
  return static_cast<std::uint64_t>(face_count) * kFaceBytes + side * side * kTexelBytes;
}

std::vector<int> BakeMapsOptions::sets() const {
  std::vector<int> sets;
  for (const int map : map_of_group)
    sets.push_back(map < 0 ? -1 : maps[static_cast<std::size_t>(map)].set);
  return sets;
}

void settle_maps(const PolygonMesh& mesh, BakeMapsOptions& options) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const int map = options.map_of_group[group_of(mesh, f)];
    if (map >= 0 && !has_uvs(mesh, f)) std::ranges::replace(options.map_of_group, map, -1);
  }
  std::int64_t without = 0;
  std::int32_t first = -1;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (options.map_of_group[group_of(mesh, f)] < 0 && without++ == 0) first = f;
  if (without == mesh.face_count())
    throw Error(
        ErrorCode::UnusableMesh,
        options.name +
            (mesh.uvs.empty()
                 ? ": has no texture coordinates, by which a map is baked"
                 : ": of each material some faces have no texture coordinates, by which a map is "
                   "baked") +
            "; unwrap the mesh, or write it without a map",
        first);
  if (without > 0)
    options.callbacks.warn(
        {"bake-left-out",
         formatted("{}: {} faces are of materials some of whose faces have no texture coordinates "
                   "(first face {}), and get no map; unwrap them, too",
                   options.name, without, first),
         without, first});
}

std::vector<BakedMap> bake_maps(const PolygonMesh& mesh, const SurfaceBlocks& low,
                                const SurfaceTangents& low_tangents, const SurfaceBlocks& fine,
                                std::span<const std::vector<glm::dvec2>> further,
                                const BakeMapsOptions& options) {
  const HostScope host(options.callbacks);
  const std::vector<int> sets = options.sets();
  const LevelUvs low_uvs(low, further), fine_uvs(fine, further);
  std::optional<SurfaceTangents> fine_tangents;
  if (std::ranges::any_of(options.maps, [](const WantedMap& map) { return bool{map.detail}; }))
    fine_tangents = surface_tangents(fine, fine_uvs.tangents(sets));
  require_free(low.info().face_count + fine.info().face_count, options.size);
  const BakeSheet low_sheet = sheet_of(low, low_uvs, sets, &low_tangents);
  const BakeSheet fine_sheet =
      sheet_of(fine, fine_uvs, sets, fine_tangents ? &*fine_tangents : nullptr);
  std::vector<BakedMap> baked;
  std::vector<Warning> left_out;
  for (std::size_t m = 0; m < options.maps.size(); ++m) {
    const WantedMap& wanted = options.maps[m];
    BakedMap& made = baked.emplace_back();
    made.material = wanted.material;
    made.set = wanted.set;
    if (std::ranges::find(options.map_of_group, static_cast<int>(m)) == options.map_of_group.end())
      continue;
    const std::span<const glm::dvec2> uvs =
        wanted.set == 0 ? std::span(mesh.uvs)
                        : std::span(further[static_cast<std::size_t>(wanted.set) - 1]);
    const std::vector<std::int32_t> charts = texture_charts(mesh, uvs, [&](std::int32_t face) {
      return options.map_of_group[group_of(mesh, face)] == static_cast<int>(m);
    });
    // Groups without faces.
    if (std::ranges::all_of(charts, [](std::int32_t chart) { return chart < 0; })) continue;
    Callbacks silent;
    silent.cancelled = options.callbacks.cancelled;
    made.map = bake_normals(low_sheet, fine_sheet,
                            {.size = options.size,
                             .charts = charts,
                             .detail = wanted.detail,
                             .callbacks = std::move(silent)});
    const std::string material =
        wanted.material.empty() ? "" : ": material " + quote(wanted.material);
    const std::string where = options.name + material;
    const std::string useless = why_useless(made.map, mesh, uvs);
    if (useless.empty()) {
      tell_of_map(made.map, mesh, uvs, where, options.callbacks);
      made.png = png_of(options.size, 3, made.map.pixels);
    } else {
      left_out.push_back({"bake-left-out", where + ": " + useless, 1, made.map.repeating_face});
    }
    made.map.pixels = {};
  }
  const bool has_any =
      std::ranges::any_of(baked, [](const BakedMap& map) { return !map.png.empty(); });
  for (const Warning& why : left_out) {
    if (!has_any) throw Error(ErrorCode::UnusableMesh, why.message, why.first);
    options.callbacks.warn(why);
  }
  return baked;
}

namespace {

using nlohmann::json;

// As plain materials of surfaces are.
constexpr double kRoughness = 0.5;

// What a material's normal texture adds; empty where it has none that can be read.
NormalDetail detail_of(const json& lists, const json& material, std::span<const std::byte> bytes,
                       const std::string& where, const Callbacks& callbacks) {
  auto image = read_image(bytes);
  if (!image) {
    callbacks.warn({"bake-unread-texture",
                    where +
                        ": its normal texture is no PNG or JPEG that can be read, and gives way "
                        "to the baked one without it; convert it to PNG first"});
    return {};
  }
  const auto texture = std::make_shared<const NormalTexture>(std::move(*image), lists, material);
  return [texture](const glm::dvec2& uv) { return texture->at(uv); };
}

// Of the mesh's groups; of a mesh without any one of no name.
std::vector<FaceGroup> named_groups(const PolygonMesh& mesh) {
  return mesh.groups.empty() ? std::vector<FaceGroup>(1) : mesh.groups;
}

}  // namespace

BakedSurface::BakedSurface(const FittedMesh& fitted, const SurfaceBlocks& low,
                           const SurfaceBlocks& fine, const GltfMaterials& materials,
                           const BakeFileOptions& options)
    : materials_(materials) {
  const PolygonMesh& mesh = fitted.mesh;
  BakeMapsOptions wanted{.size = options.size,
                         .maps = {},
                         .map_of_group = {},
                         .name = options.name,
                         .callbacks = options.callbacks};
  std::vector<std::string> names;  // of materials, by map
  for (const FaceGroup& group : named_groups(mesh)) {
    const std::string name = valid_utf8(group.material.empty() ? group.name : group.material);
    const auto known = std::ranges::find(names, name);
    wanted.map_of_group.push_back(static_cast<int>(known - names.begin()));
    if (known == names.end()) names.push_back(name);
  }
  settle_maps(mesh, wanted);
  json& lists = materials_.lists;
  std::vector<std::size_t> places;  // of the materials, by map
  for (const std::string& name : names) {
    json& all = lists["materials"];
    if (all.is_null()) all = json::array();
    const auto found =
        std::ranges::find_if(all, [&](const json& material) { return material["name"] == name; });
    const auto place = static_cast<std::size_t>(found - all.begin());
    places.push_back(place);
    WantedMap& map = wanted.maps.emplace_back();
    map.material = name;
    if (found == all.end()) {
      all.push_back(
          {{"name", name},
           {"doubleSided", options.double_sided},
           {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}}}});
      continue;
    }
    const std::int64_t image = normal_image(lists, *found);
    if (image >= 0 && image < std::ssize(materials_.images))
      map.detail =
          detail_of(lists, *found, materials_.images[static_cast<std::size_t>(image)].bytes,
                    options.name + ": material " + quote(name), options.callbacks);
  }
  const std::vector<int> sets = wanted.sets();
  for (const int set : sets) in_groups_.push_back(set >= 0 ? 1 : 0);
  const LevelUvs uvs(low, {});
  tangents_ = surface_tangents(low, uvs.tangents(sets));
  maps_ = bake_maps(mesh, low, tangents_, fine, {}, wanted);
  for (std::size_t m = 0; m < maps_.size(); ++m) {
    if (maps_[m].png.empty()) continue;
    json& images = lists["images"];
    set_normal_texture(lists, lists["materials"][places[m]], std::ssize(images), 0);
    images.push_back({{"mimeType", "image/png"}});
    GltfImage& image = materials_.images.emplace_back(GltfImage{"image/png", {}, {}});
    image.bytes.assign(maps_[m].png.begin(), maps_[m].png.end());
  }
}

void BakedSurface::add_to(GltfOptions& options) const {
  options.attributes.push_back({.name = "TANGENT",
                                .width = 4,
                                .values = tangents_.values,
                                .of_uvs = true,
                                .further = tangents_.further,
                                .further_values = tangents_.further_values,
                                .in_groups = in_groups_});
  options.materials = &materials_;
}

BakedAssetMesh::BakedAssetMesh(const GltfAsset& asset, const AssetMesh& mesh,
                               const FittedMesh& fitted, const SurfaceBlocks& low,
                               const AssetAttributes& attributes, const SurfaceBlocks& fine,
                               const BakeFileOptions& options) {
  const json& root = asset.root().value();
  BakeMapsOptions wanted{.size = options.size,
                         .maps = {},
                         .map_of_group = {},
                         .name = options.name,
                         .callbacks = options.callbacks};
  guard_json(asset.file().name, [&] {
    std::map<std::int64_t, int> map_of_material;
    const json& primitives = root["meshes"][mesh.number]["primitives"];
    const std::vector<std::string> names = material_names(asset.root());
    for (const AssetGroup& group : mesh.vertices.groups) {
      const std::int64_t number = primitives[group.primitive].value("material", std::int64_t{-1});
      const auto [known, is_new] =
          map_of_material.try_emplace(number, static_cast<int>(wanted.maps.size()));
      wanted.map_of_group.push_back(known->second);
      if (!is_new) continue;
      WantedMap& map = wanted.maps.emplace_back();
      map.set = group.tangent_set;
      if (number < 0) continue;
      map.material = names[static_cast<std::size_t>(number)];
      const json& material = root["materials"][number];
      if (const std::int64_t image = normal_image(root, material); image >= 0)
        map.detail =
            detail_of(root, material, asset_image(asset, image).bytes,
                      options.name + ": material " + quote(map.material), options.callbacks);
    }
    for (std::size_t g = 0; g < wanted.map_of_group.size(); ++g)
      if (mesh.vertices.groups[g].tangent_set < 0)
        std::ranges::replace(wanted.map_of_group, int{wanted.map_of_group[g]}, -1);
    return true;
  });
  try {
    settle_maps(fitted.mesh, wanted);
    maps_ =
        bake_maps(fitted.mesh, low, attributes.tangents(), fine, mesh.vertices.further_uvs, wanted);
    map_of_group_ = wanted.map_of_group;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    why_none_ = error.what();
  }
}

void BakedAssetMesh::add_to(AssetSurface& surface) const {
  if (maps_.empty()) return;
  for (const BakedMap& map : maps_) surface.normal_maps.push_back({map.png, map.set});
  surface.map_of_group = map_of_group_;
}

}  // namespace planish
