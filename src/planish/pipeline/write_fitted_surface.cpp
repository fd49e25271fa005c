#include "planish/pipeline/write_fitted_surface.h"

#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/visible_text.h"
#include "planish/files/file_materials.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/input_files.h"
#include "planish/files/write_surface.h"
#include "planish/pipeline/attribute_fields.h"
#include "planish/pipeline/fitted_level.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/pipeline/written_distance.h"

namespace planish {
namespace {

FileFormat output_format(const std::filesystem::path& path, FormatUse use) {
  const auto format = format_of(path);
  if (format && serves(*format, use)) return *format;
  if (format && info_of(*format).is_tiles)
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: 3D Tiles are written by the command, planish fit, and by "
                          "write_tiles(); here take {}",
                          visible(path), extensions_in_words(use)));
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: the extension \"{}\" names no format that is written; take {}",
                        visible(path), visible(path.extension()), extensions_in_words(use)));
}

// What a surface file of that format is not made of is refused before work.
void require_writable(const std::filesystem::path& path, FileFormat format, Scheme scheme) {
  if (info_of(format).is_brep) require_step_scheme(scheme, visible(path));
}

StepFigures write_step_of(const std::filesystem::path& path, const FittedMesh& fitted,
                          std::string_view name, const SurfaceFileOptions& options) {
  return write_fitted_step(
      path, fitted,
      {.settings = options.step,
       .name = std::string(name),
       .shown = {},
       .materials = options.materials != nullptr ? &options.materials->gltf : nullptr,
       .observe = {},
       .callbacks = options.callbacks});
}

using FitWarnings = std::function<void(const std::optional<Warning>&)>;

// Callbacks for making a surface and for writing it.
struct SurfaceShares {
  explicit SurfaceShares(const SurfaceFileOptions& whole) : making(whole), writing(whole) {
    // What comes before the surface's rows, which are made as they are written, takes as level 1.
    const double made = 1 / (1 + std::ldexp(1.0, 2 * std::max(whole.level - 1, 0)));
    making.callbacks = share_of(whole.callbacks, 0, made);
    writing.callbacks = share_of(whole.callbacks, made, 1);
  }
  SurfaceFileOptions making, writing;
};

// A fit that misses its tolerance has a warning of its own.
void tell_rounding(const std::filesystem::path& path, const FittedMesh& fitted, double distance,
                   const FitWarnings& tell) {
  if (fitted.fit.interpolation.converged)
    tell(rounding_warning(visible(path), distance / fitted.fit.placement.diagonal,
                          fitted.options.tolerance));
}

std::uint64_t write_level(const std::filesystem::path& path, const FittedMesh& fitted,
                          const SurfaceBlocks& surface, std::string_view name,
                          const SurfaceFileOptions& options, const FitWarnings& tell) {
  const FileFormat format = output_format(path, FormatUse::WriteSurfaceFile);
  std::vector<NamedField> fields;
  std::vector<VertexAttribute> attributes;
  if (info_of(format).keeps_fields) attributes = add_attributes(surface, fields, options.callbacks);
  if (info_of(format).is_gltf) {
    GltfOptions gltf = gltf_options_of(fitted, name, options);
    gltf.fields = fields;
    tell_rounding(path, fitted, written_distance(surface, fitted.points(), gltf), tell);
    return write_gltf(path, surface, gltf).byte_count;
  }
  SurfaceWriteOptions how;
  how.fields = fields;
  how.is_z_up = options.z_up;
  how.callbacks = options.callbacks;
  if (options.materials != nullptr)
    how.materials = {&options.materials->library, path.parent_path(), &options.materials->gltf};
  tell_rounding(path, fitted, written_distance(surface, fitted.points(), format), tell);
  return write_surface(path, format, surface, how);
}

}  // namespace

std::uint64_t write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   std::string_view name, Backend& backend,
                                   const SurfaceFileOptions& options) {
  const FileFormat format = output_format(path, FormatUse::WriteSurfaceFile);
  if (options.inputs != nullptr) require_apart(*options.inputs, path, format);
  require_writable(path, format, fitted.options.scheme);  // before the work
  const HostScope host(options.callbacks);
  const SurfaceShares shares(options);
  std::uint64_t bytes = 0;
  backend.run_on_host([&] {
    if (info_of(format).is_brep) {
      const StepFigures figures = write_step_of(path, fitted, name, options);
      if (options.step_figures != nullptr) *options.step_figures = figures;
      bytes = figures.byte_count;
      return;
    }
    const FittedLevel surface = fitted_level(fitted, backend, shares.making);
    bytes = write_level(path, fitted, *surface.blocks, name, shares.writing,
                        [&](const std::optional<Warning>& warning) {
                          if (warning) options.callbacks.warn(*warning);
                        });
  });
  options.callbacks.report("write", 1);
  return bytes;
}

}  // namespace planish
