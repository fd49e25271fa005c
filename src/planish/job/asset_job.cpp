#include "planish/core/callbacks.h"
#include "planish/core/words.h"
#include "planish/job/job_outputs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <list>
#include <numeric>
#include <set>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/job/digest.h"
#include "planish/job/forecast.h"
#include "planish/job/job_input.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/asset_attributes.h"

namespace planish {
namespace {

// What of the work on an asset one of its meshes is: from `begin` to `end`, of 0 to 1.
struct MeshShare {
  double begin = 0, end = 1;
};

// By the corners that the file says they have. In order.
std::vector<MeshShare> mesh_shares(const GltfAsset& asset) {
  std::vector<double> corners;
  double all = 0;
  for (const std::int64_t number : asset.surfaces()) {
    corners.push_back(static_cast<double>(std::max<std::int64_t>(asset.corner_count(number), 1)));
    all += corners.back();
  }
  std::vector<MeshShare> shares;
  double done = 0;
  for (const double count : corners) {
    shares.push_back({done / all, (done + count) / all});
    done += count;
  }
  if (!shares.empty()) shares.back().end = 1;
  return shares;
}

// A mesh of the asset on its way.
struct AssetPart {
  std::int64_t number = 0;  // in the file
  MeshShare share;
  double triangle_share = 1;  // of all meshes' triangles
  bool has_own_level = false;
  AssetMesh mesh;
  std::vector<PlannedOutput> outputs;  // as this mesh has them
  JobInput made;
  ReadyFit ready;
  JobReport report;
  std::unique_ptr<JobSurface> surface;
};

MeshFineness fineness_of(const AssetPart& part) {
  const int own = part.has_own_level ? part.report.settings.levels.front() : 0;
  return {part.has_own_level ? own : part.made.fitted.density.level(), part.triangle_share,
          part.has_own_level};
}

const std::vector<AssetName>& names_of(const AssetNames& all, PartKind kind) {
  return kind == PartKind::Mesh       ? all.meshes
         : kind == PartKind::Material ? all.materials
                                      : all.nodes;
}

// Those that hold for a mesh, in order.
std::vector<PartSetting> settings_of_mesh(const std::vector<PartSetting>& settings,
                                          const AssetNames& names, std::int64_t mesh) {
  std::vector<PartSetting> own;
  for (const PartSetting& one : settings)
    if (std::ranges::any_of(names_of(names, one.kind), [&](const AssetName& name) {
          return one.names(name.name) && std::ranges::count(name.meshes, mesh) > 0;
        }))
      own.push_back(one);
  return own;
}

// Of those of a material, that the mesh has others beside it.
void warn_of_whole_mesh(const AssetJob& work, const AssetNames& names, AssetPart& part) {
  const auto materials = std::ranges::count_if(names.materials, [&](const AssetName& name) {
    return std::ranges::count(name.meshes, part.number) > 0;
  });
  if (materials < 2) return;
  for (const PartSetting& one : part.report.part_settings)
    if (one.kind == PartKind::Material)
      add_warning(part.report, work.context,
                  {"set-for-all-materials",
                   formatted("{}: {}: {} holds for all of the mesh, which has {} materials; make "
                             "meshes of them where the others are to be without",
                             part.report.label, one.who(), one.option, materials),
                   materials});
}

[[noreturn]] void refuse_name(const PartSetting& one, const std::vector<AssetName>& names,
                              std::string_view file) {
  constexpr std::size_t kMost = 12;
  std::vector<std::string_view> all;
  for (const AssetName& name : names) all.push_back(name.name);
  const std::string guess = did_you_mean(one.name, all);
  if (const auto best = nearest(one.name, all))
    std::ranges::stable_partition(all, [&](std::string_view name) { return name == *best; });
  std::string list;
  for (std::size_t i = 0; i < std::min(all.size(), kMost); ++i)
    list += (i == 0 ? "" : ", ") + visible(all[i]);
  if (all.size() > kMost) list += formatted(", and {} more", all.size() - kMost);
  refuse(one.who(), "{} has no {} of that name{}; {}", file, name_of(one.kind), guess,
         all.empty() ? "none has a name" : "there are " + list);
}

// Of one fineness.
struct PartLevel {
  SurfaceOutputOptions options;
  LevelFields fields;
  std::unique_ptr<JobLevel> level;
  std::unique_ptr<const AssetAttributes> attributes;
  std::unique_ptr<const BakedAssetMesh> baked;  // where maps are wanted
};

FittedJob job_of(const AssetJob& work, AssetPart& part) {
  return {work.job,  part.outputs,     work.backend, work.context,
          part.made, part.made.fitted, part.report,  work.staged};
}

void prepare_part(const AssetJob& work, const AssetNames& names, AssetPart& part) {
  part.report = {.job = work.report.job,
                 .label = work.report.label,
                 .input = work.report.input,
                 .device = work.report.device,
                 .settings = work.report.settings};
  Settings& settings = part.report.settings;
  part.report.part_settings = settings_of_mesh(settings.parts, names, part.number);
  for (const PartSetting& one : part.report.part_settings) {
    one.apply_to(settings);
    part.has_own_level |= one.option == "levels" && !settings.levels_by_density;
  }
  part.mesh = timed(part.report.timing.read, [&] {
    return work.asset.read(part.number, work.job.settings.bake > 0, settings.creases.split_normals);
  });
  if (work.asset.surfaces().size() > 1) {
    part.report.label = named_message(work.report.label, part.mesh.name);
    part.report.is_told_with_others = true;
  }
  part.made.input = {.name = part.report.label.empty() ? work.file.name : part.report.label,
                     .file = std::move(part.mesh.file),
                     .sha256 = {}};
  warn_of_whole_mesh(work, names, part);
  const MeshFile& file = part.made.input.file;
  for (const Warning& warning : file.warnings) add_warning(part.report, work.context, warning);
  part.report.input.welded = file.welded_vertex_count;
  part.report.input.dropped = file.dropped_element_count;
  part.report.input.file_vertices = file.mesh.vertex_count();
  part.report.input.file_faces = file.mesh.face_count();
  part.ready = timed(part.report.timing.check,
                     [&] { return prepare_input(part.made, part.report, work.context); });
}

void fit_part(const AssetJob& work, AssetPart& part) {
  fit_input(part.made, std::move(part.ready), work.backend, {}, part.report, work.context);
  part.outputs = settled(work.outputs, fineness_of(part));
  // Of several, what has none on one has on another.
  if (work.asset.surfaces().size() == 1)
    warn_of_unused_settings(work.job, part.made, part.report, work.context);
  part.surface = std::make_unique<JobSurface>(part.made.fitted, work.backend,
                                              callbacks_for(part.report, work.context));
}

// Meshes of an asset that have warnings of one kind.
struct MeshWarnings {
  std::int64_t meshes = 0;
  std::string first_mesh, message;  // of the first
};

// Without the names of file and mesh, which messages may begin with.
std::string bare_message(std::string message, std::initializer_list<std::string> names) {
  for (const std::string& name : names)
    if (!name.empty() && message.starts_with(name + ": ")) message.erase(0, name.size() + 2);
  return message;
}

// One line for each kind of warning that meshes have; a line for each mesh would be hundreds. Those
// from `told` on, by part, which then is all.
void tell_warnings_of_meshes(const AssetJob& work, const std::list<AssetPart>& parts,
                             std::vector<std::size_t>& told) {
  const std::string file = input_name(work.report.input.path);
  std::vector<std::pair<std::string, MeshWarnings>> kinds;
  told.resize(parts.size(), 0);
  auto place = told.begin();
  for (const AssetPart& part : parts) {
    const std::vector<Warning>& warnings = part.report.warnings;
    std::set<std::string> known;
    for (; part.report.is_told_with_others && *place < warnings.size(); ++*place) {
      const Warning& warning = warnings[*place];
      if (!known.insert(warning.code).second) continue;
      auto kind = std::ranges::find(kinds, warning.code, &decltype(kinds)::value_type::first);
      if (kind == kinds.end()) {
        kinds.push_back(
            {warning.code,
             {0, part.mesh.name,
              bare_message(warning.message, {file, part.report.label, part.mesh.name})}});
        kind = kinds.end() - 1;
      }
      ++kind->second.meshes;
    }
    ++place;
  }
  for (const auto& [code, kind] : kinds) {
    const std::string whose =
        kind.meshes == 1 ? kind.first_mesh
                         : formatted("{}, first {}", counted(kind.meshes, "mesh"), kind.first_mesh);
    if (work.context.watch.warning)
      work.context.watch.warning(
          {code, formatted("{}: {}: {}", file, whose, kind.message), kind.meshes, -1});
  }
}

// Progress of a mesh while it lives.
JobProgress::Part part_of(const AssetJob& work, const MeshShare& share) {
  return {work.context.progress, share.begin, share.end};
}

// In order: first all are read and made ready, so that what they take together is known, then one
// after another is fitted.
std::list<AssetPart> fit_parts(const AssetJob& work) {
  const std::vector<std::int64_t>& numbers = work.asset.surfaces();
  const std::vector<MeshShare> shares = mesh_shares(work.asset);
  const auto warn = [&](const Warning& warning) {
    add_warning(work.report, work.context, warning);
  };
  const AssetNames names = names_of(work.asset);
  std::list<AssetPart> parts;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    AssetPart& part = parts.emplace_back();
    part.number = numbers[i];
    part.share = shares[i];
    if (!try_mesh(work.asset, part.number, warn, [&] {
          check_stop();
          const auto progress = part_of(work, part.share);
          prepare_part(work, names, part);
        }))
      parts.pop_back();
  }
  require_any(work.asset, parts.size());
  std::int64_t points = 0;
  double triangles = 0;
  for (AssetPart& part : parts) {
    points += part.report.input.file_vertices;
    part.triangle_share = triangles_of(part.ready.input.mesh);
    triangles += part.triangle_share;
  }
  for (AssetPart& part : parts) part.triangle_share /= triangles;
  require_points(work.job, work.file.name, points);
  std::vector<MeshNeed> needs;
  for (const AssetPart& part : parts) needs.push_back({&part.ready, &part.mesh.vertices});
  require_memory_for(needs, work.job.settings, work.outputs);
  for (auto part = parts.begin(); part != parts.end();) {
    const bool is_fitted = try_mesh(work.asset, part->number, warn, [&] {
      check_stop();
      const auto progress = part_of(work, part->share);
      fit_part(work, *part);
    });
    part = is_fitted ? std::next(part) : parts.erase(part);
  }
  require_any(work.asset, parts.size());
  return parts;
}

// One mesh of several may get no map, which its report says.
void require_maps(const std::list<PartLevel>& levels) {
  const auto has_none = [](const PartLevel& level) {
    return level.baked && !level.baked->why_none().empty();
  };
  if (std::ranges::all_of(levels, has_none))
    throw Error(ErrorCode::UnusableMesh, levels.front().baked->why_none());
}

std::list<PartLevel> levels_of(const AssetJob& work, std::list<AssetPart>& parts,
                               const Fineness& fineness) {
  std::list<PartLevel> levels;
  for (AssetPart& part : parts) {
    // Solves of joints and targets take as long as the surface.
    const double half = std::midpoint(part.share.begin, part.share.end);
    const double made_at = part.mesh.vertices.moves() ? half : part.share.end;
    const FittedJob job = job_of(work, part);
    PartLevel& made = levels.emplace_back();
    made.options = surface_options(job);
    made.options.may_be_scaled = work.asset.may_be_scaled(part.mesh.number);
    {
      const auto progress = part_of(work, {part.share.begin, made_at});
      made.level = std::make_unique<JobLevel>(surface_of(
          job, *part.surface, settled(fineness, fineness_of(part)), made.fields, made.options));
    }
    const auto progress = part_of(work, {made_at, part.share.end});
    made.attributes = timed(part.report.timing.evaluate, [&] {
      return std::make_unique<const AssetAttributes>(part.mesh, part.made.fitted,
                                                     made.level->blocks(), work.backend,
                                                     made.options.gltf.callbacks);
    });
    made.attributes->add_to(made.options.gltf);
    made.baked =
        baked_mesh(job, work.asset, part.mesh, *part.surface, *made.level, *made.attributes);
    if (made.baked && !made.baked->why_none().empty())
      add_warning(part.report, work.context,
                  {"bake-left-out", made.baked->why_none() + "; it stays without a map"});
    part.report.lost_joint_weight =
        std::max(part.report.lost_joint_weight, made.attributes->largest_lost_weight());
  }
  require_maps(levels);
  return levels;
}

// Levels of detail of an asset's file, finest first, each of all its parts in their order.
using Details = std::list<std::list<PartLevel>>;

// Of the screen, down to which each of several levels of detail is shown. A mesh is as large on
// the screen as it is seen there, and what is left out of a coarser level, too: that takes over
// where it looks no larger than what the finest leaves out does in full. `left_out`: lengths, of
// each level, finest first. The coarsest never vanishes.
std::vector<double> least_coverages(std::span<const double> left_out) {
  std::vector<double> coverages;
  for (std::size_t i = 1; i < left_out.size(); ++i) {
    const double share = left_out.front() / left_out[i];
    coverages.push_back(share * share);
  }
  coverages.push_back(0);
  return coverages;
}

std::vector<double> left_out_of(const std::vector<Fineness>& finenesses) {
  std::vector<double> left_out;
  for (const Fineness& one : finenesses) left_out.push_back(left_out_by(one));
  return left_out;
}

// Adds a mesh's to those of the meshes before it.
void add_figures(const DecimationFigures& one, DecimationFigures& all) {
  const auto before = static_cast<double>(all.places), own = static_cast<double>(one.places);
  all.max = std::max(all.max, one.max);
  all.rms = std::sqrt((before * all.rms * all.rms + own * one.rms * one.rms) / (before + own));
  all.places += one.places;
  all.finer += one.finer;
  all.wanted += one.wanted;
  all.mean_edge_length = std::max(all.mean_edge_length, one.mean_edge_length);
}

void write_details(const AssetJob& work, const PlannedOutput& planned, std::list<AssetPart>& parts,
                   Details& details, WrittenOutput& written, std::vector<std::byte>& stdout_bytes) {
  std::list<MeasuredGltf> measured;
  std::vector<double> diagonals;
  written = {};
  const auto surface_of = [&](const AssetPart& part, PartLevel& level) {
    MeasuredGltf& one = measured.emplace_back();
    measure_gltf(planned, level.level->blocks(), level.options, one);
    diagonals.push_back(level.options.diagonal);
    const WrittenOutput counts = counted_output(planned, level.level->blocks().info());
    written.vertices += counts.vertices;
    written.faces += counts.faces;
    written.quads += counts.quads;
    written.triangles += counts.triangles;
    AssetSurface surface{.mesh = part.mesh.number,
                         .surface = &level.level->blocks(),
                         .vertices = &part.mesh.vertices,
                         .options = one.options};
    if (level.baked) {
      level.baked->add_to(surface);
      note_maps(level.baked->maps(), part.mesh.name, work.job.settings.bake, written);
    }
    return surface;
  };
  const std::vector<double> coverages = least_coverages(left_out_of(planned.finenesses()));
  std::vector<AssetSurface> surfaces;
  auto coverage = coverages.begin();
  for (std::list<PartLevel>& levels : details) {
    auto part = parts.begin();
    if (levels.front().level->decimated()) written.decimated.emplace_back();
    for (PartLevel& level : levels) {
      if (level.level->decimated())
        add_figures(*level.level->decimated(), written.decimated.back());
      surfaces.push_back(surface_of(*part++, level));
      surfaces.back().least_coverage = *coverage;
    }
    ++coverage;
  }
  written.path = utf8(planned.path);
  written.kind = planned.kind;
  int finest = 0;
  for (const AssetPart& part : parts) finest = std::max(finest, part.report.fit.density.level());
  written.fineness = settled(planned.fineness, {finest});
  written.coarser = planned.coarser;
  GltfOptions common;
  common.name = work.report.input.path;
  common.callbacks = callbacks_for(work.report, work.context);
  WrittenDigest digest(work.job.digests);
  common.observe = digest.observer();
  if (planned.to_stdout) {
    stdout_bytes = encode_asset(work.asset, surfaces, common);
    written.bytes = stdout_bytes.size();
    digest.add(stdout_bytes);
  } else {
    const std::filesystem::path target = work.staged.stage(planned.path);
    written.bytes =
        write_asset(target, planned.path.parent_path(), work.asset, surfaces, common).byte_count;
    const std::filesystem::path beside = companion_of(target, planned.format);
    if (!beside.empty()) (void)work.staged.stage(companion_of(planned.path, planned.format));
  }
  written.sha256 = digest.finish();
  auto diagonal = diagonals.begin();
  for (const MeasuredGltf& one : measured)
    written.as_written_error = std::max(written.as_written_error, one.distance / *diagonal++);
}

void add_timing(const JobTiming& from, JobTiming& to) {
  for (const auto& [name, step] : kTimedSteps) to.*step += from.*step;
}

// One mesh is the job; of several the job has sums.
void settle_report(std::list<AssetPart>& parts, JobReport& report) {
  for (AssetPart& part : parts) {
    part.report.mesh_name = part.mesh.name;
    part.report.mesh_number = part.mesh.number;
    report.falls_short |= part.report.falls_short;
    add_timing(part.report.timing, report.timing);
  }
  if (parts.size() > 1) {
    for (AssetPart& part : parts) {
      report.input.file_vertices += part.report.input.file_vertices;
      report.input.file_faces += part.report.input.file_faces;
      report.meshes.push_back(std::move(part.report));
    }
    return;
  }
  JobReport& one = parts.front().report;
  one.outputs = std::move(report.outputs);
  one.arguments = std::move(report.arguments);
  one.timing = report.timing;
  one.falls_short = report.falls_short;
  one.warnings.insert(one.warnings.begin(), report.warnings.begin(), report.warnings.end());
  report = std::move(one);
}

}  // namespace

