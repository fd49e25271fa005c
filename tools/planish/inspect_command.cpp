#include "inspect_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <span>

#include "commands.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/write_polygons.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/mend/repair.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/reconstruct.h"
#include "terminal.h"

namespace planish::command {
namespace {

std::int64_t point_count(const Inspection& inspection) {
  return static_cast<std::int64_t>(inspection.points->cloud.points.size());
}

// As fit does it.
bool can_be_mended(const PolygonMesh& mesh) {
  try {
    return prepare_if_sound(repair(mesh).mesh) != nullptr;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    return false;
  }
}

void note_box(Inspection& inspection, std::span<const glm::dvec3> points,
              const glm::dvec3& origin) {
  if (points.empty()) return;
  const auto [low, high] = point_bounds(points);
  inspection.box = {origin + low, origin + high};
}

void measure_points(Inspection& inspection) {
  const PointCloud& cloud = inspection.points->cloud;
  note_box(inspection, cloud.points, cloud.origin);
  inspection.diagonal = diagonal_of(cloud.points);
  inspection.spacing = clean(cloud.points, {.outliers = OutlierRule::Off, .callbacks = {}}).spacing;
}

std::string inspection_line(const std::string& label, const std::string& value) {
  std::string text = "  " + label;
  text.resize(20, ' ');
  return text + value + "\n";
}

// A line only where there is something to count.
std::string line_if_any(const std::string& label, std::int64_t count) {
  return count > 0 ? inspection_line(label, with_separators(count)) : std::string();
}

std::string vector_text(const glm::dvec3& v) {
  return formatted("({}, {}, {})", short_number(v.x), short_number(v.y), short_number(v.z));
}

std::string exact_text(const glm::dvec3& v) {
  return formatted("({}, {}, {})", shortest(v.x), shortest(v.y), shortest(v.z));
}

// Of points far from 0 with all digits: three would say the same of both.
std::string box_line(const Inspection& inspection) {
  if (!inspection.box) return "";
  const bool is_far = inspection.points && inspection.points->cloud.origin != glm::dvec3(0.0);
  const auto text = is_far ? exact_text : vector_text;
  return inspection_line("bounds",
                         text(inspection.box->front()) + " to " + text(inspection.box->back()));
}

// "3: 20, 4: 1"
std::string histogram_text(const std::vector<std::int64_t>& counts) {
  std::string text;
  for (std::size_t n = 0; n < counts.size(); ++n) {
    if (counts[n] == 0) continue;
    text += formatted("{}{}: {}", text.empty() ? "" : ", ", n, with_separators(counts[n]));
  }
  return text.empty() ? "none" : text;
}

// "ground 12, water 3"; of many the first ones.
std::string named_counts_text(const ScanContents::Counts& counts) {
  constexpr std::size_t kShown = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, counts.size()); ++i)
    text += (i > 0 ? ", " : "") + counts[i].first + ": " + with_separators(counts[i].second);
  return counts.size() > kShown ? text + " and more; --json lists all" : text;
}

std::string scan_text(const ScanContents& scan) {
  const auto line = [](const std::string& label, const std::string& value) {
    return value.empty() ? std::string() : inspection_line(label, visible(value));
  };
  return line("version", scan.version) + line("software", scan.software) +
         line("coordinates", scan.coordinate_system) +
         inspection_line("scans", formatted("{} ({})", with_separators(std::ssize(scan.scans)),
                                            named_counts_text(scan.scans))) +
         line("classes", named_counts_text(scan.classes));
}

std::vector<std::string> names_of_attributes(std::span<const VertexAttribute> attributes) {
  std::vector<std::string> names;
  for (const VertexAttribute& attribute : attributes) names.push_back(attribute.name);
  return names;
}

std::string attributes_line(std::span<const VertexAttribute> attributes) {
  std::string names;
  for (const std::string& name : names_of_attributes(attributes))
    names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? names : inspection_line("attributes", names);
}

std::string points_text(const Inspection& inspection) {
  const PointCloud& cloud = inspection.points->cloud;
  std::string text = inspection_line("points", with_separators(point_count(inspection)));
  text += line_if_any(inspection.format == FileFormat::Ptx ? "nothing seen" : "not numbers",
                      cloud.missing_count);
  if (inspection.scan) text += scan_text(*inspection.scan);
  text += line_if_any("normals", std::ssize(cloud.normals));
  text += line_if_any("colours", std::ssize(cloud.colors));
  text += attributes_line(cloud.attributes);
  text += box_line(inspection);
  text += inspection_line("diagonal", short_number(inspection.diagonal));
  text += inspection_line("spacing", short_number(inspection.spacing));
  for (const Warning& warning : cloud.warnings)
    text += inspection_line("warning", visible(warning.message));
  return text;
}

