#pragma once

#include <functional>
#include <string>
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
};

/// Runs every peer once to warm up, then `repetitions` times each in one process, in random order
/// (Google Benchmark's interleaving), so that what disturbs the machine disturbs all alike.
[[nodiscard]] std::vector<Row> run_group(const Group& group, int repetitions);

}  // namespace planish::bench
