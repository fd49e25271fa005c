#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.h"
#include "job/input.h"
#include "planish/mesh/check.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/statistics.h"
#include "report/report.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct InspectFlags {
  std::string file, input_format;
  bool json = false;
};

struct Findings {
  Input input;
  std::vector<MeshProblem> problems;
  std::optional<MeshStatistics> statistics;  ///< of a mesh without problems
};

Findings inspect(const InspectFlags& flags) {
  std::optional<FileFormat> format;
  if (!flags.input_format.empty()) {
    format = parse_mesh_format(flags.input_format, "--input-format");
  }
  Findings findings;
  findings.input = read_input(flags.file, format);
  findings.problems = check(findings.input.file.mesh);
  if (findings.problems.empty()) findings.statistics = statistics(findings.input.file.mesh);
  return findings;
}

nlohmann::ordered_json to_json(const Findings& findings) {
  const MeshFile& file = findings.input.file;
  nlohmann::ordered_json json;
  json["schema"] = "planish.inspect/1";
  json["path"] = findings.input.name;
  json["sha256"] = findings.input.sha256;
  json["format"] = name_of(file.format);
  json["vertices"] = file.mesh.vertex_count();
  json["faces"] = file.mesh.face_count();
  json["crease_edges"] = file.mesh.creases.size();
  json["corner_vertices"] = file.mesh.corners.size();
  json["welded"] = file.welded_vertex_count;
  json["dropped"] = file.dropped_element_count;
  if (const auto& statistics = findings.statistics) {
    json["diagonal"] = placement_of(file.mesh).diagonal;
    json["edges"] = statistics->edge_count;
    json["unused_vertices"] = statistics->unused_vertex_count;
    json["face_sizes"] = histogram_json(statistics->face_size_counts);
    json["valences"] = histogram_json(statistics->valence_counts);
    json["boundary_loops"] = statistics->boundary_loop_count;
    json["components"] = statistics->component_count;
    json["genus"] = statistics->genus;
  }
  json["header"] = file.header;
  json["warnings"] = nlohmann::ordered_json::array();
  for (const Warning& warning : file.warnings) json["warnings"].push_back(warning.message);
  json["problems"] = nlohmann::ordered_json::array();
  for (const MeshProblem& problem : findings.problems) {
    json["problems"].push_back({{"kind", name_of(problem.kind)},
                                {"element", problem.element},
                                {"message", problem.message}});
  }
  return json;
}

std::string line(const std::string& label, const std::string& value) {
  std::string text = "  " + label;
  text.resize(20, ' ');
  return text + value + "\n";
}

// "3: 20, 4: 1"
std::string histogram(const std::vector<std::int64_t>& counts) {
  std::string text;
  for (std::size_t n = 0; n < counts.size(); ++n) {
    if (counts[n] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(n) + ": " + with_separators(counts[n]);
  }
  return text.empty() ? "none" : text;
}

std::string to_text(const Findings& findings) {
  constexpr std::size_t kShownProblems = 10;
  const MeshFile& file = findings.input.file;
  std::string text = findings.input.name + " (" + std::string(name_of(file.format)) + ")\n";
  text += line("vertices", with_separators(file.mesh.vertex_count()));
  text += line("faces", with_separators(file.mesh.face_count()));
  if (const auto& statistics = findings.statistics) {
    text += line("edges", with_separators(statistics->edge_count));
    text += line("unused vertices", with_separators(statistics->unused_vertex_count));
    text += line("face sizes", histogram(statistics->face_size_counts));
    text += line("valences", histogram(statistics->valence_counts));
    text += line("boundary loops", with_separators(statistics->boundary_loop_count));
    text += line("components", with_separators(statistics->component_count));
    text += line("genus", with_separators(statistics->genus));
    text += line("diagonal", short_number(placement_of(file.mesh).diagonal));
  }
  text += line("crease edges", with_separators(file.mesh.creases.size()));
  text += line("corner vertices", with_separators(file.mesh.corners.size()));
  if (file.welded_vertex_count > 0) {
    text += line("welded vertices", with_separators(file.welded_vertex_count));
  }
  if (file.dropped_element_count > 0) {
    text += line("dropped elements", with_separators(file.dropped_element_count));
  }
  for (const std::string& entry : file.header) text += line("header", entry);
  for (const Warning& warning : file.warnings) text += line("warning", warning.message);
  text += line("problems",
               findings.problems.empty() ? "none" : with_separators(findings.problems.size()));
  for (std::size_t i = 0; i < std::min(kShownProblems, findings.problems.size()); ++i) {
    text += "    " + std::string(name_of(findings.problems[i].kind)) + ": " +
            findings.problems[i].message + "\n";
  }
  if (findings.problems.size() > kShownProblems) text += "    and more; --json lists all\n";
  return text;
}

}  // namespace

void add_inspect_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command =
      app.add_subcommand("inspect", "what a mesh file holds, and what is wrong with it");
  auto flags = std::make_shared<InspectFlags>();
  command->add_option("FILE", flags->file, "mesh; - for stdin")->type_name("")->required();
  command->add_option("--input-format", flags->input_format, "of stdin, or against the extension")
      ->type_name(names_of(FormatUse::ReadMesh, "|"));
  command->add_flag("--json", flags->json, "as JSON");
  command->footer(
      "Examples:\n  planish inspect bunny.obj\n  planish inspect bunny.obj --json\n"
      "Exit code 4 when the mesh has problems, so that no surface can be made of it.\n");
  command->callback([flags, &invocation] {
    invocation.action = [flags] {
      const Findings findings = inspect(*flags);
      write_stdout(flags->json ? json_text(to_json(findings)) : to_text(findings));
      return findings.problems.empty() ? ExitCode::Done : ExitCode::UnusableMesh;
    };
  });
}

}  // namespace planish::command