bool try_mesh(const GltfAsset& asset, std::int64_t number,
              const std::function<void(const Warning&)>& warn, const std::function<void()>& step) {
  try {
    step();
    return true;
  } catch (const Error& error) {
    if (asset.surfaces().size() == 1 || error.code() != ErrorCode::UnusableMesh) throw;
    warn({"kept-mesh",
          formatted("{}: meshes[{}] stays as it is, no surface can be made of it: {}",
                    asset.file().name, number, error.what()),
          1, number});
    return false;
  }
}

void require_any(const GltfAsset& asset, std::size_t count) {
  if (count == 0)
    throw Error(ErrorCode::UnusableMesh,
                formatted("{}: no surface can be made of any mesh", asset.file().name));
}

std::optional<std::string> reason_to_merge(const Job& job,
                                           const std::vector<PlannedOutput>& outputs) {
  if (job.settings.asset == AssetChoice::Merge || outputs.empty()) return "";
  if (!job.source.empty()) return "a source is compared with one mesh";
  if (!job.moves.empty()) return "moves are of one mesh's vertices";
  for (const PlannedOutput& output : outputs)
    if (output.kind == OutputKind::Cage || !info_of(output.format).is_gltf)
      return output_name(utf8(output.path)) + " holds one mesh";
  return std::nullopt;
}

