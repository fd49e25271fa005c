// Measures how good surfaces are, by each method on meshes of many kinds. See README.md beside
// this file.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "planish/files/mesh_file.h"
#include "planish/reconstruct/mesher_process.h"
#include "quality/figures.h"
#include "quality/tables.h"

namespace {

using namespace planish;
using namespace planish::quality;

struct Arguments {
  std::vector<std::string> only, except;
  std::string folder;  // where meshes are written instead of being measured
  bool list = false, smoke = false, animation = false, check = false, wild = false, choice = false,
       defaults = false, creases = false, irregular = false, props = false;
  IrregularOptions of_irregular;
  std::vector<std::string> files;
};

void print_head() {
  std::printf(
      "| mesh (vertices) | method | folded %% | rms normal | max normal | bending | max distance | "
      "rms distance | interpolation |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|\n");
}

void print_row(const std::string& label, const Method& method, const Figures& f) {
  std::printf("| %s | %s | %.4f | %.2f | %.1f | %.2f | %.1e | %.1e | %.0e |\n", label.c_str(),
              method.name.c_str(), 100 * f.folded_area, f.rms_normal, f.max_normal, f.bending,
              f.max_distance, f.rms_distance, f.interpolation_error);
  std::fflush(stdout);
}

// As OBJ, named after the case with underscores.
void write_meshes(const std::vector<NamedCase>& cases, const std::filesystem::path& folder) {
  for (const NamedCase& named : cases) {
    std::string file = named.name;
    std::erase(file, ',');
    std::ranges::replace(file, ' ', '_');
    write_mesh(folder / (file + ".obj"), FileFormat::Obj, named.make().mesh);
  }
}

// Returns what falls short.
std::vector<std::string> run_case(const NamedCase& named) {
  const Case made = named.make();
  std::string label = made.name + (made.is_held_out ? "* (" : " (") +
                      std::to_string(made.mesh.vertex_count()) + ")";
  std::vector<Figures> figures;
  for (const Method& method : methods()) {
    figures.push_back(measure(made, method));
    print_row(label, method, figures.back());
    label.clear();
  }
  return shortfalls(made, figures);
}

std::vector<NamedCase> all_irregular(const Arguments& arguments) {
  if (arguments.files.empty()) return irregular_cases();
  std::vector<NamedCase> cases;
  for (const std::string& file : arguments.files) cases.push_back(simplified_file(file));
  return cases;
}

std::vector<NamedCase> all_cases(const Arguments& arguments) {
  if (arguments.irregular) return all_irregular(arguments);
  if (arguments.wild) return wild_cases();
  if (arguments.props) return prop_cases();
  std::vector<NamedCase> cases = analytic_cases();
  for (NamedCase& held_out : second_held_out_cases()) cases.push_back(std::move(held_out));
  if (arguments.choice || arguments.defaults)
    for (NamedCase& dense : dense_cases()) cases.push_back(std::move(dense));
  if (arguments.smoke) return cases;
  if (arguments.choice || arguments.defaults) {
    for (NamedCase& decimated : decimated_cases()) cases.push_back(std::move(decimated));
    return cases;
  }
  if (const auto program = find_mesher_program()) {
    for (NamedCase& scanned : scanned_cases(mesher_process(*program))) {
      cases.push_back(std::move(scanned));
    }
  } else {
    std::fputs("planish-quality: without planish-reconstruct no scans are measured\n", stderr);
  }
  for (NamedCase& file : file_cases()) cases.push_back(std::move(file));
  return cases;
}

bool is_wanted(const std::string& name, const Arguments& arguments) {
  const auto holds = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return !holds(arguments.except) && (arguments.only.empty() || holds(arguments.only));
}

std::vector<std::string> print_tables(const std::vector<NamedCase>& cases,
                                      const Arguments& arguments) {
  if (cases.empty()) return {};
  if (arguments.wild) return print_wild_table(cases);
  if (arguments.props) return print_prop_table(cases);
  if (arguments.irregular) return print_irregular_table(cases, arguments.of_irregular);
  if (arguments.choice) return print_choice_table(cases);
  if (arguments.defaults) {
    const auto program = find_mesher_program();
    const Mesher mesher = program ? mesher_process(*program) : Mesher();
    return print_default_table(cases, program && !arguments.smoke ? &mesher : nullptr);
  }
  print_head();
  std::vector<std::string> wrong;
  for (const NamedCase& named : cases) {
    for (std::string& text : run_case(named)) wrong.push_back(std::move(text));
  }
  return wrong;
}

int run(const Arguments& arguments) {
  std::vector<NamedCase> cases;
  if (!arguments.creases) cases = all_cases(arguments);
  if (arguments.list) {
    for (const NamedCase& named : cases) std::printf("%s\n", named.name.c_str());
    return 0;
  }
  std::erase_if(cases, [&](const NamedCase& named) { return !is_wanted(named.name, arguments); });
  if (!arguments.folder.empty()) {
    write_meshes(cases, arguments.folder);
    return 0;
  }
  const std::vector<std::string> wrong =
      arguments.creases
          ? print_crease_table([&](const std::string& name) { return is_wanted(name, arguments); })
          : print_tables(cases, arguments);
  if (arguments.animation) print_animation(arguments.smoke ? 8 : kFrames);
  if (!wrong.empty()) std::printf("\n");
  for (const std::string& text : wrong) std::printf("short of the aim: %s\n", text.c_str());
  return arguments.check && !wrong.empty() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Measures surfaces against the shapes that their meshes were taken from."};
  app.add_option("--case", arguments.only, "cases to run, by name; all by default");
  app.add_option("--except", arguments.except, "cases to leave out, by name");
  app.add_flag("--list", arguments.list, "name the cases");
  app.add_flag("--animation", arguments.animation, "and 8 s of a mesh that moves");
  app.add_flag("--smoke", arguments.smoke, "the small cases only");
  app.add_flag("--wild", arguments.wild,
               "meshes as other people's files hold them, and their folds");
  app.add_flag("--choice", arguments.choice,
               "which surface is taken by measurement, and which is nearer to the shape");
  app.add_flag("--defaults", arguments.defaults,
               "what comes out without a flag, beside the best of all flags");
  app.add_flag("--props", arguments.props,
               "the same of props, parts and vehicles as technical artists have them");
  CLI::Option* irregular = app.add_flag(
      "--irregular", arguments.irregular,
      "facets of meshes of uneven triangles, against their shapes and those of manifold-3d");
  app.add_option("--manifold", arguments.of_irregular.manifold,
                 "where npm installed manifold-3d; without, no peer is measured")
      ->needs(irregular);
  app.add_option("--more-levels", arguments.of_irregular.more_levels,
                 "with --irregular: finer by so many levels than by default")
      ->needs(irregular);
  app.add_option("--file", arguments.files,
                 "with --irregular: these meshes, simplified, instead of the cases")
      ->needs(irregular);
  app.add_flag("--creases", arguments.creases, "which edges are found to be sharp");
  app.add_option("--write", arguments.folder, "write the cases' meshes into this folder instead");
  app.add_flag("--check", arguments.check, "exit code 1 where the fair method falls short");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-quality: %s\n", error.what());
    return 2;
  }
}
