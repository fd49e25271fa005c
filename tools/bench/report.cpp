#include "bench/report.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <thread>

#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"

namespace planish::bench {

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
