#include "planish/files/formats.h"

#include <array>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/material_library.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/readers.h"
#include "planish/files/writers.h"

namespace planish {
namespace {

// Text in parts of the usual size.
template <auto read>
auto in_parts(const FileBytes& file) {
  return read(file, kTextPartBytes);
}

// The vertices of what a reader of meshes finds.
template <MeshFile (*read)(const FileBytes&)>
PointCloud vertices_of(const FileBytes& file) {
  MeshFile found = read(file);
  PointCloud cloud = points_of(found, file.name);
  cloud.warnings = std::move(found.warnings);
  return cloud;
}

std::vector<std::filesystem::path> named_by_gltf(const std::filesystem::path& path, FileReach) {
  return gltf_named_files(path);
}

std::vector<std::filesystem::path> named_by_obj(const std::filesystem::path& path,
                                                FileReach reach) {
  return MaterialLibrary(path, reach).named_files();
}

constexpr std::array kFormats{FormatInfo{.format = FileFormat::Glb,
                                         .name = "glb",
                                         .title = "binary glTF 2.0",
                                         .read_mesh = read_gltf,
                                         .read_points = vertices_of<read_gltf>,
                                         .named_files = named_by_gltf,
                                         .is_gltf = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_groups = true,
                                         .keeps_fields = true},
                              FormatInfo{.format = FileFormat::Gltf,
                                         .name = "gltf",
                                         .title = "glTF 2.0",
                                         .read_mesh = read_gltf,
                                         .read_points = vertices_of<read_gltf>,
                                         .named_files = named_by_gltf,
                                         .companion = "bin",
                                         .is_gltf = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_groups = true,
                                         .keeps_fields = true},
                              FormatInfo{.format = FileFormat::Obj,
                                         .name = "obj",
                                         .title = "Wavefront OBJ",
                                         .read_mesh = in_parts<read_obj>,
                                         .read_points = vertices_of<in_parts<read_obj>>,
                                         .named_files = named_by_obj,
                                         .write_polygons = write_obj,
                                         .parts = kObjParts,
                                         .companion = "mtl",
                                         .keeps_doubles = true,
                                         .keeps_sharp_edges = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_groups = true},
                              FormatInfo{.format = FileFormat::Ply,
                                         .name = "ply",
                                         .title = "Stanford PLY",
                                         .read_mesh = in_parts<read_ply>,
                                         .read_points = vertices_of<in_parts<read_ply>>,
                                         .write_polygons = write_ply,
                                         .parts = kPlyParts,
                                         .keeps_doubles = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_fields = true},
                              FormatInfo{.format = FileFormat::Off,
                                         .name = "off",
                                         .title = "Object File Format",
                                         .read_mesh = in_parts<read_off>,
                                         .read_points = vertices_of<in_parts<read_off>>,
                                         .write_polygons = write_off,
                                         .parts = kOffParts,
                                         .keeps_doubles = true},
                              FormatInfo{.format = FileFormat::Stl,
                                         .name = "stl",
                                         .title = "STL",
                                         .read_mesh = in_parts<read_stl>,
                                         .write_polygons = write_stl,
                                         .has_polygons = false},
                              FormatInfo{.format = FileFormat::Xyz,
                                         .name = "xyz",
                                         .title = "points as text",
                                         .read_points = in_parts<read_xyz>},
                              FormatInfo{.format = FileFormat::Pts,
                                         .name = "pts",
                                         .title = "points as text, counted",
                                         .read_points = in_parts<read_pts>},
                              FormatInfo{.format = FileFormat::Pcd,
                                         .name = "pcd",
                                         .title = "Point Cloud Library",
                                         .read_points = in_parts<read_pcd>},
                              FormatInfo{.format = FileFormat::Las,
                                         .name = "las",
                                         .title = "ASPRS LAS 1.0 to 1.4",
                                         .read_points = read_las,
                                         .scan_contents = las_contents},
                              FormatInfo{.format = FileFormat::Ptx,
                                         .name = "ptx",
                                         .title = "scans as text, with their poses",
                                         .read_points = in_parts<read_ptx>,
                                         .scan_contents = ptx_contents},
                              FormatInfo{.format = FileFormat::Usda,
                                         .name = "usda",
                                         .title = "USD as text",
                                         .write_polygons = write_usda,
                                         .keeps_sharp_edges = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_groups = true,
                                         .keeps_fields = true},
                              FormatInfo{.format = FileFormat::Tiles,
                                         .name = "json",
                                         .title = "3D Tiles 1.1",
                                         .is_tiles = true,
                                         .keeps_uvs = true,
                                         .keeps_colors = true,
                                         .keeps_groups = true},
                              FormatInfo{.format = FileFormat::Step,
                                         .name = "step",
                                         .title = "STEP AP214",
                                         .is_brep = true,
                                         .keeps_groups = true,
                                         .other_name = "stp"}};

template <class Wanted>
std::vector<std::string> dotted_names_where(const Wanted& wanted) {
  std::vector<std::string> names;
  for (const FormatInfo& info : kFormats)
    if (wanted(info)) names.push_back("." + std::string(info.name));
  return names;
}
std::vector<std::string> dotted_names(FormatUse use) {
  return dotted_names_where([&](const FormatInfo& info) { return serves(info.format, use); });
}

// "a, b or c"
std::string in_words(const std::vector<std::string>& names, const std::string& last) {
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i)
    text += (i + 1 < names.size() ? ", " : " " + last + " ") + names[i];
  return text;
}

bool holds(const FormatInfo& info, const CarriedAttributes& given) {
  return (info.keeps_uvs || !given.uvs) && (info.keeps_colors || !given.colors) &&
         (info.keeps_groups || !given.groups) && (info.keeps_fields || !given.fields);
}

}  // namespace

