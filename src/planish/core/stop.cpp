#include "planish/core/stop.h"

#include "planish/core/error.h"
#include "planish/core/host_scope.h"

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

}  // namespace planish
