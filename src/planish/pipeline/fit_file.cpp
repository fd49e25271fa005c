#include "planish/pipeline/fit_file.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/visible_text.h"
#include "planish/files/file_materials.h"
#include "planish/files/gltf/asset/write_asset.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/write_surface.h"
#include "planish/mesh/statistics.h"
#include "planish/patches/patch_evaluator.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/asset_parts.h"
#include "planish/pipeline/attribute_fields.h"
#include "planish/pipeline/make_ready.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {
namespace {

FileFormat output_format(const std::filesystem::path& path, FormatUse use) {
  const auto format = format_of(path);
  if (format && serves(*format, use)) return *format;
  throw Error(ErrorCode::InvalidArgument,
              visible(path) + ": the extension \"" + visible(path.extension()) +
                  "\" names no format that is written; take " + extensions_in_words(use));
}

// Where a path leads, by whatever links.
std::filesystem::path place_of(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path place = std::filesystem::weakly_canonical(path, error);
  return error ? path : place;
}

void require_other_file(const std::filesystem::path& input, const std::filesystem::path& output) {
  std::error_code error;
  if (!std::filesystem::equivalent(input, output, error)) return;
  throw Error(ErrorCode::InvalidArgument,
              visible(output) + ": is the input itself; name another output");
}

MeshFile read_faces(const std::filesystem::path& input, bool split_normals, bool is_strict,
                    const Callbacks& callbacks) {
  MeshFile file = read_mesh(
      input,
      {.split_normals_crease = split_normals, .is_strict = is_strict, .callbacks = callbacks});
  if (file.mesh.face_count() == 0 && file.mesh.vertex_count() > 0) {
    throw Error(
        ErrorCode::UnusableMesh,
        visible(input) + ": holds points without faces; reconstruct() makes a mesh of them");
  }
  if (split_normals && file.mesh.creases.empty()) {
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

// The surface, which is made as it is read; what it is made of stands beside it.
struct SurfaceLevel {
  std::unique_ptr<const DooSabinSurface> doo_sabin;
  std::unique_ptr<const SurfaceMesh> whole;
  std::unique_ptr<SurfaceBlocks> blocks;
};

SurfaceLevel surface_level(const FittedMesh& fitted, Backend& backend,
                           const SurfaceFileOptions& options) {
  EvaluateOptions how = fitted.evaluate_options(options.level);
  how.callbacks = options.callbacks;
  require_level(options.level);
  SurfaceLevel made;
  if (fitted.options.scheme != Scheme::DooSabin) {
    made.whole =
        std::make_unique<const SurfaceMesh>(evaluate(fitted.mesh, fitted.fit, backend, how));
    made.blocks = blocks_of(*made.whole, fitted.mesh);
    return made;
  }
  options.callbacks.report("evaluate", 0);
  made.doo_sabin = fitted_surface(fitted.mesh, fitted.fit, how);
  made.blocks = made.doo_sabin->level(options.level, 0, dynamic_cast<PatchEvaluator*>(&backend));
  return made;
}

GltfOptions gltf_options(const FittedMesh& fitted, std::string_view name,
                         const SurfaceFileOptions& options) {
  GltfOptions gltf;
  gltf.name = std::string(name);
  gltf.double_sided = statistics(*fitted.fit.prepared).boundary_loop_count > 0;
  gltf.z_up = options.z_up;
  gltf.origin = storage_origin(fitted.fit.placement);
  gltf.extras = fit_extras(fitted.options, fitted.creases(), fitted.fit.interpolation);
  gltf.extras.emplace_back("level", std::int64_t{options.level});
  if (options.materials != nullptr) gltf.materials = &options.materials->gltf;
  gltf.callbacks = options.callbacks;
  return gltf;
}

std::uint64_t write_level(const std::filesystem::path& path, const FittedMesh& fitted,
                          const SurfaceBlocks& surface, std::string_view name,
                          const SurfaceFileOptions& options) {
  const FileFormat format = output_format(path, FormatUse::WriteSurface);
  std::vector<NamedField> fields;
  std::vector<VertexAttribute> attributes;
  if (info_of(format).keeps_fields) attributes = add_attributes(surface, fields, options.callbacks);
  if (info_of(format).is_gltf) {
    GltfOptions gltf = gltf_options(fitted, name, options);
    gltf.fields = fields;
    return write_gltf(path, surface, gltf).byte_count;
  }
  SurfaceWriteOptions how;
  how.fields = fields;
  how.callbacks = options.callbacks;
  if (options.materials != nullptr)
    how.materials = {&options.materials->library, path.parent_path(), &options.materials->gltf};
  return write_surface(path, format, surface, how);
}

bool keeps_asset(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  const auto from = format_of(input), to = format_of(output);
  return options.keeps_asset && options.cage.empty() && from && info_of(*from).is_gltf && to &&
         info_of(*to).is_gltf && !info_of(*to).is_tiles;
}

// A mesh of an asset on its way to its surface.
struct AssetPart {
  AssetMesh mesh;
  ReadyFit ready;
  FittedMesh fitted;
  SurfaceLevel level;
  std::unique_ptr<const AssetAttributes> attributes;
};

// Of the time of an asset, when its meshes are ready, and when they are fitted.
constexpr double kMeshesReady = 0.2;

std::list<AssetPart> fitted_parts(const GltfAsset& asset, const MeshFitOptions& how,
                                  Backend& backend, const FitFileOptions& options) {
  const std::string file(asset.file().name);
  const Callbacks& whole = how.fit.callbacks;
  const auto share = [&](MeshShare mesh, double from, double to) {
    return share_of(whole, std::lerp(from, to, mesh.begin), std::lerp(from, to, mesh.end));
  };
  MeshSteps<AssetPart> steps;
  steps.warn = [&](const Warning& warning) { whole.warn(warning); };
  steps.prepare = [&](AssetPart& part, std::int64_t number, MeshShare of) {
    part.mesh = asset.read(number);
    for (const Warning& warning : part.mesh.file.warnings) whole.warn(warning);
    MeshFitOptions one = how;
    one.fit.callbacks = share(of, 0, kMeshesReady);
    part.ready =
        prepare_fit(std::move(part.mesh.file.mesh),
                    asset.surfaces().size() == 1 ? file : file + ": " + part.mesh.name, one);
  };
  steps.fit = [&](AssetPart& part, MeshShare of) {
    // Most of it the fit; the rest what rides on the surface.
    const Callbacks one = share(of, kMeshesReady, 1);
    constexpr double kFitted = 0.8;
    part.ready.options.fit.callbacks = share_of(one, 0, kFitted);
    part.fitted = fit_prepared(std::move(part.ready), backend);
    part.fitted.split_normals = options.split_normals;
    part.level = surface_level(part.fitted, backend, {options.level, options.z_up, {}});
    part.attributes = std::make_unique<const AssetAttributes>(
        part.mesh, part.fitted, *part.level.blocks, backend, share_of(one, kFitted, 1));
  };
  return fit_meshes(asset, steps);
}

FileFit fitted_asset(const GltfAsset& asset, const std::filesystem::path& output,
                     const MeshFitOptions& how, Backend& backend, const FitFileOptions& options) {
  const Callbacks& whole = how.fit.callbacks;
  const double fitted_share = 1 / (1 + 0.1 * std::ldexp(1.0, 2 * options.level));
  MeshFitOptions fitting = how;
  fitting.fit.callbacks = share_of(whole, 0, fitted_share);
  std::list<AssetPart> parts = fitted_parts(asset, fitting, backend, options);
  std::vector<AssetSurface> surfaces;
  FileFit result;
  for (const AssetPart& part : parts) {
    GltfOptions gltf = gltf_options(part.fitted, part.mesh.name, {options.level, false, {}});
    part.attributes->add_to(gltf);
    surfaces.push_back({.mesh = part.mesh.number,
                        .surface = part.level.blocks.get(),
                        .vertices = &part.mesh.vertices,
                        .options = std::move(gltf)});
    result.vertex_count += part.level.blocks->info().row_count;
    result.face_count += part.level.blocks->info().face_count;
  }
  GltfOptions common;
  common.callbacks = share_of(whole, fitted_share, 1);
  result.byte_count = write_asset(output, output.parent_path(), asset, surfaces, common).byte_count;
  result.fitted = std::move(parts.front().fitted);
  for (auto part = std::next(parts.begin()); part != parts.end(); ++part)
    result.further.push_back(std::move(part->fitted));
  return result;
}

void write_cage_of(const FittedMesh& fitted, std::optional<FileFormat> format,
                   const FitFileOptions& options, const FileMaterials& materials) {
  if (!format) return;
  write_mesh(options.cage, *format, control_cage(fitted.mesh, fitted.fit, fitted.options.sharp),
             {.header = {},
              .subdivision = {},
              .is_z_up = false,
              .materials = {&materials.library, options.cage.parent_path()}});
}

FileMaterials read_materials_of(const std::filesystem::path& input, FileFormat from, bool to_obj,
                                bool to_gltf) {
  RawVector<std::byte> bytes;
  if (info_of(from).is_gltf && to_gltf) bytes = read_file(input, {});
  const std::string name = visible(input);
  return read_materials({.bytes = bytes, .name = name, .path = input}, from, to_obj, to_gltf);
}

// `how` with the method as it is settled.
FileFit fitted_file(const std::filesystem::path& input, const std::filesystem::path& output,
                    MeshFitOptions how, std::optional<FileFormat> cage_format, Backend& backend,
                    const FitFileOptions& options) {
  const Callbacks callbacks = how.fit.callbacks;
  // Of the time when the file is read, and when the mesh is fitted: a level takes as its faces do.
  const double surface = 0.1 * std::ldexp(1.0, 2 * options.level);
  const double read = 0.2 / (1 + surface), fit = 1 / (1 + surface);
  how.fit.callbacks = share_of(callbacks, read, fit);
  if (keeps_asset(input, output, options)) {
    const RawVector<std::byte> bytes = read_file(input, share_of(callbacks, 0, read));
    const std::string name = visible(input);
    const auto asset = asset_of({.bytes = bytes,
                                 .name = name,
                                 .path = input,
                                 .split_normals_crease = options.split_normals,
                                 .is_strict = !options.mesh.repairs},
                                *format_of(input));
    if (asset) {
      how.fit.callbacks = callbacks;
      return fitted_asset(*asset, output, how, backend, options);
    }
  }
  MeshFile file =
      read_faces(input, options.split_normals, !options.mesh.repairs, share_of(callbacks, 0, read));
  for (const Warning& warning : file.warnings) callbacks.warn(warning);
  FileFit result;
  result.fitted = fit_mesh(std::move(file.mesh), visible(input), backend, how);
  result.fitted.split_normals = options.split_normals;
  auto& warnings = result.fitted.warnings;
  warnings.insert(warnings.begin(), file.warnings.begin(), file.warnings.end());

  const FormatInfo& to = info_of(output_format(output, FormatUse::WriteSurface));
  const bool to_gltf = to.is_gltf || to.is_brep || to.format == FileFormat::Usda;
  const FileMaterials materials = read_materials_of(
      input, file.format, to.format == FileFormat::Obj || cage_format == FileFormat::Obj, to_gltf);
  for (const Warning& warning : materials.warnings()) callbacks.warn(warning);
  if (to.is_brep) {
    SurfaceFileOptions step{options.level, options.z_up, share_of(callbacks, fit, 1), &materials};
    step.step = options.step;
    result.step = write_step_of(output, result.fitted, visible(input.stem()), step);
    result.vertex_count = result.step->vertices;
    result.face_count = result.step->faces;
    result.byte_count = result.step->byte_count;
    write_cage_of(result.fitted, cage_format, options, materials);
    return result;
  }
  const SurfaceShares shares(
      {options.level, options.z_up, share_of(callbacks, fit, 1), &materials});
  const SurfaceLevel made = surface_level(result.fitted, backend, shares.making);
  result.vertex_count = made.blocks->info().row_count;
  result.face_count = made.blocks->info().face_count;
  result.byte_count =
      write_level(output, result.fitted, *made.blocks, visible(input.stem()), shares.writing);
  write_cage_of(result.fitted, cage_format, options, materials);
  return result;
}

}  // namespace

std::uint64_t write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   std::string_view name, Backend& backend,
                                   const SurfaceFileOptions& options) {
  const FileFormat format = output_format(path, FormatUse::WriteSurface);
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
    const SurfaceLevel surface = surface_level(fitted, backend, shares.making);
    bytes = write_level(path, fitted, *surface.blocks, name, shares.writing);
  });
  options.callbacks.report("write", 1);
  return bytes;
}

FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  const FileFormat format = output_format(output, FormatUse::WriteSurface);
  require_level(options.level);
  require_other_file(input, output);
  MeshFitOptions how = options.mesh;
  require_writable(output, format, how.fit.scheme);
  std::optional<FileFormat> cage_format;
  if (!options.cage.empty()) {
    cage_format = output_format(options.cage, FormatUse::WriteCage);
    require_other_file(input, options.cage);
    if (place_of(output) == place_of(options.cage))
      throw Error(ErrorCode::InvalidArgument,
                  visible(options.cage) + ": surface and cage cannot be one file; name another");
    // Of both methods, the one whose cage keeps the mesh's faces.
    if (!how.method) how.method = InterpolationMethod::Progressive;
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
