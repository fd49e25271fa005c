#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/group.h"

namespace planish::bench {

/// Where and of what the figures were measured.
struct Machine {
  std::string cpu;
  unsigned core_count = 0;
  std::uint64_t memory_bytes = 0;
  double load = 0;     ///< of the last minute, before the benchmarks: above 0.5 figures are noisy
  std::string commit;  ///< of the source tree, "-dirty" with changes; "unknown" outside git
};
[[nodiscard]] Machine this_machine();

/// Highest resident memory of this process so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory_bytes();

/// Times and ratios as a Markdown table on standard output.
void print_table(const Machine& machine, const std::vector<Row>& rows);

/// A group that ended with an error.
struct Failure {
  std::string group, reason;
};

/// The same as JSON, as bench.schema.json has it, written through OutputFile. Throws
/// Error{UnwritableOutput}.
void write_json(const std::filesystem::path& path, const Machine& machine,
                const std::vector<Row>& rows, const std::vector<Failure>& failures);

}  // namespace planish::bench