std::string statistics_text(const MeshStatistics& statistics) {
  return inspection_line("edges", with_separators(statistics.edge_count)) +
         inspection_line("unused vertices", with_separators(statistics.unused_vertex_count)) +
         inspection_line("face sizes", histogram_text(statistics.face_size_counts)) +
         inspection_line("valences", histogram_text(statistics.valence_counts)) +
         inspection_line("boundary loops", with_separators(statistics.boundary_loop_count)) +
         inspection_line("components", with_separators(statistics.component_count)) +
         inspection_line("genus", with_separators(statistics.genus));
}

std::string folds_line(const FoldedEdges& folds) {
  return inspection_line(
      "folded edges",
      formatted("{} turn by more than 120 degrees, beside {} of the area; first at face {}",
                with_separators(folds.count), percent(folds.area), folds.first_face));
}

std::string problems_text(const Inspection& inspection) {
  constexpr std::size_t kShown = 10;
  const std::vector<MeshProblem>& problems = inspection.problems;
  std::string count = problems.empty() ? "none" : with_separators(std::ssize(problems));
  if (inspection.is_mended) count += ", which fit mends with a warning";
  std::string text = inspection_line("problems", count);
  for (std::size_t i = 0; i < std::min(kShown, problems.size()); ++i)
    text += formatted("    {}: {}\n", name_of(problems[i].kind), problems[i].message);
  if (problems.size() > kShown) text += "    and more; --json lists all\n";
  return text;
}

std::string list_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + visible(name);
  return text;
}

// "mesh" of "meshes", "node" of "nodes".
std::string_view singular_of(std::string_view list) {
  return list.substr(0, list.size() - (list.ends_with("shes") ? 2 : 1));
}

// What a glTF holds besides, and what fit makes of it.
std::string asset_text(const Inspection& inspection) {
  if (!inspection.asset_problem.empty())
    return inspection_line("asset", "cannot stay one: " + inspection.asset_problem);
  if (!inspection.asset) return "";
  const AssetContents& asset = *inspection.asset;
  std::string counts;
  for (const auto& [list, count] : asset.counts)
    counts += (counts.empty() ? "" : ", ") + counted(count, singular_of(list));
  std::string carried = list_text(asset.carried);
  if (asset.morph_targets > 0) carried += ", " + counted(asset.morph_targets, "morph target");
  std::string text = inspection_line("asset", counts);
  if (!asset.extensions.empty())
    text += inspection_line("extensions kept", list_text(asset.extensions));
  text += inspection_line("on the surface", carried);
  if (!asset.left_out.empty()) text += inspection_line("left out", list_text(asset.left_out));
  return text;
}

std::string mesh_text(const Inspection& inspection) {
  const MeshFile& file = inspection.input.file;
  std::string text = inspection_line("vertices", with_separators(file.mesh.vertex_count()));
  text += inspection_line("faces", with_separators(file.mesh.face_count()));
  text += box_line(inspection);
  if (inspection.statistics) {
    text += statistics_text(*inspection.statistics);
    text += inspection_line("diagonal", short_number(inspection.diagonal));
    if (inspection.folds->count > 0) text += folds_line(*inspection.folds);
    if (inspection.torn.count > 0)
      text += inspection_line("torn vertices", torn_text(inspection.torn));
  }
  const auto count = [](const auto& list) { return std::ssize(list); };
  text += inspection_line("crease edges", with_separators(count(file.mesh.creases)));
  text += inspection_line("corner vertices", with_separators(count(file.mesh.corners)));
  text += line_if_any("hole faces", count(file.mesh.hole_faces));
  text += line_if_any("texture points", count(file.mesh.uvs));
  text += line_if_any("colours", count(file.mesh.colors));
  text += attributes_line(file.mesh.attributes);
  text += line_if_any("groups", count(file.mesh.groups));
  text += line_if_any("materials", count(materials_of(file.mesh.groups)));
  text += line_if_any("welded vertices", file.welded_vertex_count);
  text += line_if_any("dropped elements", file.dropped_element_count);
  text += asset_text(inspection);
  for (const std::string& entry : file.header) text += inspection_line("header", visible(entry));
  for (const Warning& warning : file.warnings)
    text += inspection_line("warning", visible(warning.message));
  return text + problems_text(inspection);
}

