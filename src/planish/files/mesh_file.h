#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/files/write_polygons.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

class InputFiles;  // input_files.h

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

}  // namespace planish
