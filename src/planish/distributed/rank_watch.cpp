#include "planish/distributed/rank_watch.h"

#include "planish/core/formatted.h"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace planish {

RankWatch::RankWatch(int rank, double watchdog_seconds, RankProgress* progress)
    : rank_(rank), progress_(progress) {
  if (watchdog_seconds > 0)
    thread_ = std::thread([this, watchdog_seconds] { watch(watchdog_seconds); });
}

RankWatch::~RankWatch() {
  {
    const std::scoped_lock lock(mutex_);
    is_over_ = true;
  }
  ended_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void RankWatch::begin(std::string_view phase, std::int64_t ticks) {
  end();
  ++ticks_;
  phases_.push_back({phase});
  phase_now_ = phase.data();
  begun_ = std::chrono::steady_clock::now();
  in_phase_ = true;
  if (progress_ != nullptr) progress_->begin(phase, ticks);
}

void RankWatch::end() {
  if (!in_phase_) return;
  ++ticks_;
  if (progress_ != nullptr) progress_->end();
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begun_;
  phases_.back().seconds = time.count();
  phases_.back().peak_bytes = peak_bytes();
  in_phase_ = false;
}

void RankWatch::fault_point() const {
#ifdef PLANISH_MPI_FAULTS
  const char* wanted = std::getenv("PLANISH_MPI_FAULT");
  if (wanted == nullptr || phases_.empty()) return;
  const std::string here = formatted("{}:{}", rank_, phases_.back().name);
  if (here == wanted) std::raise(SIGKILL);
  if (here + ":stop" == wanted) std::raise(SIGSTOP);
#endif
}

void RankWatch::watch(double seconds) {
  std::int64_t last = ticks_;
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return is_over_; })) {
    const std::int64_t now = ticks_;
    if (now == last) {
      std::fprintf(stderr,
                   "planish-mpi: rank %d has come no further for %g s in phase %s; another rank or "
                   "the file system hangs (--watchdog sets the time)\n",
                   rank_, seconds, phase_now_.load());
      std::fflush(stderr);
      // No MPI_Abort: the thread that talks to MPI stands inside it.
      _exit(1);
    }
    last = now;
  }
}

std::int64_t peak_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace planish
