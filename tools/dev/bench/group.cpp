#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "bench/benchmarks.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"

namespace planish::bench {
namespace {

using Samples = std::vector<double>;  // wall clock, milliseconds

// Prints Google Benchmark's aggregates as usual and keeps the single runs.
class CollectingReporter : public benchmark::ConsoleReporter {
 public:
  CollectingReporter() : ConsoleReporter(OO_Tabular) {}

  bool ReportContext(const Context& context) override {
    static bool first = true;  // one heading for all groups of the process
    if (!std::exchange(first, false)) {
      name_field_width_ = context.name_field_width;
      return true;
    }
    return ConsoleReporter::ReportContext(context);
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    std::vector<Run> aggregates;
    for (const Run& run : runs) {
      if (run.run_type == Run::RT_Aggregate) {
        aggregates.push_back(run);
        continue;
      }
      samples_[run.run_name.function_name].push_back(run.GetAdjustedRealTime());
    }
    ConsoleReporter::ReportRuns(aggregates);
  }

  [[nodiscard]] const std::map<std::string, Samples>& samples() const { return samples_; }

 private:
  std::map<std::string, Samples> samples_;
};

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

double process_cpu_ms() {
  double sum = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      sum += 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
  }
  return sum;
}

Row row_of_times(const Group& group, const std::string& peer, const std::vector<double>& times_ms) {
  Row row{group.name, group.size, peer, static_cast<int>(times_ms.size())};
  row.median_ms = median(times_ms);
  if (!times_ms.empty()) row.least_ms = *std::min_element(times_ms.begin(), times_ms.end());
  return row;
}

std::vector<Row> run_group(const Group& group, int repetitions) {
  benchmark::ClearRegisteredBenchmarks();
  std::map<std::string, std::vector<double>> cpu_times;
  for (const Peer& peer : group.peers) {
    peer.run();
    const std::string name = group.name + "/" + peer.name;
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&peer, &times = cpu_times[name]](benchmark::State& state) {
                                   const double before = process_cpu_ms();
                                   for ([[maybe_unused]] const auto& iteration : state) peer.run();
                                   times.push_back(process_cpu_ms() - before);
                                 })
        ->Iterations(1)
        ->Repetitions(repetitions)
        ->MeasureProcessCPUTime()
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
  CollectingReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::ClearRegisteredBenchmarks();

  std::vector<Row> rows;
  double baseline_ms = 0;
  for (const Peer& peer : group.peers) {
    const std::string name = group.name + "/" + peer.name;
    const auto found = reporter.samples().find(name);
    if (found == reporter.samples().end()) continue;  // left out by --benchmark_filter
    const Samples& samples = found->second;
    Row row{group.name, group.size, peer.name, static_cast<int>(samples.size())};
    row.median_ms = median(samples);
    row.least_ms = *std::min_element(samples.begin(), samples.end());
    row.cpu_ms = median(cpu_times[name]);
    if (peer.name == group.baseline) baseline_ms = row.median_ms;
    rows.push_back(row);
  }
  for (Row& row : rows) row.ratio = baseline_ms > 0 ? row.median_ms / baseline_ms : 0;
  return rows;
}

void initialize_benchmark(int& argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  std::string interleave = "--benchmark_enable_random_interleaving=true";
  arguments.insert(arguments.begin() + 1, interleave.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  std::copy_n(arguments.begin(), count, argv);
  argc = count;
}

void require_agreement(std::string_view what, std::span<const glm::dvec3> actual,
                       std::span<const glm::dvec3> expected) {
  double largest = 0, difference = 0;
  bool usable = actual.size() == expected.size();
  for (std::size_t i = 0; usable && i < actual.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      usable = usable && std::isfinite(actual[i][k]);
      largest = std::max(largest, std::abs(expected[i][k]));
      difference = std::max(difference, std::abs(actual[i][k] - expected[i][k]));
    }
  }
  if (usable && difference <= kAgreement * largest) return;
  throw std::runtime_error(std::string(what) +
                           ": computes something else: " + std::to_string(actual.size()) + " of " +
                           std::to_string(expected.size()) + " points, off by " +
                           std::to_string(difference) + " of " + std::to_string(largest));
}

