#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/job/input.h"
#include "planish/job/job_settings.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/option_table.h"
#include "terminal.h"

namespace planish::command {
namespace {

struct VerifyFlags {
  std::string cage, input;
  OptionTexts options;
  bool json = false;
};

// Flags first, then the cage's header, then the defaults of fit.
CageHeader with_flags(CageHeader header, const VerifyFlags& flags) {
  apply_flags(flags.options, option_table(), header.settings);
  if (flags.options.contains("creases")) header.found.reset();
  require_known_method(header.settings, "--interpolation");
  check_consistent(header.settings);
  return header;
}

std::string to_json_text(const Verification& result, const FitSettings& settings, const Input& cage,
                         const Input& given) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.verify/1";
  json["cage"] = {{"path", cage.name}, {"sha256", cage.sha256}};
  json["input"] = {{"path", given.name}, {"sha256", given.sha256}};
  const bool has_weights = settings.scheme == Scheme::DooSabin;
  for (const std::string_view name :
       {"interpolation", "scheme", "weights", "boundary", "creases", "repair"})
    json[std::string(name)] = option_text(settings, name);
  if (!has_weights) json["weights"] = nullptr;
  json["weld"] = settings.weld ? nlohmann::ordered_json(*settings.weld) : nullptr;
  json["tolerance"] = settings.tolerance;
  json["vertices"] = result.vertex_count;
  json["error"] = {
      {"max", result.error.max}, {"rms", result.error.rms}, {"worst_vertex", result.worst_vertex}};
  json["confirmed"] = result.confirmed;
  return json_text(json);
}

std::string to_text(const Verification& result, const FitSettings& settings, const Input& cage,
                    const Input& given) {
  return formatted(
      "{}: the limit surface of {}{} through the {} of {}\n  max error  {} of the diagonal, at "
      "vertex {} (tolerance {})\n  rms error  {}\n  surface    {}, boundary {}, creases {}, repair "
      "{}\n",
      result.confirmed ? "confirmed" : "rejected", cage.name,
      result.confirmed ? " passes" : " does not pass", counted(result.vertex_count, "vertex"),
      given.name, short_number(result.error.max), result.worst_vertex,
      short_number(settings.tolerance), short_number(result.error.rms),
      subdivision_text(settings.scheme, settings.weights), option_text(settings, "boundary"),
      option_text(settings, "creases"), option_text(settings, "repair"));
}

ExitCode run_verify(const VerifyFlags& flags) {
  Faults faults;
  faults.note([&] { require_input(flags.cage, {}); });
  faults.note([&] { require_input(flags.input, {}); });
  faults.note([&] { (void)with_flags({}, flags); });
  faults.throw_if_any();
  InputFile cage_file = load_input(flags.cage, std::nullopt);
  cage_file.take_digest();
  const Input cage = mesh_of(cage_file);
  const CageHeader made = with_flags(parse_cage_header(cage.file.header, cage.name), flags);
  InputFile input = load_input(flags.input, std::nullopt);
  input.take_digest();
  input.split_normals_crease = made.settings.creases.split_normals;
  input.is_strict = made.settings.repair == RepairChoice::None;
  input.reach = made.settings.textures;
  const Input given = mesh_of(input);
  VerifyOptions options = verify_options(made.settings);
  if (made.found) options.found = &*made.found;
  // Other formats than OBJ keep no tags: those of the given mesh count.
  options.cage_has_tags = info_of(cage.file.format).keeps_sharp_edges;
  options.cage_name = cage.name;
  options.given_name = given.name;
  const Verification result = verify_cage(cage.file.mesh, given.file.mesh, options);
  if (flags.json) {
    write_stdout(to_json_text(result, made.settings, cage, given));
  } else {
    write_text(to_text(result, made.settings, cage, given));
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
  for (const FitOption& option : option_table()) {
    if (!is_of_cages(option)) continue;
    OptionInfo info = option;
    info.initial = {};  // the header has it
    add_option_flag(*command, flags->options, info, group);
  }
  command->get_option("--interpolation")
      ->type_name("progressive|fair")
      ->description("how the mesh was fitted");
  add_option_flag(*command, flags->options, fit_option("textures"), "Flags");
  command->add_flag("--json", flags->json, "as JSON")->group("Flags");
  invocation.texts["verify"] = {
      .examples = {"planish verify cage.obj bunny.obj",
                   "planish verify cage.obj bunny.obj --tolerance 1e-9 --json"},
      .first_flags = {"--interpolation", "--scheme", "--weights", "--boundary", "--creases",
                      "--repair", "--tolerance", "--within", "--weld", "--json", "-h", "--help"},
      .notes =
          "Recomputed in double on the CPU, whatever device fitted the cage.\n"
          "Exit code 5 above the tolerance."};
  command->callback(
      [flags, &invocation] { invocation.action = [flags] { return run_verify(*flags); }; });
}

}  // namespace planish::command