std::span<const FormatInfo> formats() { return kFormats; }

const FormatInfo& info_of(FileFormat format) {
  const FormatInfo& info = kFormats.at(static_cast<std::size_t>(format));
  PLANISH_ASSERT(info.format == format);
  return info;
}

std::optional<FileFormat> format_of(const std::filesystem::path& path) {
  const std::string extension = lower_case(utf8(path.extension()));
  if (extension.size() < 2) return std::nullopt;
  const std::string_view named = std::string_view(extension).substr(1);
  for (const FormatInfo& info : kFormats)
    if (named == info.name || named == info.other_name) return info.format;
  return std::nullopt;
}

std::filesystem::path companion_of(const std::filesystem::path& path, FileFormat format) {
  const std::string_view extension = info_of(format).companion;
  if (extension.empty()) return {};
  std::filesystem::path companion = path;
  companion.replace_extension(extension);
  if (format != FileFormat::Obj) return companion;
  // As the OBJ can name it, without the blank in front.
  return companion.replace_filename(path_of(obj_line_name(utf8(companion.filename())).substr(1)));
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
      return info.is_tiles || serves(format, FormatUse::WriteSurfaceFile);
    case FormatUse::WriteSurfaceFile:
      return info.is_gltf || info.is_brep || info.write_polygons;
    case FormatUse::WriteMesh:
      return info.write_polygons && info.has_polygons;
    case FormatUse::WriteCage:
      return info.is_gltf || serves(format, FormatUse::WriteMesh);
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

std::string extensions_in_words(FormatUse use) { return in_words(dotted_names(use), "or"); }

std::string lost_attributes(FileFormat format, const CarriedAttributes& given) {
  const FormatInfo& info = info_of(format);
  if (holds(info, given)) return {};
  std::vector<std::string> lost;
  if (given.uvs && !info.keeps_uvs) lost.emplace_back("texture coordinates");
  if (given.colors && !info.keeps_colors) lost.emplace_back("colours");
  if (given.groups && !info.keeps_groups) lost.emplace_back("groups");
  if (given.fields && !info.keeps_fields) lost.emplace_back("properties of vertices");
  const auto better = dotted_names_where([&](const FormatInfo& other) {
    return serves(other.format, FormatUse::WriteSurface) && holds(other, given);
  });
  return "." + std::string(info.name) + " holds no " + in_words(lost, "or") +
         ", which the input has; " + in_words(better, "and") + " do";
}

}  // namespace planish