void require_asset_for_lods(const std::vector<PlannedOutput>& outputs) {
  for (const PlannedOutput& output : outputs)
    if (!output.coarser.empty())
      throw Error(
          ErrorCode::InvalidArgument,
          output_name(utf8(output.path)) +
              ": levels of detail in one file are of a glTF with meshes that becomes a glTF "
              "by itself (--asset keep); take --lods files");
}

namespace {

// For jobs that keep no asset.
void require_asset_for(const Job& job, const std::vector<PlannedOutput>& outputs,
                       const std::string& name) {
  require_asset_for_lods(outputs);
  if (!job.settings.parts.empty())
    refuse(job.settings.parts[0].who(),
           "{} becomes one mesh; parts have options of their own where a glTF with meshes becomes "
           "a glTF by itself (--asset keep)",
           name);
}

}  // namespace

std::unique_ptr<const GltfAsset> kept_asset(const Job& job,
                                            const std::vector<PlannedOutput>& outputs,
                                            const InputFile& file, JobReport& report,
                                            const JobContext& context) {
  if (!info_of(file.format).is_gltf) {
    require_asset_for(job, outputs, file.name);
    return nullptr;
  }
  const auto reason = reason_to_merge(job, outputs);
  const bool writes_gltf = std::ranges::any_of(outputs, [](const PlannedOutput& output) {
    return info_of(output.format).is_gltf && !info_of(output.format).is_tiles;
  });
  if (reason && !reason->empty() && writes_gltf)
    add_warning(report, context,
                {"merged-asset",
                 formatted("{}: the scene becomes one mesh without nodes, skins and animations, "
                           "since {}; write the glTF by itself to keep them, or say --asset merge",
                           file.name, *reason)});
  auto asset = reason ? nullptr : asset_of(file.for_reader(), file.format);
  if (!asset) {
    require_asset_for(job, outputs, file.name);
    return nullptr;
  }
  report.input.format = name_of(file.format);
  report.input.sha256 = file.sha256();
  if (const auto warning = empty_scene_warning(asset->root()))
    add_warning(report, context, *warning);
  return asset;
}

