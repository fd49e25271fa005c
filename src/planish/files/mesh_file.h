#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/files/write_polygons.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What a piece of work reads: its inputs, and the files that these name (buffers, images,
/// materials, textures). No output may take the place of one of them, by whatever name: files are
/// told apart by the system's numbers for them, behind links.
class InputFiles {
 public:
  /// An input, there or not yet. `format`: empty: by the extension, or else the content. `reach`:
  /// of what it names.
  void add(const std::filesystem::path& input, std::optional<FileFormat> format = {},
           FileReach reach = FileReach::Beside);

  /// Why nothing may be written to `output`: "b.bin is read with the input a.gltf; ..."; empty: it
  /// may. Costs next to nothing where no file is there.
  [[nodiscard]] std::string objection(const std::filesystem::path& output) const;
  /// The same of all files that an output of a format writes or removes: its own, those beside it
  /// (.bin, .mtl), the folder of its tiles.
  [[nodiscard]] std::string objection(const std::filesystem::path& output, FileFormat format) const;
  /// The same of a folder that gives way with all that is in it.
  [[nodiscard]] std::string objection_in(const std::filesystem::path& folder) const;

 private:
  using Identity = std::pair<std::uint64_t, std::uint64_t>;  // device and file
  struct Input {
    std::filesystem::path path;
    std::optional<FileFormat> format;
    FileReach reach;
  };
  void look_into_inputs() const;
  // Of a file that is there.
  [[nodiscard]] std::string objection_there(const std::filesystem::path& output) const;

  std::vector<Input> inputs_;
  std::map<std::filesystem::path, std::filesystem::path> places_;  // of inputs, links resolved
  // Which input reads a file. Inputs are looked into when it is first asked what they name.
  mutable std::map<Identity, std::filesystem::path> readers_;
  mutable std::size_t looked_into_ = 0;
};

/// Throws Error{InvalidArgument} where there is an objection to an output of that format.
void require_apart(const InputFiles& inputs, const std::filesystem::path& output,
                   FileFormat format);
/// The same for one input that was read.
void require_apart(const std::filesystem::path& input, const std::filesystem::path& output,
                   FileFormat format);

/// A mesh as read, with what the reader had to do.
struct MeshFile {
  PolygonMesh mesh;
  FileFormat format = FileFormat::Obj;     ///< of glTF: by content
  std::int64_t welded_vertex_count = 0;    ///< vertices merged with one at the same position
  std::int64_t dropped_element_count = 0;  ///< lines, points and the like that carry no surface
  std::vector<Warning> warnings;
  /// No joint, morph target or further texture coordinate of an asset is kept by its vertices and
  /// coordinates.
  bool stands_alone = true;
  /// Points without coordinates, as PointCloud has it, of files without faces; they are left out.
  std::int64_t missing_count = 0;
  std::vector<glm::vec3> normals;   ///< one per vertex, of files without faces that have them
  std::vector<std::string> header;  ///< `# planish key=value` comment lines of a cage
};

/// Reads a mesh from memory; `name` stands in messages, and files that a glTF names are refused.
/// n-gons are kept; glTF is welded by exact position, STL within rounding. Indices
/// are in range and positions finite in what is returned; the other conditions of check() are not
/// tested here. Throws Error{UnreadableInput}: `name:line: what, value`; Error{InvalidArgument} for
/// a format of points.
[[nodiscard]] MeshFile read_mesh(std::span<const std::byte> bytes, std::string_view name,
                                 FileFormat format);

/// The same, with what a glTF names where `file` has a path, as its reach allows. Progress is the
/// share of bytes that are read, as the step "read"; warnings stand in the result.
[[nodiscard]] MeshFile read_mesh(const FileBytes& file, FileFormat format,
                                 const Callbacks& callbacks = {});

struct MeshReadOptions {
  std::optional<FileFormat> format;     ///< empty: by the extension
  bool split_normals_crease = false;    ///< as FileBytes has it
  bool is_strict = false;               ///< the same
  FileReach reach = FileReach::Beside;  ///< the same
  Callbacks callbacks = {};             ///< as above
};

/// Reads a file, and what a glTF names. Throws as above, and Error{InvalidArgument} for
/// an extension that is not read.
[[nodiscard]] MeshFile read_mesh(const std::filesystem::path& path,
                                 const MeshReadOptions& options = {});

struct MeshWriteOptions {
  std::vector<std::string> header;   ///< comment lines, without the comment sign
  CageSubdivision subdivision = {};  ///< for USD
  bool is_z_up = false;              ///< for USD
  GivenMaterials materials;          ///< for OBJ
  /// What was read, of which nothing is written over; null: nothing that is known.
  const InputFiles* inputs = nullptr;
};

/// Writes OBJ, PLY (binary little endian, double), OFF or USD text through OutputFile; n-gons are
/// kept. OBJ holds all that a mesh has but attributes, so that reading it gives the same mesh; PLY
/// holds colours (8 bits) and attributes, OFF positions and faces only. Text numbers are shortest
/// round-trip doubles. Throws Error{UnwritableOutput}, Error{InvalidArgument} for other formats.
void write_mesh(const std::filesystem::path& path, FileFormat format, const PolygonMesh& mesh,
                const MeshWriteOptions& options = {});

/// Reads points from memory; `name` stands in messages. Positions are finite and at most
/// kMaxCoordinate in what is returned; colours and normals come along from glTF, OBJ, PLY, PCD, XYZ
/// and PTS, colours and intensity from LAS and PTX, further numbers of points from PLY, PCD, XYZ
/// and PTS. Of formats that hold meshes too, these are the vertices, of glTF those of its
/// primitives of points where it has no triangles. Throws Error{UnreadableInput}: `name:line: what,
/// value` or `name: point 12 of 345: ...`; Error{InvalidArgument} for a format without points.
[[nodiscard]] PointCloud read_points(std::span<const std::byte> bytes, std::string_view name,
                                     FileFormat format);

/// The same, with what a glTF names beside it where `file` has a path. Progress is the share of
/// bytes that are read, as the step "read"; warnings stand in the result.
[[nodiscard]] PointCloud read_points(const FileBytes& file, FileFormat format,
                                     const Callbacks& callbacks = {});

/// The vertices of a file, with its colours and attributes, and its normals where it has no faces.
/// Throws Error{UnreadableInput} as cloud_of().
[[nodiscard]] PointCloud points_of(const MeshFile& file, std::string_view name);

/// Reads a file by its extension. Throws as above.
[[nodiscard]] PointCloud read_points(const std::filesystem::path& path,
                                     const Callbacks& callbacks = {});

}  // namespace planish
