#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "planish/core/error.h"

namespace planish {

/// Something the caller should know of although the work went on.
struct Warning {
  std::string code;         ///< stable, e.g. "unused-vertices"
  std::string message;      ///< one sentence with the remedy
  std::int64_t count = 1;   ///< how many elements it concerns
  std::int64_t first = -1;  ///< index of the first of them; -1 if none
};

/// How the library talks back. Every member may be empty. Called on the calling thread only.
struct Callbacks {
  /// What is being done, and the fraction of the whole call; it never falls and ends at 1.
  std::function<void(std::string_view step, double fraction)> progress;
  std::function<bool()> cancelled;
  std::function<void(const Warning&)> warning;

  /// Calls the member, if there is one. Should the host start a loop of its own in it, and take up
  /// a piece of the work meanwhile, nothing else is asked or told from there.
  void report(std::string_view step, double fraction) const;
  void warn(const Warning& what) const;
};

/// Asks work to stop. May be set by any thread, and by a signal handler.
using StopFlag = std::atomic<bool>;
static_assert(StopFlag::is_always_lock_free);

class LimitScope;  // callbacks.h

/// While it lives, work of the library on this thread, and on the threads that this work takes,
/// looks at the flag: every piece of a parallel loop and every few thousand steps of a serial one,
/// so after at most about 10 ms. Once it is set the work throws Error{Cancelled}. Holds for
/// whatever the library does, reading, fitting, evaluating and writing; several may be nested, and
/// each counts. The flag must outlive it. Third parties' code (OpenSubdiv's refinement) is not
/// interrupted.
class StopScope {
 public:
  explicit StopScope(const StopFlag& flag);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  friend class AdoptedStop;
  friend class LimitScope;
  friend bool stop_requested();
  StopScope(const StopFlag& flag, LimitScope* limits);
  const StopFlag& flag_;
  const StopScope* outer_;
  LimitScope* limits_;  // of this scope or one around it
};

/// Whether a flag in force on this thread is set.
[[nodiscard]] bool stop_requested();

/// Throws Error{Cancelled} where stop_requested(). Costs some nanoseconds.
void check_stop();

/// While it lives, the time of this thread is that of work with limits, but of work whose time it
/// is already.
class CountedTime {
 public:
  CountedTime(LimitScope* limits, const LimitScope* counted);
  ~CountedTime();
  CountedTime(const CountedTime&) = delete;
  CountedTime& operator=(const CountedTime&) = delete;

 private:
  LimitScope* limits_;
  std::int64_t began_ = 0;
};

/// The scopes of another thread, taken over for a task that works for it.
class AdoptedStop {
 public:
  /// What is in force on the calling thread; null if nothing.
  [[nodiscard]] static const StopScope* current();

  explicit AdoptedStop(const StopScope* scope);
  ~AdoptedStop();
  AdoptedStop(const AdoptedStop&) = delete;
  AdoptedStop& operator=(const AdoptedStop&) = delete;

 private:
  const StopScope* own_;
  CountedTime time_;
};

/// For a serial loop of short steps: looks every kInterval of them.
class StopCheck {
 public:
  void step() {
    if ((++count_ & (kInterval - 1)) == 0) check_stop();
  }

 private:
  static constexpr std::uint32_t kInterval = 4096;
  std::uint32_t count_ = 0;
};

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
