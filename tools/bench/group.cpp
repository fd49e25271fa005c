#include "bench/group.h"

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <map>
#include <utility>

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

}  // namespace planish::bench
