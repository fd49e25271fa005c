#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"

namespace planish::test {

/// Runs `action` and returns the message of the Error{code} that it must throw.
template <class Action>
std::string message_of(ErrorCode code, const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

/// A host that bears callbacks on its own thread alone, one at a time, whose fractions never fall;
/// it starts a loop of its own in each, whose waiting thread may take up pieces of the work.
class WatchingHost {
 public:
  [[nodiscard]] Callbacks callbacks() {
    Callbacks callbacks;
    callbacks.progress = [this](std::string_view step, double fraction) {
      note([&] {
        if (!(fraction >= last_ && fraction <= 1))
          complain("from " + std::to_string(last_) + " to " + std::to_string(fraction) + " at " +
                   std::string(step));
        last_ = fraction;
        ++progress_calls_;
      });
    };
    callbacks.cancelled = [this] {
      note([&] { ++cancelled_calls_; });
      return cancels_after_ >= 0 && progress_calls_ >= cancels_after_;
    };
    callbacks.warning = [this](const Warning&) { note([] {}); };
    return callbacks;
  }
  /// From then on `cancelled` answers yes.
  void cancel_after(int progress_calls) { cancels_after_ = progress_calls; }

  /// Of what was called `name`; begins anew.
  void expect_good(const std::string& name, bool is_done = true) {
    EXPECT_EQ(complaint_, "") << name;
    EXPECT_GT(progress_calls_, 0) << name;
    if (is_done) {
      EXPECT_EQ(last_, 1.0) << name;
    }
    complaint_.clear();
    last_ = 0;
    progress_calls_ = cancelled_calls_ = 0;
  }
  [[nodiscard]] int progress_calls() const { return progress_calls_; }
  [[nodiscard]] int cancelled_calls() const { return cancelled_calls_; }

 private:
  void note(const std::function<void()>& call) {
    if (++inside_ != 1) complain("two calls at once");
    if (std::this_thread::get_id() == thread_) {
      call();
      std::atomic<int> sum = 0;
      parallel_for(64, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) sum += static_cast<int>(std::sqrt(i * 1.0));
      });
    } else {
      complain("a call on another thread");
    }
    --inside_;
  }
  void complain(const std::string& what) {
    if (!is_complaining_.exchange(true)) complaint_ = what;
  }

  std::thread::id thread_ = std::this_thread::get_id();
  std::atomic<int> inside_ = 0;
  std::atomic<bool> is_complaining_ = false;
  std::string complaint_;
  double last_ = 0;
  int progress_calls_ = 0, cancelled_calls_ = 0, cancels_after_ = -1;
};

}  // namespace planish::test
