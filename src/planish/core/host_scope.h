#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/core/stop.h"

namespace planish {

/// For a part of the work: its 0 to 1 is told as `from` to `to` of the whole, whose last step is
/// told as 1 to the bit.
[[nodiscard]] Callbacks share_of(const Callbacks& whole, double from, double to);

/// Callbacks for rounds of which nobody knows how many will come: each takes `share` of what is
/// left of the work. `whole` must outlive it.
class RoundParts {
 public:
  RoundParts(const Callbacks& whole, double share) : whole_(whole), share_(share) {}

  [[nodiscard]] Callbacks next() {
    const double from = done_;
    done_ += share_ * (1 - done_);
    return share_of(whole_, from, done_);
  }

 private:
  const Callbacks& whole_;
  double share_, done_ = 0;
};

/// What looks after the host wherever the thread that made it comes to a check_stop(), so in every
/// loop of the work, whatever calls what. Not from within a function of the host's: that may start
/// a loop of its own and take up pieces of the work while it waits.
class HostWatch {
 public:
  HostWatch(const HostWatch&) = delete;
  HostWatch& operator=(const HostWatch&) = delete;

  /// For check_stop().
  static void look_from_thread();

 protected:
  HostWatch();
  ~HostWatch();
  virtual void look() = 0;

 private:
  HostWatch* outer_;
  int depth_;
};

/// Stands at the head of every function that takes callbacks. While it lives `cancelled` is asked,
/// but not more often than every few milliseconds; true stops the work on all its threads. The
/// callbacks must outlive it.
class HostScope final : HostWatch {
 public:
  explicit HostScope(const Callbacks& callbacks) : callbacks_(callbacks), stop_(asked_) {}

 private:
  void look() override;

  // Mutable, for scopes are constants.
  const Callbacks& callbacks_;
  mutable StopFlag asked_ = false;
  StopScope stop_;
  mutable std::chrono::steady_clock::time_point last_{};
};

/// How far a loop on many threads is: they count, and the thread that made it tells, every few
/// hundredths of a second. The callbacks must outlive it.
class LoopProgress final : HostWatch {
 public:
  /// Of `count` steps, from the fraction `from` of the work to `to`; `from` is told at once.
  LoopProgress(const Callbacks& callbacks, std::string_view step, double from, double to,
               std::int64_t count);

  /// On any thread.
  void add(std::int64_t steps = 1) { done_.fetch_add(steps, std::memory_order_relaxed); }

 private:
  void look() override;

  const Callbacks& callbacks_;
  std::string step_;
  double from_, to_;
  std::int64_t count_, told_ = 0;
  std::atomic<std::int64_t> done_ = 0;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace planish
