#pragma once

#include <mpi.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string_view>
#include <thread>

#include "planish/distributed/messages.h"

namespace planish {

/// The parts of a job in their order.
inline constexpr std::string_view kPhases[] = {"read", "sort",  "faces", "rings",
                                               "rows", "solve", "tiles", "write"};

/// Tells rank 0 how far all ranks are: each counts its units of work, and one sum over all ranks is
/// under way at a time, begun by each at most once an interval, which nobody waits for.
class RankProgress {
 public:
  /// Of a phase, 0 to 1. Called on rank 0, in the thread that made the progress.
  using Show = std::function<void(std::string_view phase, double fraction)>;

  /// All ranks together.
  RankProgress(const Ranks& ranks, double interval_seconds, Show show);
  RankProgress(const RankProgress&) = delete;
  RankProgress& operator=(const RankProgress&) = delete;

  /// This rank begins one of kPhases, of so many units.
  void begin(std::string_view phase, std::int64_t units);
  /// A unit is done; any thread.
  void step();
  /// All units of the phase are done.
  void end();
  /// All ranks together, after the job: ends what is under way. Without it nothing is freed, for
  /// ranks that leave by an error of their own meet no others.
  void finish();

  /// Sums that this rank began.
  [[nodiscard]] std::int64_t sum_count() const { return sum_count_; }

 private:
  static constexpr std::size_t kPhaseCount = std::size(kPhases);
  using Figures = std::array<std::int64_t, 2 * kPhaseCount>;  // done, then all, by phase

  void look();
  void begin_sum();
  void show_sum();

  MPI_Comm job_comm_;
  MPI_Comm comm_ = MPI_COMM_NULL;  // of its own: sums match by their order
  bool is_first_ = false;
  std::chrono::duration<double> interval_;
  std::chrono::steady_clock::time_point last_;
  Show show_;
  std::thread::id thread_ = std::this_thread::get_id();
  std::size_t phase_ = 0;
  std::int64_t units_ = 0;
  double shown_ = 0;  // of the phase
  std::atomic<std::int64_t> done_{0};
  Figures own_{}, sent_{}, sum_{};
  MPI_Request request_ = MPI_REQUEST_NULL;
  std::int64_t sum_count_ = 0;
};

}  // namespace planish