void add_mesh(const Inspection& inspection, nlohmann::ordered_json& json) {
  const MeshFile& file = inspection.input.file;
  json["vertices"] = file.mesh.vertex_count();
  json["faces"] = file.mesh.face_count();
  json["crease_edges"] = file.mesh.creases.size();
  json["corner_vertices"] = file.mesh.corners.size();
  json["hole_faces"] = file.mesh.hole_faces.size();
  json["texture_points"] = file.mesh.uvs.size();
  json["colors"] = file.mesh.colors.size();
  json["attributes"] = names_of_attributes(file.mesh.attributes);
  json["groups"] = file.mesh.groups.size();
  json["materials"] = materials_of(file.mesh.groups);
  json["welded"] = file.welded_vertex_count;
  json["dropped"] = file.dropped_element_count;
  if (const auto& statistics = inspection.statistics) {
    json["diagonal"] = inspection.diagonal;
    json["edges"] = statistics->edge_count;
    json["unused_vertices"] = statistics->unused_vertex_count;
    json["face_sizes"] = histogram_json(statistics->face_size_counts);
    json["valences"] = histogram_json(statistics->valence_counts);
    json["boundary_loops"] = statistics->boundary_loop_count;
    json["components"] = statistics->component_count;
    json["genus"] = statistics->genus;
    json["folded_edges"] = {{"count", inspection.folds->count},
                            {"area", inspection.folds->area},
                            {"first_face", inspection.folds->first_face}};
    json["torn_vertices"] = inspection.torn.count;
  }
  json["header"] = file.header;
  if (!inspection.asset_problem.empty()) json["asset_problem"] = inspection.asset_problem;
  if (!inspection.asset) return;
  nlohmann::ordered_json& asset = json["asset"];
  for (const auto& [list, count] : inspection.asset->counts) asset["counts"][list] = count;
  asset["morph_targets"] = inspection.asset->morph_targets;
  asset["extensions"] = inspection.asset->extensions;
  asset["carried"] = inspection.asset->carried;
  asset["left_out"] = inspection.asset->left_out;
}

// What keeps it from staying an asset need not keep its triangles from being read.
void look_at_asset(const InputFile& file, Inspection& inspection) {
  try {
    if (const auto asset = asset_of(file.for_reader(), file.format))
      inspection.asset = contents_of(*asset);
    // Which counts for the scene as one mesh only.
    if (inspection.asset)
      std::erase_if(inspection.input.file.warnings,
                    [](const Warning& warning) { return warning.code == "ignored-deformation"; });
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    inspection.asset_problem = error.what();
  }
}

void add_points(const Inspection& inspection, nlohmann::ordered_json& json) {
  json["points"] = point_count(inspection);
  json["missing"] = inspection.points->cloud.missing_count;
  json["normals"] = inspection.points->cloud.normals.size();
  json["colors"] = inspection.points->cloud.colors.size();
  json["attributes"] = names_of_attributes(inspection.points->cloud.attributes);
  json["diagonal"] = inspection.diagonal;
  json["spacing"] = inspection.spacing;
  if (!inspection.scan) return;
  nlohmann::ordered_json& scan = json["scan"];
  scan["version"] = inspection.scan->version;
  scan["software"] = inspection.scan->software;
  scan["coordinate_system"] = inspection.scan->coordinate_system;
  for (const auto& [key, counts] : {std::pair("scans", &inspection.scan->scans),
                                    std::pair("classes", &inspection.scan->classes)}) {
    scan[key] = nlohmann::ordered_json::array();
    for (const auto& [name, points] : *counts)
      scan[key].push_back({{"name", name}, {"points", points}});
  }
}

}  // namespace

Inspection inspect(const InputFile& file) {
  Inspection inspection;
  inspection.format = file.format;
  if (holds_points_only(file.format)) {
    inspection.input.name = file.name;
    inspection.input.sha256 = file.sha256();
    inspection.points = points_of(file);
    if (const auto contents = info_of(file.format).scan_contents)
      inspection.scan = contents(file.for_reader());
  } else {
    inspection.input = mesh_of(file);
    inspection.format = inspection.input.file.format;
    inspection.points = points_of(inspection.input);
  }
  if (inspection.points) {
    measure_points(inspection);
    return inspection;
  }
  look_at_asset(file, inspection);
  const PolygonMesh& mesh = inspection.input.file.mesh;
  note_box(inspection, mesh.positions, glm::dvec3(0));
  // What its scene shows nothing of stays a glTF with its meshes.
  if (inspection.asset && mesh.face_count() == 0) return inspection;
  inspection.problems = check(mesh);
  inspection.is_mended = !inspection.problems.empty() && can_be_mended(mesh);
  if (inspection.problems.empty()) {
    inspection.statistics = statistics(mesh);
    inspection.folds = folded_edges(mesh);
    inspection.diagonal = placement_of(mesh).diagonal;
    const auto prepared = prepare_if_sound(mesh);
    if (prepared) {
      const UsedPart used = used_part(mesh, prepared);
      inspection.torn = torn_vertices(used.mesh, *prepared->topology);
    }
  }
  return inspection;
}

