#pragma once

#include <atomic>
#include <cstdint>

namespace planish {

/// Asks work to stop. May be set by any thread, and by a signal handler.
using StopFlag = std::atomic<bool>;
static_assert(StopFlag::is_always_lock_free);

class LimitScope;  // work_limits.h

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

}  // namespace planish
