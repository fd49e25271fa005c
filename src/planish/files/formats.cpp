#include "planish/files/formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <vector>

#include "planish/core/assert.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/obj/write_obj.h"
#include "planish/files/off/read_off.h"
#include "planish/files/off/write_off.h"
#include "planish/files/pcd/read_pcd.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/ply/write_ply.h"
#include "planish/files/read_points.h"
#include "planish/files/stl/read_stl.h"
#include "planish/files/stl/write_stl.h"
#include "planish/files/usda/write_usda.h"
#include "planish/files/xyz/read_xyz.h"

namespace planish {
namespace {

// A reader that needs nothing but the bytes.
template <auto read>
auto from_bytes(const FileBytes& file) {
  return read(file.bytes, file.name);
}

// The vertices of what a reader of meshes finds.
template <MeshFile (*read)(const FileBytes&)>
PointCloud vertices_of(const FileBytes& file) {
  MeshFile found = read(file);
  PointCloud cloud = points_of(found, file.name);
  cloud.warnings = std::move(found.warnings);
  return cloud;
}

constexpr std::array kFormats{
    FormatInfo{.format = FileFormat::Glb,
               .name = "glb",
               .title = "binary glTF 2.0",
               .read_mesh = read_gltf,
               .read_points = vertices_of<read_gltf>,
               .is_gltf = true},
    FormatInfo{.format = FileFormat::Gltf,
               .name = "gltf",
               .title = "glTF 2.0",
               .read_mesh = read_gltf,
               .read_points = vertices_of<read_gltf>,
               .companion = "bin",
               .is_gltf = true},
    FormatInfo{.format = FileFormat::Obj,
               .name = "obj",
               .title = "Wavefront OBJ",
               .read_mesh = read_obj,
               .read_points = vertices_of<read_obj>,
               .write_piece = write_obj,
               .polygon_parts = is_obj_part,
               .companion = "mtl",
               .keeps_doubles = true,
               .keeps_sharp_edges = true},
    FormatInfo{.format = FileFormat::Ply,
               .name = "ply",
               .title = "Stanford PLY",
               .read_mesh = read_ply,
               .read_points = vertices_of<read_ply>,
               .write_piece = write_ply,
               .polygon_parts = is_ply_part,
               .keeps_doubles = true},
    FormatInfo{.format = FileFormat::Off,
               .name = "off",
               .title = "Object File Format",
               .read_mesh = from_bytes<read_off>,
               .read_points = vertices_of<from_bytes<read_off>>,
               .write_piece = write_off,
               .polygon_parts = is_off_part,
               .keeps_doubles = true},
    FormatInfo{.format = FileFormat::Stl,
               .name = "stl",
               .title = "STL",
               .read_mesh = from_bytes<read_stl>,
               .write_polygons = write_stl,
               .has_polygons = false},
    FormatInfo{.format = FileFormat::Xyz,
               .name = "xyz",
               .title = "points as text",
               .read_points = from_bytes<read_xyz>},
    FormatInfo{.format = FileFormat::Pts,
               .name = "pts",
               .title = "points as text, counted",
               .read_points = from_bytes<read_pts>},
    FormatInfo{.format = FileFormat::Pcd,
               .name = "pcd",
               .title = "Point Cloud Library",
               .read_points = from_bytes<read_pcd>},
    FormatInfo{.format = FileFormat::Usda,
               .name = "usda",
               .title = "USD as text",
               .write_polygons = write_usda,
               .keeps_sharp_edges = true},
    FormatInfo{
        .format = FileFormat::Tiles, .name = "json", .title = "3D Tiles 1.1", .is_tiles = true}};

std::vector<std::string> dotted_names(FormatUse use) {
  std::vector<std::string> names;
  for (const FormatInfo& info : kFormats)
    if (serves(info.format, use)) names.push_back("." + std::string(info.name));
  return names;
}

}  // namespace

std::span<const FormatInfo> formats() { return kFormats; }

const FormatInfo& info_of(FileFormat format) {
  const FormatInfo& info = kFormats.at(static_cast<std::size_t>(format));
  PLANISH_ASSERT(info.format == format);
  return info;
}

std::optional<FileFormat> format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const FormatInfo& info : kFormats)
    if (extension == "." + std::string(info.name)) return info.format;
  return std::nullopt;
}

std::filesystem::path companion_of(const std::filesystem::path& path, FileFormat format) {
  const std::string_view extension = info_of(format).companion;
  if (extension.empty()) return {};
  std::filesystem::path companion = path;
  return companion.replace_extension(extension);
}

bool serves(FileFormat format, FormatUse use) {
  const FormatInfo& info = info_of(format);
  switch (use) {
    case FormatUse::Read:
      return info.read_mesh || info.read_points;
    case FormatUse::ReadMesh:
      return info.read_mesh;
    case FormatUse::ReadPoints:
      return info.read_points;
    case FormatUse::WriteSurface:
      return info.is_gltf || info.is_tiles || info.write_piece || info.write_polygons;
    case FormatUse::WriteCage:
      return (info.write_piece || info.write_polygons) && info.has_polygons;
  }
  return false;
}

bool holds_points_only(FileFormat format) {
  return serves(format, FormatUse::ReadPoints) && !serves(format, FormatUse::ReadMesh);
}

std::string names_of(FormatUse use, std::string_view separator) {
  std::string text;
  for (const std::string& name : dotted_names(use)) {
    if (!text.empty()) text += separator;
    text += name.substr(1);
  }
  return text;
}

std::string extensions_of(FormatUse use) {
  std::string text;
  for (const std::string& name : dotted_names(use)) text += " " + name;
  return text.substr(1);
}

std::string extensions_in_words(FormatUse use) {
  const std::vector<std::string> names = dotted_names(use);
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i)
    text += (i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

}  // namespace planish