nlohmann::ordered_json inspection_json(const Inspection& inspection) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.inspect/1";
  json["path"] = inspection.input.name;
  json["sha256"] = inspection.input.sha256;
  json["format"] = name_of(inspection.format);
  if (inspection.points) {
    add_points(inspection, json);
  } else {
    add_mesh(inspection, json);
  }
  if (inspection.box) {
    json["bounds"] = nlohmann::ordered_json::array();
    for (const glm::dvec3& v : *inspection.box) json["bounds"].push_back({v.x, v.y, v.z});
  }
  const std::vector<Warning>& warnings =
      inspection.points ? inspection.points->cloud.warnings : inspection.input.file.warnings;
  json["warnings"] = nlohmann::ordered_json::array();
  for (const Warning& warning : warnings) json["warnings"].push_back(warning.message);
  json["problems"] = nlohmann::ordered_json::array();
  for (const MeshProblem& problem : inspection.problems) {
    json["problems"].push_back({{"kind", name_of(problem.kind)},
                                {"element", problem.element},
                                {"message", problem.message}});
  }
  json["mended"] = inspection.is_mended;
  return json;
}

std::string inspection_text(const Inspection& inspection) {
  return formatted("{} ({})\n{}", inspection.input.name, name_of(inspection.format),
                   inspection.points ? points_text(inspection) : mesh_text(inspection));
}

namespace {

struct InspectFlags {
  std::vector<std::string> files;
  std::string input_format;
  OptionTexts options;
  bool json = false;
  MessageFlags messages;
};

// What is wrong with a file does not keep the others from being looked at.
ExitCode inspect_all(const InspectFlags& flags) {
  Console console(flags.messages.level(), flags.messages.color_mode());
  std::optional<FileFormat> format;
  if (!flags.input_format.empty())
    format = parse_input_format(flags.input_format, "--input-format");
  FitSettings settings;
  apply_flags(flags.options, option_table(), settings);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  ExitCode exit_code = ExitCode::Done;
  Faults faults;
  for (const std::string& path : flags.files) {
    faults.note([&] {
      require_input(path, format);
      InputFile file = load_input(path, format);
      if (flags.json) file.take_digest();
      file.reach = settings.textures;
      const Inspection inspection = inspect(file);
      if (is_refused(inspection)) exit_code = ExitCode::UnusableMesh;
      if (flags.json) {
        all.push_back(inspection_json(inspection));
      } else {
        write_text(inspection_text(inspection));
      }
    });
  }
  if (flags.json && !all.empty())
    write_stdout(json_text(flags.files.size() == 1 ? all.front() : all));
  faults.throw_if_any();
  return exit_code;
}

}  // namespace

void add_inspect_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "inspect", "what a file of a mesh or points holds, and what is wrong in it");
  auto flags = std::make_shared<InspectFlags>();
  const char* group = "Flags";
  command->add_option("FILE", flags->files, "meshes or points; - for stdin")
      ->type_name("FILE...")
      ->required();
  command
      ->add_option("--input-format", flags->input_format,
                   "format of stdin, or where the extension is wrong [told by the content]")
      ->type_name(names_of(FormatUse::Read, "|"))
      ->group(group);
  add_option_flag(*command, flags->options, fit_option("textures"), group);
  command->add_flag("--json", flags->json, "as JSON; of several files a list")->group(group);
  flags->messages.add_to(*command, false);
  invocation.texts["inspect"] = {
      .examples = {"planish inspect bunny.obj", "planish inspect bunny.obj scan.ply --json"},
      .first_flags = {},
      .notes =
          "Exit code 4 when a mesh has problems that planish fit cannot mend. What it mends, with "
          "warnings, is listed, and the exit code is 0; planish fit --repair none refuses that, "
          "too."};
  command->callback(
      [flags, &invocation] { invocation.action = [flags] { return inspect_all(*flags); }; });
}

}  // namespace planish::command