void require_parts(const GltfAsset& asset, const Settings& settings,
                   const std::vector<PlannedOutput>& outputs) {
  if (settings.parts.empty()) return;
  const AssetNames names = names_of(asset);
  for (const PartSetting& one : settings.parts) {
    const std::vector<AssetName>& all = names_of(names, one.kind);
    const bool is_known =
        std::ranges::any_of(all, [&](const AssetName& name) { return one.names(name.name); });
    if (!is_known && !one.may_be_of_none()) refuse_name(one, all, asset.file().name);
    const bool is_one_level = std::ranges::all_of(outputs, [&](const PlannedOutput& output) {
      return output.coarser.empty() && !output.fineness.is_adaptive() &&
             output.fineness == outputs[0].fineness;
    });
    if (one.option == "levels" && !is_one_level)
      refuse(one.who(), "a part has a level of its own where all outputs have one level");
  }
  for (const std::int64_t mesh : asset.surfaces()) {
    Settings own = settings;
    for (const PartSetting& one : settings_of_mesh(settings.parts, names, mesh)) one.apply_to(own);
    check_consistent(own);
  }
}

AssetResult run_asset(const AssetJob& work) {
  require_parts(work.asset, work.job.settings, work.outputs);
  std::list<AssetPart> parts = fit_parts(work);
  std::vector<std::size_t> told;
  tell_warnings_of_meshes(work, parts, told);
  std::vector<std::byte> stdout_bytes;
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  const auto write = [&](std::size_t output, Details& details) {
    check_stop();
    work.context.progress.update("write", 0);
    timed(work.report.timing.write, [&] {
      write_details(work, work.outputs[output], parts, details, written[output], stdout_bytes);
    });
  };
  for (const Fineness& fineness : finenesses_of(work.outputs)) {
    Details details;
    details.push_back(levels_of(work, parts, fineness));
    for (std::size_t i = 0; i < work.outputs.size(); ++i)
      if (work.outputs[i].coarser.empty() && work.outputs[i].fineness == fineness)
        write(i, details);
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (work.outputs[i].coarser.empty()) continue;
    Details details;
    for (const Fineness& fineness : work.outputs[i].finenesses())
      details.push_back(levels_of(work, parts, fineness));
    write(i, details);
  }
  std::size_t mesh = 0;
  for (AssetPart& part : parts) {
    const FittedJob job = job_of(work, part);
    show_mesh(job, mesh++, *part.surface);
    measure_rest(job, *part.surface, surface_options(job));
  }
  for (const WrittenOutput& output : written)
    warn_of_rounding(parts.front().report, work.context, output);
  tell_warnings_of_meshes(work, parts, told);
  settle_report(parts, work.report);
  AssetResult result{std::move(stdout_bytes), {}};
  for (AssetPart& part : parts) result.fitted.push_back(std::move(part.made.fitted));
  return result;
}

}  // namespace planish
