#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace planish {

class FileBuffer;
struct MeshFile;
struct PointCloud;
struct ScanContents;
enum class PolygonPart : std::uint8_t;
class PolygonStream;
class ReadProgress;

/// A format's place in formats().
enum class FileFormat : std::uint8_t {
  Glb,
  Gltf,
  Obj,
  Ply,
  Off,
  Stl,
  Xyz,
  Pts,
  Pcd,
  Las,
  Ptx,
  Usda,
  Tiles,
  Step
};

/// Where files are read from that an input names: buffers, materials, textures.
enum class FileReach : std::uint8_t {
  Beside,   ///< its folder and what lies below, links resolved
  Anywhere  ///< wherever it says
};

/// A file in memory.
struct FileBytes {
  std::span<const std::byte> bytes;
  std::string_view name;       ///< what messages call it
  std::filesystem::path path;  ///< where it lies, for files that it names; empty: they are not read
  /// Edges where the normals of glTF, OBJ or PLY are split become creases, and vertices at one
  /// place one vertex.
  bool split_normals_crease = false;
  /// Refuses what other programs write and the format does not have, and which is otherwise read
  /// with a warning: it concerns neither positions nor faces.
  bool is_strict = false;
  FileReach reach = FileReach::Beside;  ///< of files that it names
  ReadProgress* progress = nullptr;     ///< counts the bytes that are read; null: nobody asks
};

/// One format of the table. A reader or writer that is missing is null; the readers and the writer
/// throw as read_mesh(), read_points() and write_polygons().
struct FormatInfo {
  FileFormat format;
  std::string_view name;   ///< its extension without the dot, in lower case: "obj"
  std::string_view title;  ///< "Wavefront OBJ"
  MeshFile (*read_mesh)(const FileBytes&) = nullptr;
  PointCloud (*read_points)(const FileBytes&) = nullptr;
  /// Of a format whose files name others: all that the file at a path names, there or not.
  std::vector<std::filesystem::path> (*named_files)(const std::filesystem::path&,
                                                    FileReach) = nullptr;
  /// Of a scanner's format: what it says besides its points.
  ScanContents (*scan_contents)(const FileBytes&) = nullptr;
  void (*write_polygons)(const PolygonStream&) = nullptr;
  /// That write_polygons() writes one after another; empty: it has an order of its own.
  std::span<const PolygonPart> parts = {};
  /// Extension, without the dot, of a file that may be written beside it; empty: none.
  std::string_view companion = {};
  bool is_gltf = false;
  bool is_tiles = false;           ///< a document and a folder, written by write_tiles()
  bool is_brep = false;            ///< B-spline faces, written by write_step()
  bool has_polygons = true;        ///< false: only triangles
  bool keeps_doubles = false;      ///< positions come back to the last bit; else as float32
  bool keeps_sharp_edges = false;  ///< and corners and holes
  bool keeps_uvs = false, keeps_colors = false, keeps_groups = false;
  bool keeps_fields = false;  ///< figures of vertices
  /// Another extension of the same; empty: none.
  std::string_view other_name = {};

  /// Whether each of its files has one level, or triangles as fine as they have to be.
  [[nodiscard]] bool has_fineness() const { return !is_tiles && !is_brep; }
};

/// All formats, each at the place of its FileFormat. Dispatch, help texts and messages are made
/// from this table.
[[nodiscard]] std::span<const FormatInfo> formats();

[[nodiscard]] const FormatInfo& info_of(FileFormat format);
[[nodiscard]] inline std::string_view name_of(FileFormat format) { return info_of(format).name; }

/// By extension, any case; empty for an unknown one.
[[nodiscard]] std::optional<FileFormat> format_of(const std::filesystem::path& path);

/// The file that may be written beside `path`: a .gltf's .bin, an .obj's .mtl. Empty: none.
[[nodiscard]] std::filesystem::path companion_of(const std::filesystem::path& path,
                                                 FileFormat format);

/// What a format may be wanted for. WriteSurfaceFile: without folders of tiles. WriteMesh: polygons
/// as they are. WriteCage: these, and glTF, which has them by an extension (gltf/gltf_cage.h).
enum class FormatUse : std::uint8_t {
  Read,
  ReadMesh,
  ReadPoints,
  WriteSurface,
  WriteSurfaceFile,
  WriteMesh,
  WriteCage
};
[[nodiscard]] bool serves(FileFormat format, FormatUse use);
/// Points only: what a mesh is not read from.
[[nodiscard]] bool holds_points_only(FileFormat format);

/// What a surface has besides its shape.
struct CarriedAttributes {
  bool uvs = false, colors = false, groups = false, fields = false;
};

/// Says which of these the format does not hold, and which formats do; empty: it holds all.
[[nodiscard]] std::string lost_attributes(FileFormat format, const CarriedAttributes& given);

/// The formats of that use: "obj, ply, off".
[[nodiscard]] std::string names_of(FormatUse use, std::string_view separator = ", ");
/// As extensions in a list, for help texts: ".obj .ply .off".
[[nodiscard]] std::string extensions_of(FormatUse use);
/// As extensions in a sentence: ".obj, .ply or .off".
[[nodiscard]] std::string extensions_in_words(FormatUse use);

}  // namespace planish
