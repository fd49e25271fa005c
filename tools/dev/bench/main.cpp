// Times planish against its peers. See README.md beside this file.
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <utility>

#include "bench/benchmarks.h"

namespace {

using namespace planish::bench;

const std::vector<std::pair<std::string, std::vector<Row> (*)(const Options&)>> kGroups = {
    {"update", bench_update},   {"solve", bench_solve},     {"masks", bench_masks},
    {"surface", bench_surface}, {"patches", bench_patches}, {"job", bench_job},
    {"worst", bench_worst},
#ifdef PLANISH_HAS_VULKAN
    {"kernels", bench_kernels}, {"frame", bench_frame},     {"many", bench_many},
#endif
    {"query", bench_query},     {"edit", bench_edit},       {"osd", bench_osd},
    {"fair", bench_fair}};

// Google Benchmark takes its --benchmark_* flags and leaves the rest.
std::vector<Row> rows_or_refusal(const std::string& name, std::vector<Row> (*bench)(const Options&),
                                 const Options& options) {
  try {
    return bench(options);
  } catch (const planish::Error& error) {
    return {refusal(error, name, "as asked", "all")};
  }
}

// Returns whether all groups ran to their end.
bool run(const Options& options) {
  const Machine machine = this_machine();
  std::vector<Row> rows;
  std::vector<Failure> failures;
  for (const auto& [name, bench] : kGroups) {
    const bool wanted =
        options.groups.empty() ||
        std::find(options.groups.begin(), options.groups.end(), name) != options.groups.end();
    if (!wanted) continue;
    try {
      const std::vector<Row> measured = rows_or_refusal(name, bench, options);
      rows.insert(rows.end(), measured.begin(), measured.end());
    } catch (const std::exception& error) {
      std::fprintf(stderr, "planish-bench: %s: %s\n", name.c_str(), error.what());
      failures.push_back({name, error.what()});
    }
  }
  print_table(machine, rows);
  if (!options.json.empty()) write_json(options.json, machine, rows, failures);
  return failures.empty();
}

}  // namespace

int main(int argc, char** argv) {
  initialize_benchmark(argc, argv);
  Options options;
  bool smoke = false;
  CLI::App app{"Times planish against its peers; --benchmark_* flags are Google Benchmark's."};
  std::vector<std::string> names;
  for (const auto& [name, bench] : kGroups) names.push_back(name);
  app.add_option("--group", options.groups, "groups to run; all by default")
      ->check(CLI::IsMember(names));
  app.add_option("--quads", options.quad_count, "quads of the torus grid")
      ->check(CLI::Range(16, 4'000'000))
      ->capture_default_str();
  app.add_option("--sphere-level", options.sphere_level, "splits of the rough icosphere")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "runs of each peer")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--points", options.point_counts, "given points of the groups kernels and frame")
      ->check(CLI::Range(64, 100'000'000));
  app.add_option(
      "--device", options.device,
      "the Vulkan device: a number, name or UUID of planish devices; the best by default");
  app.add_option(
      "--max-range", options.max_range,
      "bytes that a binding may span in these two and in evaluate; the device's limit by default");
  app.add_flag("--hardware-kernels", options.hardware_kernels,
               "in these two: kernels as hardware gets them, on software devices too");
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_flag("--smoke", smoke, "tiny sizes, three runs: checks that everything runs and agrees");
  CLI11_PARSE(app, argc, argv);
  if (smoke) {
    options.quad_count = 2'500;
    options.sphere_level = 3;
    options.repetitions = 3;
    if (app.count("--points") == 0) options.point_counts = {2'500};
    options.hub_faces = 512;
    options.loop_frames = 8;
    options.copy_bytes = 1u << 20;
  }
  try {
    return run(options) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-bench: %s\n", error.what());
    return 1;
  }
}
