#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <string>
#include <thread>
#include <utility>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {

// "at most about 340.0 MiB".
inline double forecast_memory(const std::string& text) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex("memory +at most about ([0-9.]+) (MiB|GiB)")))
    return -1;
  return std::stod(found[1]) * (found[2] == "GiB" ? 1024.0 : 1.0) * 1024 * 1024;
}

// The ends of "4 to 36 s".
inline std::pair<double, double> forecast_seconds(const std::string& text) {
  std::smatch found;
  if (std::regex_search(text, found, std::regex("time +([0-9]+) to ([0-9]+) s")))
    return {std::stod(found[1]), std::stod(found[2])};
  if (std::regex_search(text, found, std::regex("time +under ([0-9]+) s")))
    return {0, std::stod(found[1])};
  return {0, -1};
}

class Needs : public FolderTest {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers hold memory of their own";
#endif
  }
  // What is said of a fit holds, and is not far off; seconds by their order of magnitude.
  // `is_near`: memory is not far off, either.
  void expect_enough(const std::string& flags, bool is_near = true) {
    const std::string line = "fit " + flags + " -f", text = run(line + " --dry-run").out;
    SCOPED_TRACE(line + "\n" + text);
    const ProcessResult done = run(line, 0, {.measured = true});
    constexpr double kStart = 20 << 20;  // what any run takes
    EXPECT_LE(done.peak_bytes, forecast_memory(text));
    if (is_near) {
      EXPECT_GE(2.5 * done.peak_bytes + kStart, forecast_memory(text));
    }
    const auto [least, most] = forecast_seconds(text);
    const double threads = std::max(1u, std::thread::hardware_concurrency());
    EXPECT_LE(done.cpu_seconds / threads, 3 * most);
    EXPECT_GE(3 * done.cpu_seconds, least);
  }
};

}  // namespace planish::test
