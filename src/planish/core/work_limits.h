#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "planish/core/host_scope.h"
#include "planish/core/stop.h"

namespace planish {

/// What a piece of work may take, for hosts that run the work of others; 0: anything.
struct WorkLimits {
  std::uint64_t memory_bytes = 0;  ///< that a step is known to need before it begins
  double cpu_seconds = 0;          ///< of all its threads, but for third parties' code on others
  std::int64_t points = 0;         ///< vertices or points of an input
  std::uint64_t output_bytes = 0;  ///< of all its files together
};

/// Limits in force on this thread and on the threads that its work takes, as those of a StopScope:
/// memory counts wherever what is free does, files where they are written. Once the time is over
/// the work throws Error{Cancelled}. Limits around it do not count while it lives.
class LimitScope final : HostWatch {
 public:
  explicit LimitScope(const WorkLimits& limits);

  [[nodiscard]] const WorkLimits& limits() const { return limits_; }
  /// Whether the work was stopped since its time is over.
  [[nodiscard]] bool is_time_over() const { return is_over_.load(std::memory_order_relaxed); }

  /// The scope in force on the calling thread; null: there is none.
  [[nodiscard]] static LimitScope* current();

  /// Throws Error{UnwritableOutput} where the files of the work would have more bytes than they
  /// may.
  void add_output(std::uint64_t bytes);

 private:
  friend class CountedTime;
  void look() override;

  WorkLimits limits_;
  StopFlag is_over_ = false;
  StopScope stop_;
  std::int64_t began_;                    // processor time of the thread that made it
  std::atomic<std::int64_t> others_ = 0;  // of the other threads, nanoseconds
  std::atomic<std::uint64_t> written_ = 0;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace planish
