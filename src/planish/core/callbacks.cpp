#include "planish/core/callbacks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "planish/core/error.h"
#include "planish/core/platform/machine.h"

namespace planish {
namespace {

thread_local const StopScope* in_force = nullptr;

}  // namespace

StopScope::StopScope(const StopFlag& flag)
    : StopScope(flag, in_force != nullptr ? in_force->limits_ : nullptr) {}

StopScope::StopScope(const StopFlag& flag, LimitScope* limits)
    : flag_(flag), outer_(in_force), limits_(limits) {
  in_force = this;
}

StopScope::~StopScope() { in_force = outer_; }

bool stop_requested() {
  for (const StopScope* scope = in_force; scope != nullptr; scope = scope->outer_)
    if (scope->flag_.load(std::memory_order_relaxed)) return true;
  return false;
}

void check_stop() {
  HostWatch::look_from_thread();
  if (stop_requested()) throw Error(ErrorCode::Cancelled, "cancelled");
}

const StopScope* AdoptedStop::current() { return in_force; }

AdoptedStop::AdoptedStop(const StopScope* scope)
    : own_(in_force),
      time_(scope != nullptr ? scope->limits_ : nullptr,
            own_ != nullptr ? own_->limits_ : nullptr) {
  in_force = scope;
}

AdoptedStop::~AdoptedStop() { in_force = own_; }

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kAskInterval{5}, kTellInterval{20};

thread_local HostWatch* innermost_watch = nullptr;
thread_local int host_calls = 0;

bool is_due(Clock::time_point& last, Clock::duration interval) {
  const Clock::time_point now = Clock::now();
  if (now - last < interval) return false;
  last = now;
  return true;
}

// While a function of the host's runs.
class HostCall {
 public:
  HostCall() { ++host_calls; }
  ~HostCall() { --host_calls; }
  HostCall(const HostCall&) = delete;
  HostCall& operator=(const HostCall&) = delete;
};

}  // namespace

void Callbacks::report(std::string_view step, double fraction) const {
  if (!progress) return;
  const HostCall call;
  progress(step, fraction);
}

void Callbacks::warn(const Warning& what) const {
  if (!warning) return;
  const HostCall call;
  warning(what);
}

Callbacks share_of(const Callbacks& whole, double from, double to) {
  Callbacks part = whole;
  if (whole.progress) {
    part.progress = [progress = whole.progress, from, to](std::string_view step, double fraction) {
      progress(step, std::lerp(from, to, fraction));
    };
  }
  return part;
}

HostWatch::HostWatch() : outer_(innermost_watch), depth_(host_calls) { innermost_watch = this; }

HostWatch::~HostWatch() { innermost_watch = outer_; }

void HostWatch::look_from_thread() {
  for (HostWatch* watch = innermost_watch; watch != nullptr && watch->depth_ == host_calls;
       watch = watch->outer_)
    watch->look();
}

void HostScope::look() {
  if (!callbacks_.cancelled || !is_due(last_, kAskInterval)) return;
  const HostCall call;
  if (callbacks_.cancelled()) asked_ = true;
}

LoopProgress::LoopProgress(const Callbacks& callbacks, std::string_view step, double from,
                           double to, std::int64_t count)
    : callbacks_(callbacks), step_(step), from_(from), to_(to), count_(count), last_(Clock::now()) {
  callbacks_.report(step_, from_);
}

void LoopProgress::look() {
  if (!callbacks_.progress || !is_due(last_, kTellInterval)) return;
  const std::int64_t done = std::min(done_.load(std::memory_order_relaxed), count_);
  if (done <= told_) return;
  told_ = done;
  callbacks_.report(step_,
                    std::lerp(from_, to_, static_cast<double>(done) / static_cast<double>(count_)));
}

LimitScope::LimitScope(const WorkLimits& limits)
    : limits_(limits), stop_(is_over_, this), began_(platform::thread_nanoseconds()) {}

LimitScope* LimitScope::current() {
  const StopScope* const scope = AdoptedStop::current();
  return scope != nullptr ? scope->limits_ : nullptr;
}

void LimitScope::look() {
  constexpr std::chrono::milliseconds kInterval{5};
  if (limits_.cpu_seconds <= 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < kInterval) return;
  last_ = now;
  const auto taken = static_cast<double>(platform::thread_nanoseconds() - began_ +
                                         others_.load(std::memory_order_relaxed));
  if (taken > 1e9 * limits_.cpu_seconds) is_over_ = true;
}

void LimitScope::add_output(std::uint64_t bytes) {
  if (limits_.output_bytes == 0) return;
  const std::uint64_t all = written_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  if (all <= limits_.output_bytes) return;
  throw Error(ErrorCode::UnwritableOutput,
              formatted("the files have more than the {} that they may; take a coarser level or "
                        "allow more",
                        byte_size(limits_.output_bytes)));
}

CountedTime::CountedTime(LimitScope* limits, const LimitScope* counted)
    : limits_(limits == counted || limits == nullptr || limits->limits_.cpu_seconds <= 0 ? nullptr
                                                                                         : limits) {
  if (limits_ != nullptr) began_ = platform::thread_nanoseconds();
}

CountedTime::~CountedTime() {
  if (limits_ != nullptr)
    limits_->others_.fetch_add(platform::thread_nanoseconds() - began_, std::memory_order_relaxed);
}

}  // namespace planish
