#include "planish/pipeline/fit_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/visible_text.h"
#include "planish/files/file_materials.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/input_files.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/write_surface.h"
#include "planish/pipeline/asset_parts.h"
#include "planish/pipeline/attribute_fields.h"
#include "planish/pipeline/choose_fit.h"
#include "planish/pipeline/fit_asset.h"
#include "planish/pipeline/fitted_level.h"
#include "planish/pipeline/make_ready.h"
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

// Where a path leads, by whatever links.
std::filesystem::path place_of(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path place = std::filesystem::weakly_canonical(path, error);
  return error ? path : place;
}

MeshFile read_faces(const std::filesystem::path& input, const FitFileOptions& options,
                    const Callbacks& callbacks) {
  MeshFile file = read_mesh(input, {.split_normals_crease = options.split_normals,
                                    .is_strict = !options.mesh.repairs,
                                    .reach = options.textures,
                                    .callbacks = callbacks});
  if (file.mesh.face_count() == 0 && file.mesh.vertex_count() > 0) {
    throw Error(
        ErrorCode::UnusableMesh,
        visible(input) + ": holds points without faces; reconstruct() makes a mesh of them");
  }
  if (options.split_normals && file.mesh.creases.empty()) {
    file.warnings.push_back(
        {"no-split-normals", visible(input) + ": no edge where normals are split was found"});
  }
  return file;
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

// The mesh is fitted, and what a control cage is of, where that is another fit.
struct WithCage {
  FittedMesh fitted;
  std::optional<FittedMesh> cage;
};

WithCage fit_with_cage(PolygonMesh mesh, std::string_view name, Backend& backend,
                       const MeshFitOptions& how, bool has_cage) {
  constexpr double kReady = 0.15, kFitted = 0.8;  // of the time
  if (!has_cage) return {fit_mesh(std::move(mesh), name, backend, how), {}};
  const Callbacks& callbacks = how.fit.callbacks;
  MeshFitOptions preparing = how;
  preparing.fit.callbacks = share_of(callbacks, 0, kReady);
  ReadyFit ready = prepare_fit(std::move(mesh), name, preparing);
  std::optional<ReadyFit> of_cage;
  if (is_open(ready)) of_cage = cage_fit(ready);
  ready.options.fit.callbacks = share_of(callbacks, kReady, kFitted);
  WithCage made{fit_prepared(std::move(ready), backend), {}};
  if (!of_cage || has_own_cage(made.fitted)) return made;
  of_cage->options.fit.callbacks = share_of(callbacks, kFitted, 1);
  made.cage = fit_prepared(*std::move(of_cage), backend);
  return made;
}

void write_cage_of(const FittedMesh& fitted, std::optional<FileFormat> format,
                   const FitFileOptions& options, const FileMaterials& materials) {
  if (!format) return;
  write_mesh(options.cage, *format, control_cage(fitted.mesh, fitted.fit, fitted.options.sharp),
             {.header = {},
              .subdivision = {},
              .is_z_up = options.z_up,
              .materials = {&materials.library, options.cage.parent_path()}});
}

FileMaterials read_materials_of(const std::filesystem::path& input, FileFormat from,
                                FileReach reach, bool to_obj, bool to_gltf) {
  RawVector<std::byte> bytes;
  if (info_of(from).is_gltf && (to_gltf || to_obj)) bytes = read_file(input, {});
  const std::string name = visible(input);
  return read_materials({.bytes = bytes, .name = name, .path = input, .reach = reach}, from, to_obj,
                        to_gltf);
}

// A glTF that becomes one.
bool wants_asset(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  const auto from = format_of(input), to = format_of(output);
  return options.keeps_asset && from && info_of(*from).is_gltf && to && info_of(*to).is_gltf;
}

Warning merged_asset(const std::filesystem::path& input, const std::filesystem::path& cage) {
  return {"merged-asset",
          formatted("{}: the scene becomes one mesh without nodes, skins and animations, since {} "
                    "holds one mesh; write the glTF by itself to keep them",
                    visible(input), visible(cage))};
}

// Levels of detail go from fine to coarse.
void require_falling(const FitFileOptions& options) {
  int finer = options.levels().front();
  for (const int level : options.coarser_levels) {
    if (level >= finer)
      throw Error(
          ErrorCode::InvalidArgument,
          formatted(
              "coarser_levels: {} follows level {}; name levels from fine to coarse, each once",
              level, finer));
    finer = level;
  }
}

// `how` with the method as it is settled.
FileFit fitted_file(const std::filesystem::path& input, const std::filesystem::path& output,
                    MeshFitOptions how, std::optional<FileFormat> cage_format, Backend& backend,
                    const FitFileOptions& options) {
  const Callbacks callbacks = how.fit.callbacks;
  // Of the time when the file is read, and when the mesh is fitted.
  const double fit = share_before_rows(options.levels()), read = 0.2 * fit;
  const bool is_asset = wants_asset(input, output, options);
  if (is_asset && options.cage.empty()) {
    const RawVector<std::byte> bytes = read_file(input, share_of(callbacks, 0, read));
    const std::string name = visible(input);
    const auto asset = asset_of({.bytes = bytes,
                                 .name = name,
                                 .path = input,
                                 .split_normals_crease = options.split_normals,
                                 .is_strict = !options.mesh.repairs,
                                 .reach = options.textures},
                                *format_of(input));
    if (asset) return fit_asset(*asset, output, how, backend, options);
  }
  if (!options.coarser_levels.empty())
    refuse_levels_of_detail(visible(output), "; take a file for each level");
  how.fit.callbacks = share_of(callbacks, read, fit);
  MeshFile file = read_faces(input, options, share_of(callbacks, 0, read));
  if (is_asset && !options.cage.empty()) file.warnings.push_back(merged_asset(input, options.cage));
  for (const Warning& warning : file.warnings) callbacks.warn(warning);
  FileFit result;
  WithCage made =
      fit_with_cage(std::move(file.mesh), visible(input), backend, how, cage_format.has_value());
  result.fitted = std::move(made.fitted);
  result.fitted.split_normals = options.split_normals;
  auto& warnings = result.fitted.warnings;
  warnings.insert(warnings.begin(), file.warnings.begin(), file.warnings.end());

  const FormatInfo& to = info_of(output_format(output, FormatUse::WriteSurfaceFile));
  const bool to_gltf = to.is_gltf || to.is_brep || to.format == FileFormat::Usda;
  const FileMaterials materials =
      read_materials_of(input, file.format, options.textures,
                        to.format == FileFormat::Obj || cage_format == FileFormat::Obj, to_gltf);
  for (const Warning& warning : materials.warnings()) callbacks.warn(warning);
  const auto tell = [&](const std::optional<Warning>& warning) {
    if (!warning) return;
    warnings.push_back(*warning);
    callbacks.warn(*warning);
  };
  if (to.is_brep) {
    SurfaceFileOptions step{
        .z_up = options.z_up, .callbacks = share_of(callbacks, fit, 1), .materials = &materials};
    step.step = options.step;
    step.step.unit = settled_unit(options.step.unit, name_of(file.format));
    result.step = write_step_of(output, result.fitted, visible(input.stem()), step);
    tell_rounding(output, result.fitted, result.step->largest_distance, tell);
    result.vertex_count = result.step->vertices;
    result.face_count = result.step->faces;
    result.byte_count = result.step->byte_count;
    write_cage_of(made.cage ? *made.cage : result.fitted, cage_format, options, materials);
    return result;
  }
  const SurfaceShares shares({options.level_of(result.fitted.density), options.z_up,
                              share_of(callbacks, fit, 1), &materials});
  const FittedLevel surface = fitted_level(result.fitted, backend, shares.making);
  tell(fold_warning(result.fitted, surface, shares.making.level,
                    {.cancelled = callbacks.cancelled}));
  result.vertex_count = surface.blocks->info().row_count;
  result.face_count = surface.blocks->info().face_count;
  result.byte_count = write_level(output, result.fitted, *surface.blocks, visible(input.stem()),
                                  shares.writing, tell);
  // A .gltf's numbers are beside it.
  if (!options.level && file.format != FileFormat::Gltf)
    tell(size_warning(visible(output), result.byte_count, std::filesystem::file_size(input),
                      shares.making.level));
  write_cage_of(made.cage ? *made.cage : result.fitted, cage_format, options, materials);
  return result;
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

std::vector<int> FitFileOptions::levels() const {
  std::vector<int> all{level.value_or(MeshDensity{}.level())};
  all.insert(all.end(), coarser_levels.begin(), coarser_levels.end());
  return all;
}

int FitFileOptions::level_of(const MeshDensity& density) const {
  return level || !coarser_levels.empty() ? levels().front() : density.level();
}

FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  const FileFormat format = output_format(output, FormatUse::WriteSurfaceFile);
  for (const int level : options.levels()) require_level(level);
  require_falling(options);
  InputFiles inputs;
  inputs.add(input, {}, options.textures);
  require_apart(inputs, output, format);
  MeshFitOptions how = options.mesh;
  require_writable(output, format, how.fit.scheme);
  std::optional<FileFormat> cage_format;
  if (!options.cage.empty()) {
    cage_format = output_format(options.cage, FormatUse::WriteCage);
    require_apart(inputs, options.cage, *cage_format);
    if (place_of(output) == place_of(options.cage))
      throw Error(ErrorCode::InvalidArgument,
                  visible(options.cage) + ": surface and cage cannot be one file; name another");
  }
  if (options.split_normals) how.chooses_creases = false;
  std::unique_ptr<Backend> own;
  if (options.backend == nullptr)
    own = make_cpu_backend({.solve_precision = precision_for(how.fit.tolerance)});
  Backend& backend = own ? *own : *options.backend;

  const Callbacks callbacks = how.fit.callbacks;
  const HostScope host(callbacks);
  FileFit result;
  backend.run_on_host(
      [&] { result = fitted_file(input, output, how, cage_format, backend, options); });
  callbacks.report("write", 1);
  return result;
}

}  // namespace planish
