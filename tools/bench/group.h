#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace planish::bench {

/// One way to do a piece of work. `run` does it once.
struct Peer {
  std::string name;
  std::function<void()> run;
};

/// Ways to do the same work. Ratios are relative to the peer named `baseline`.
struct Group {
  std::string name;  ///< no spaces or slashes
  std::string size;  ///< what it ran on, for the reader
  std::string baseline;
  std::vector<Peer> peers;
};

struct Row {
  std::string group, size, peer;
  int repetitions = 0;
  double median_ms = 0, least_ms = 0;  ///< wall clock
  double cpu_ms = 0;                   ///< median CPU time of the process and of those it started
  double ratio = 0;                    ///< median relative to the baseline's
  /// What else was counted or measured, by the names that details.md and bench.schema.json explain.
  std::vector<std::pair<std::string, double>> figures;
  std::string refused;  ///< why there are no figures: what the device lacks, with its limit
};

/// Of times in milliseconds; 0 of none.
[[nodiscard]] double median(std::vector<double> values);
/// CPU time of all threads of this process and of the children that it has waited for.
[[nodiscard]] double process_cpu_ms();

/// A row of times that somebody else took.
[[nodiscard]] Row row_of_times(const Group& group, const std::string& peer,
                               const std::vector<double>& times_ms);

/// Takes Google Benchmark's flags out of a program's, before run_group(). Runs are interleaved.
void initialize_benchmark(int& argc, char** argv);

/// Runs every peer once to warm up, then `repetitions` times each in one process, in random order
/// (Google Benchmark's interleaving), so that what disturbs the machine disturbs all alike.
[[nodiscard]] std::vector<Row> run_group(const Group& group, int repetitions);

}  // namespace planish::bench
