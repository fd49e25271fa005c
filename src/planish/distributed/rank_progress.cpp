#include "planish/distributed/rank_progress.h"

#include <algorithm>
#include <utility>

namespace planish {

RankProgress::RankProgress(const Ranks& ranks, double interval_seconds, Show show)
    : job_comm_(ranks.comm),
      is_first_(ranks.rank == 0),
      interval_(interval_seconds),
      last_(std::chrono::steady_clock::now()),
      show_(std::move(show)) {
  MPI_Comm_dup(ranks.comm, &comm_);
}

void RankProgress::begin(std::string_view phase, std::int64_t units) {
  phase_ = static_cast<std::size_t>(std::ranges::find(kPhases, phase) - std::begin(kPhases));
  units_ = std::max<std::int64_t>(units, 1);
  done_ = 0;
  own_[phase_] = 0;
  own_[kPhaseCount + phase_] = units_;
  shown_ = 0;
  if (is_first_) show_(phase, 0);
  look();
}

void RankProgress::step() {
  ++done_;
  // MPI is for the thread that began it.
  if (std::this_thread::get_id() == thread_) look();
}

void RankProgress::end() {
  done_ = units_;
  look();
}

void RankProgress::look() {
  // What is done twice, after a change of plan, is not more than all.
  own_[phase_] = std::min(done_.load(), units_);
  if (request_ != MPI_REQUEST_NULL) {
    int is_done = 0;
    MPI_Test(&request_, &is_done, MPI_STATUS_IGNORE);
    if (is_done == 0) return;
    show_sum();
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < interval_) return;
  last_ = now;
  begin_sum();
}

void RankProgress::begin_sum() {
  ++sum_count_;
  sent_ = own_;
  MPI_Ireduce(sent_.data(), sum_.data(), static_cast<int>(sent_.size()), MPI_INT64_T, MPI_SUM, 0,
              comm_, &request_);
}

void RankProgress::show_sum() {
  if (!is_first_) return;
  const std::int64_t all = sum_[kPhaseCount + phase_];
  if (all == 0) return;  // of a phase before
  // Ranks that have not begun the phase yet add units later: what was shown stays.
  shown_ = std::max(shown_, static_cast<double>(sum_[phase_]) / static_cast<double>(all));
  show_(kPhases[phase_], shown_);
}

void RankProgress::finish() {
  if (comm_ == MPI_COMM_NULL) return;
  // Ranks have begun different counts of sums; all are to meet. Not on the sums' communicator,
  // where this would be another rank's sum by its order.
  std::int64_t most = sum_count_;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, job_comm_);
  // Begun by look(), or none.  NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker)
  MPI_Wait(&request_, MPI_STATUS_IGNORE);
  while (sum_count_ < most) {
    begin_sum();
    MPI_Wait(&request_, MPI_STATUS_IGNORE);
  }
  MPI_Comm_free(&comm_);
}

}  // namespace planish
