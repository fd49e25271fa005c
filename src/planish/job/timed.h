#pragma once

#include <chrono>

namespace planish {

/// Runs `work` and adds the milliseconds it took to `total`.
template <class Work>
auto timed(double& total, const Work& work) {
  struct Stopwatch {
    double& total;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Stopwatch() {
      total += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                   .count();
    }
  } stopwatch{total};
  return work();
}

}  // namespace planish