namespace {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(':');
    if (line.starts_with("model name") && colon + 2 < line.size()) return line.substr(colon + 2);
  }
  return "unknown";
}

// Below the row that they belong to.
void print_figures(const Row& row) {
  if (row.figures.empty()) return;
  std::printf("| | |");
  for (const auto& [name, value] : row.figures) std::printf(" %s %.6g;", name.c_str(), value);
  std::printf(" | | | |\n");
}

std::string git_commit() {
  const std::string command = "git -C '" PLANISH_SOURCE_DIR "' describe --always --dirty 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return "unknown";
  std::array<char, 128> buffer{};
  std::string text;
  while (std::fgets(buffer.data(), buffer.size(), pipe)) text += buffer.data();
  const bool succeeded = ::pclose(pipe) == 0;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return succeeded ? text : "unknown";
}

nlohmann::ordered_json json_of(const Row& row) {
  nlohmann::ordered_json json = {{"group", row.group}, {"size", row.size}, {"peer", row.peer}};
  if (!row.refused.empty()) {
    json["refused"] = row.refused;
    return json;
  }
  json["repetitions"] = row.repetitions;
  json["median_ms"] = row.median_ms;
  json["least_ms"] = row.least_ms;
  json["cpu_ms"] = row.cpu_ms;
  json["ratio"] = row.ratio;
  for (const auto& [name, value] : row.figures) json["figures"][name] = value;
  return json;
}

}  // namespace

Machine this_machine() {
  Machine machine;
  machine.cpu = cpu_model();
  machine.core_count = std::thread::hardware_concurrency();
  machine.memory_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                         static_cast<std::uint64_t>(::sysconf(_SC_PAGE_SIZE));
  ::getloadavg(&machine.load, 1);
  machine.commit = git_commit();
  return machine;
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void print_table(const Machine& machine, const std::vector<Row>& rows) {
  std::printf("\n%s, %u cores, load %.1f, commit %s\n\n", machine.cpu.c_str(), machine.core_count,
              machine.load, machine.commit.c_str());
  std::printf("| %-14s | %-26s | %10s | %10s | %10s | %7s |\n", "group", "peer", "median ms",
              "least ms", "CPU ms", "ratio");
  std::printf(
      "|----------------|----------------------------|-----------:|-----------:|-----------:|"
      "--------:|\n");
  std::string size;
  for (const Row& row : rows) {
    if (row.size != size) std::printf("| | %s | | | | |\n", row.size.c_str());
    size = row.size;
    if (!row.refused.empty()) {
      std::printf("| %-14s | %-26s | refused: %s | | | |\n", row.group.c_str(), row.peer.c_str(),
                  row.refused.c_str());
      continue;
    }
    std::printf("| %-14s | %-26s | %10.2f | %10.2f | %10.2f | %7.2f |\n", row.group.c_str(),
                row.peer.c_str(), row.median_ms, row.least_ms, row.cpu_ms, row.ratio);
    print_figures(row);
  }
  std::printf("\npeak memory of the process: %.2f GiB\n",
              static_cast<double>(peak_memory_bytes()) / (1u << 30));
}

void write_json(const std::filesystem::path& path, const Machine& machine,
                const std::vector<Row>& rows, const std::vector<Failure>& failures) {
  nlohmann::ordered_json json;
  json["version"] = PLANISH_VERSION;
  json["commit"] = machine.commit;
  json["machine"] = {{"cpu", machine.cpu},
                     {"cores", machine.core_count},
                     {"memory_bytes", machine.memory_bytes},
                     {"load", machine.load}};
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : rows) json["rows"].push_back(json_of(row));
  json["failed"] = nlohmann::ordered_json::array();
  for (const Failure& failure : failures)
    json["failed"].push_back({{"group", failure.group}, {"reason", failure.reason}});
  OutputFile file(path);
  file.write(json.dump(2) + "\n");
  file.commit();
}

}  // namespace planish::bench
