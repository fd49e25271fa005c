#pragma once

#include <cstddef>
#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"
#include "planish/files/mesh_file.h"
#include "planish/job/report.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// What the path of an input alone says is wrong with it: no such file, with the nearest name
/// beside it or an explanation of `~` and `file://`; a folder; not readable; an extension of a
/// format that is not read, with the program that converts it. "-" and a path of any other
/// extension pass: content decides. Throws Error{UnreadableInput}; Error{InvalidArgument} for a
/// format.
void require_input(const std::string& path, std::optional<FileFormat> format);

/// What converts a file of that extension ("step", with or without the dot) to one that planish
/// reads; empty where the extension is none that we know of.
[[nodiscard]] std::string conversion_to_readable(const std::filesystem::path& path);

/// The same for a file to write: what makes it of a GLB.
[[nodiscard]] std::string conversion_from_glb(const std::filesystem::path& path);

/// A file in memory, of a format that is settled.
struct InputFile {
  std::string name;            ///< what messages say: the path made visible, or "stdin"
  std::filesystem::path path;  ///< empty: stdin
  RawVector<std::byte> bytes;
  FileFormat format = FileFormat::Obj;
  bool split_normals_crease = false;    ///< as FileBytes has it
  bool is_strict = false;               ///< the same
  FileReach reach = FileReach::Beside;  ///< the same
  /// Once take_digest() is called. Is taken while the bytes are read: last, for its destructor
  /// waits for who still reads them.
  std::shared_future<std::string> digest;

  /// Has the digest taken, where a report wants it.
  void take_digest();
  /// Empty where nobody had it taken.
  [[nodiscard]] std::string sha256() const { return digest.valid() ? digest.get() : std::string(); }
  /// For readers; this must outlive it.
  [[nodiscard]] FileBytes for_reader() const {
    return {.bytes = bytes,
            .name = name,
            .path = path,
            .split_normals_crease = split_normals_crease,
            .is_strict = is_strict,
            .reach = reach};
  }
};

/// A mesh with what a report says of its file.
struct Input {
  std::string name;
  MeshFile file;
  std::string sha256;
};

/// Reads a file, "-" for stdin. Its format is `format` where given, else what the extension names,
/// else what the content looks like. Throws Error{UnreadableInput} where it cannot be read or
/// nothing speaks for a format. The first kFileLoaded of the step "read" is told.
[[nodiscard]] InputFile load_input(const std::string& path, std::optional<FileFormat> format,
                                   const Callbacks& callbacks = {});

/// The mesh in a loaded file; tells the rest of the step. Throws Error{UnreadableInput};
/// Error{InvalidArgument} for a format of points.
[[nodiscard]] Input mesh_of(const InputFile& file, const Callbacks& callbacks = {});

/// load_input() and mesh_of().
[[nodiscard]] Input read_input(const std::string& path, FileReach reach,
                               const Callbacks& callbacks = {});

/// The name of a format that is read, "obj" or "xyz" say. Throws Error{InvalidArgument} naming
/// `where`.
[[nodiscard]] FileFormat parse_input_format(std::string_view value, std::string_view where);

/// A point cloud with what a report says of its file.
struct PointInput {
  std::string name;
  PointCloud cloud;
  std::string sha256;
  FileFormat format = FileFormat::Ply;
};

/// Whether the format, or the extension where none is given, is one that only points have: xyz,
/// pts, pcd, las, ptx.
[[nodiscard]] bool is_point_path(const std::string& path, std::optional<FileFormat> format);

/// Throws what the path alone says is wrong (require_input()), and Error{NoDevice} for points
/// without a mesher; reads nothing.
void require_readable(const std::string& path, std::optional<FileFormat> format);

/// The points in a loaded file. Throws Error{UnreadableInput}; Error{InvalidArgument} for a format
/// that holds no points.
[[nodiscard]] PointInput points_of(const InputFile& file, const Callbacks& callbacks = {});

/// The points of a PLY file that has no faces; empty for a mesh.
[[nodiscard]] std::optional<PointInput> points_of(const Input& input);

/// The mesher that this installation has. Throws Error{NoDevice} where there is none.
[[nodiscard]] Mesher require_mesher();

/// reconstruct() with errors that name the file.
[[nodiscard]] Reconstruction reconstruct_input(const PointInput& input, const Mesher& mesher,
                                               const ReconstructOptions& options);

/// For reports.
[[nodiscard]] PointFacts facts_of(const PointInput& input, const Reconstruction& result);

/// Two aligned lines for people.
[[nodiscard]] std::string points_text(const PointFacts& points);

}  // namespace planish
