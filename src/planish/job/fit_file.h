#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_settings.h"
#include "planish/job/report.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"

namespace planish {

struct FitFileOptions {
  Settings settings{};             ///< all but `device`; see settings_of()
  std::filesystem::path cage{};    ///< also written; empty: none
  std::filesystem::path report{};  ///< JSON, as --report writes; empty: none
  std::filesystem::path page{};    ///< HTML, as --page writes; empty: none
  std::filesystem::path source{};  ///< mesh that the surface is compared with; empty: the input
  WorkLimits limits{};
  Callbacks callbacks{};
  Backend* backend = nullptr;  ///< null: all cores of the CPU, as the command's --device cpu
};

/// What became of a file.
struct FileFit {
  FittedMesh fitted;                              ///< of an asset its first mesh
  std::vector<FittedMesh> further;                ///< of an asset the others
  std::int64_t vertex_count = 0, face_count = 0;  ///< of the first file that is written
  std::uint64_t byte_count = 0;                   ///< of that; a .gltf's .bin included
  std::optional<StepFigures> step;                ///< of a STEP file
};

/// The whole way, as `planish fit INPUT -o OUTPUT` goes it, with the same settings, bytes and
/// warnings: reads a mesh or points, repairs and fits, and writes the surface in the format of the
/// extension: glTF, OBJ, PLY, OFF, STL, USD, 3D Tiles or STEP. Of several levels as files (`lods`)
/// each is NAME_LOD0 and so on. Not converging is a result, and so is a STEP file that does not
/// keep its limits; the file is written and says so. Files that exist are replaced, all together,
/// once the new ones are whole. Throws Error{UnreadableInput}, Error{UnusableMesh} with the remedy,
/// Error{InvalidArgument} for extensions, settings, an output that is the input, a file that this
/// names (see InputFiles) or another output; Error{NoDevice} for points where no mesher is
/// installed; Error{UnwritableOutput}, Error{OutOfMemory}, Error{Cancelled}.
FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options = {});

struct FitFilesOptions {
  Settings settings{};            ///< all but `device`; see settings_of()
  std::string extension = "glb";  ///< of the surfaces
  std::filesystem::path pages{};  ///< folder of a page of each and index.html; empty: none
  bool page_times = true;         ///< whether pages and index.html say how long each took
  WorkLimits limits{};            ///< of each
  Callbacks callbacks{};
  Backend* backend = nullptr;  ///< see FitFileOptions
};

/// fit_file() of many inputs one after another, each into a folder under its name; of what is held
/// only the contact sheet's small pictures grow with their number. index.html is that sheet, the
/// worst first: see page/sheet.h. One that cannot be fitted does not stop the others: what comes
/// back is the message of each input, empty where it is done. Throws Error{InvalidArgument} for
/// two inputs of one name; Error{UnwritableOutput} for the folders and the sheet;
/// Error{Cancelled}.
std::vector<std::string> fit_files(std::span<const std::filesystem::path> inputs,
                                   const std::filesystem::path& folder,
                                   const FitFilesOptions& options = {});

/// How the surface of a fitted mesh becomes a file.
struct SurfaceFileOptions {
  Settings settings{};           ///< those of fineness and of files
  std::string name = "surface";  ///< of mesh and node in a glTF, of the product in STEP
  Callbacks callbacks{};
  /// What was read, of which nothing is written over; null: nothing that is known.
  const InputFiles* inputs = nullptr;
};

/// The last step of fit_file() alone, of a mesh that was fitted in memory: the same files, but for
/// what only an input's file has. Of several levels as files it returns the first. Throws as
/// fit_file().
WrittenOutput write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   Backend& backend, const SurfaceFileOptions& options = {});

}  // namespace planish
