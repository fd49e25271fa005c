#include "planish/core/host_scope.h"

#include <algorithm>
#include <cmath>

namespace planish {
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

}  // namespace planish
