#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish {

class InputFiles;  // input_files.h
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
/// bytes. Throws Error{InvalidArgument} for extensions and for an output that `inputs` names;
/// Error{UnwritableOutput}, Error{OutOfMemory}, Error{Cancelled}.
std::uint64_t write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   std::string_view name, Backend& backend,
                                   const SurfaceFileOptions& options);

}  // namespace planish
