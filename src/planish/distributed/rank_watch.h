#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "planish/distributed/rank_progress.h"

namespace planish {

/// What a phase took on this rank.
struct PhaseFigures {
  std::string_view name;
  double seconds = 0;
  std::int64_t peak_bytes = 0;  ///< of the process so far
};

/// Follows one rank's job: times, memory, and signs of life. Where there is none for too long, for
/// another rank hangs or a file system does, the process ends with a message, and mpirun ends the
/// others.
class RankWatch {
 public:
  /// 0 seconds: nothing is watched. `progress`: is told of phases and signs of life; may be null.
  explicit RankWatch(int rank, double watchdog_seconds = 0, RankProgress* progress = nullptr);
  ~RankWatch();
  RankWatch(const RankWatch&) = delete;
  RankWatch& operator=(const RankWatch&) = delete;

  /// Ends the phase before, and begins one of kPhases, which gives so many signs of life.
  void begin(std::string_view phase, std::int64_t ticks = 1);
  void end();
  /// A sign of life, from any thread.
  void tick() {
    ++ticks_;
    if (progress_ != nullptr) progress_->step();
  }
  /// In builds for tests: where PLANISH_MPI_FAULT is "rank:phase" of this place, the process kills
  /// itself, and stops with "rank:phase:stop".
  void fault_point() const;

  [[nodiscard]] const std::vector<PhaseFigures>& phases() const { return phases_; }

 private:
  void watch(double seconds);

  int rank_;
  RankProgress* progress_;
  std::vector<PhaseFigures> phases_;
  std::chrono::steady_clock::time_point begun_;
  bool in_phase_ = false;
  std::atomic<std::int64_t> ticks_{0};
  std::atomic<const char*> phase_now_{"start"};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_over_ = false;
  std::thread thread_;
};

/// The largest resident memory of this process so far, in bytes; 0 where the system does not say.
[[nodiscard]] std::int64_t peak_bytes();

}  // namespace planish
