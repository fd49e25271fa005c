#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish {

class InputFiles;  // input_files.h

struct FitFileOptions {
  MeshFitOptions mesh;
  /// 0 to kMaxLevel splits; empty: 2, but of each mesh that is dense (MeshDensity) and has no
  /// coarser levels 1.
  std::optional<int> level{};
  /// Levels of detail of the same file, each less than the one before: of a glTF that becomes one.
  /// Nodes name them by MSFT_lod.
  std::vector<int> coarser_levels{};
  std::filesystem::path cage;  ///< also written; empty: none
  bool z_up = false;           ///< turns a Z-up model upright in glTF, and is told to USD
  /// Sharp are also edges where the normals of glTF, OBJ or PLY are split (see FileBytes).
  bool split_normals = false;
  /// A glTF that becomes one, without a cage, keeps nodes, materials, textures, skins, morphs and
  /// animations; each of its meshes is fitted by itself. Else its scene becomes one mesh.
  bool keeps_asset = true;
  FileReach textures = FileReach::Beside;  ///< of files that the input names
  StepSettings step{};
  Backend* backend = nullptr;  ///< null: all cores of the CPU, as the command's --device cpu

  /// `level`, 2 where it is empty, then coarser_levels.
  [[nodiscard]] std::vector<int> levels() const;
  /// That of a mesh in place of `level`.
  [[nodiscard]] int level_of(const MeshDensity& density) const;
};

/// What became of a file.
struct FileFit {
  FittedMesh fitted;                              ///< of an asset its first mesh
  std::vector<FittedMesh> further;                ///< of an asset the others
  std::int64_t vertex_count = 0, face_count = 0;  ///< of all that is written
  std::uint64_t byte_count = 0;                   ///< of its file, a .gltf's .bin included
  std::optional<StepFigures> step;                ///< of a STEP file
};

/// The whole way: reads a mesh (see read_mesh()), repairs and fits it (see fit_mesh()), and writes
/// its surface as glTF, OBJ, PLY, OFF, STL, USD or STEP by the extension of `output`: the same
/// bytes as `planish fit INPUT -o OUTPUT --device cpu` writes. Not converging is a result, and so
/// is a STEP file that does not keep its limits; the file is written and says so. An existing file
/// is replaced, once the new one is whole. Folds of the surface and a large file that nobody asked
/// for are warned of as the command does (see mesh_warnings.h). Throws Error{UnreadableInput},
/// Error{UnusableMesh} with the remedy, Error{InvalidArgument} for extensions, options, an output
/// or a cage that is the input, a file that this names (see InputFiles) or one another, coarser
/// levels of what keeps no asset, and a file of points, which reconstruct() makes a mesh of;
/// Error{UnwritableOutput}, Error{OutOfMemory}, Error{Cancelled}.
FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options = {});

struct FileMaterials;

struct SurfaceFileOptions {
  int level = 2;
  bool z_up = false;
  Callbacks callbacks{};
  const FileMaterials* materials = nullptr;  ///< of the file that was read; null: plain ones
  StepSettings step{};
  StepFigures* step_figures = nullptr;  ///< set where a STEP file is written
  /// What was read, of which nothing is written over; null: nothing that is known.
  const InputFiles* inputs = nullptr;
};

/// Writes the surface of a fitted mesh. `name`: of mesh and node in a glTF. Returns the number of
/// bytes. Throws as fit_file().
std::uint64_t write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   std::string_view name, Backend& backend,
                                   const SurfaceFileOptions& options);

}  // namespace planish
