#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "job/input_path.h"
#include "job/verify.h"
#include "output/cage_header.h"
#include "report/report.h"
#include "terminal/faults.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct VerifyFlags {
  std::string cage, input, interpolation, scheme, weights, boundary, creases, repair;
  std::string tolerance, weld;
  bool json = false;
};

// Flags first, then the cage's header, then the defaults of fit.
VerifyOptions verify_options(const VerifyFlags& flags, const CageHeader& header) {
  VerifyOptions options;
  options.interpolation = header.interpolation.value_or(options.interpolation);
  options.scheme = header.scheme.value_or(options.scheme);
  options.weights = header.weights.value_or(options.weights);
  options.boundary = header.boundary.value_or(options.boundary);
  options.creases = header.creases.value_or(options.creases);
  options.repair = header.repair.value_or(options.repair);
  options.tolerance = header.tolerance.value_or(options.tolerance);
  options.weld = header.weld;
  options.smoothed_vertices = header.smoothed_vertices;
  if (!flags.interpolation.empty()) {
    options.interpolation = parse_method(flags.interpolation, "--interpolation");
  }
  if (!flags.scheme.empty()) options.scheme = parse_scheme(flags.scheme, "--scheme");
  if (!flags.weights.empty()) options.weights = parse_weights(flags.weights, "--weights");
  if (!flags.boundary.empty()) options.boundary = parse_boundary(flags.boundary, "--boundary");
  if (!flags.creases.empty()) options.creases = parse_creases(flags.creases, "--creases");
  if (!flags.repair.empty()) options.repair = parse_repair(flags.repair, "--repair");
  if (!flags.weld.empty()) {
    Settings checked;
    set_weld(checked, std::string_view(flags.weld), "--weld");
    options.weld = checked.weld;
  }
  if (!flags.tolerance.empty()) {
    Settings checked;
    set_tolerance(checked, std::string_view(flags.tolerance), "--tolerance");
    options.tolerance = checked.tolerance;
  }
  return options;
}

std::string to_json_text(const Verification& result, const VerifyOptions& options,
                         const Input& cage, const Input& given) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.verify/1";
  json["cage"] = {{"path", cage.name}, {"sha256", cage.sha256}};
  json["input"] = {{"path", given.name}, {"sha256", given.sha256}};
  json["interpolation"] = name_of(options.interpolation);
  json["scheme"] = name_of(options.scheme);
  const bool has_weights = options.scheme == Scheme::DooSabin;
  json["weights"] = has_weights ? nlohmann::ordered_json(name_of(options.weights)) : nullptr;
  json["boundary"] = name_of(options.boundary);
  json["creases"] = name_of(options.creases);
  json["repair"] = name_of(options.repair);
  json["weld"] = options.weld ? nlohmann::ordered_json(*options.weld) : nullptr;
  json["tolerance"] = options.tolerance;
  json["vertices"] = result.vertex_count;
  json["error"] = {
      {"max", result.error.max}, {"rms", result.error.rms}, {"worst_vertex", result.worst_vertex}};
  json["confirmed"] = result.confirmed;
  return json_text(json);
}

std::string to_text(const Verification& result, const VerifyOptions& options, const Input& cage,
                    const Input& given) {
  return std::string(result.confirmed ? "confirmed" : "rejected") + ": the limit surface of " +
         cage.name + (result.confirmed ? " passes" : " does not pass") + " through the " +
         with_separators(result.vertex_count) + " vertices of " + given.name + "\n  max error  " +
         short_number(result.error.max) + " of the diagonal, at vertex " +
         std::to_string(result.worst_vertex) + " (tolerance " + short_number(options.tolerance) +
         ")\n  rms error  " + short_number(result.error.rms) + "\n  surface    " +
         subdivision_text(options.scheme, options.weights) + ", boundary " +
         std::string(name_of(options.boundary)) + ", creases " + name_of(options.creases) +
         ", repair " + std::string(name_of(options.repair)) + "\n";
}

ExitCode run_verify(const VerifyFlags& flags) {
  Faults faults;
  faults.note([&] { require_input(flags.cage, {}); });
  faults.note([&] { require_input(flags.input, {}); });
  faults.note([&] { (void)verify_options(flags, {}); });
  faults.throw_if_any();
  const Input cage = read_input(flags.cage, std::nullopt);
  const CageHeader header = parse_cage_header(cage.file.header, cage.name);
  const VerifyOptions options = verify_options(flags, header);
  InputFile input = load_input(flags.input, std::nullopt);
  input.split_normals_crease = options.creases.split_normals;
  const Input given = mesh_of(input);
  const Verification result = verify(cage, given, options);
  if (flags.json) {
    write_stdout(to_json_text(result, options, cage, given));
  } else {
    write_text(to_text(result, options, cage, given));
  }
  return result.confirmed ? ExitCode::Done : ExitCode::NotConverged;
}

}  // namespace

void add_verify_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "verify", "how far a mesh's vertices are from the limit surface of its cage");
  auto flags = std::make_shared<VerifyFlags>();
  command->add_option("CAGE", flags->cage, "control cage, as fit --cage writes it")
      ->type_name("CAGE")
      ->required();
  command->add_option("INPUT", flags->input, "the mesh that was fitted")
      ->type_name("INPUT")
      ->required();
  const char* group = "Instead of what the cage's header says";
  command->add_option("--interpolation", flags->interpolation, "how the mesh was fitted")
      ->type_name("progressive|fair")
      ->group(group);
  command->add_option("--scheme", flags->scheme, "subdivision scheme")
      ->type_name("doo-sabin|catmull-clark|loop")
      ->group(group);
  command->add_option("--weights", flags->weights, "subdivision weights")
      ->type_name("doo-sabin|averaged")
      ->group(group);
  command->add_option("--boundary", flags->boundary, "rule of open boundaries")
      ->type_name("edge|edge-and-corner")
      ->group(group);
  command->add_option("--creases", flags->creases, "which edges are sharp")
      ->type_name("use|ignore|normals|auto[:DEGREES]")
      ->group(group);
  command->add_option("--repair", flags->repair, "how the mesh was mended")
      ->type_name("safe|none")
      ->group(group);
  command->add_option("--weld", flags->weld, "within what fraction vertices were welded")
      ->type_name("T")
      ->group(group);
  command->add_option("--tolerance", flags->tolerance, "largest error that is confirmed")
      ->type_name("T")
      ->group(group);
  command->add_flag("--json", flags->json, "as JSON")->group("Flags");
  invocation.texts["verify"] = {
      .examples = {"planish verify cage.obj bunny.obj",
                   "planish verify cage.obj bunny.obj --tolerance 1e-9 --json"},
      .first_flags = {},
      .notes =
          "Recomputed in double on the CPU, whatever device fitted the cage.\n"
          "Exit code 5 above the tolerance."};
  command->callback(
      [flags, &invocation] { invocation.action = [flags] { return run_verify(*flags); }; });
}

}  // namespace planish::command
