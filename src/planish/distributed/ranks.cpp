#include "planish/distributed/ranks.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/platform/machine.h"

namespace planish {
namespace {

template <class T>
T reduced(const Ranks& ranks, T value, MPI_Datatype type, MPI_Op operation) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, operation, ranks.comm);
  return value;
}

// No ErrorCode: a fault of our own.
constexpr int kInternal = 1000;
constexpr int kNoFault = 2000;

struct Fault {
  int code = kNoFault;
  std::string message;
  std::int64_t element = Error::kNoElement;
};

Fault fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception&) {
    const Failure failure = current_failure("memory does not suffice; take more ranks");
    return {failure.code ? static_cast<int>(*failure.code) : kInternal, failure.message,
            failure.element};
  }
  return {};
}

}  // namespace

Ranks::Ranks(MPI_Comm communicator) : comm(communicator) {
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
}

std::int64_t sum_over(const Ranks& ranks, std::int64_t value) {
  return reduced(ranks, value, MPI_INT64_T, MPI_SUM);
}
std::int64_t max_over(const Ranks& ranks, std::int64_t value) {
  return reduced(ranks, value, MPI_INT64_T, MPI_MAX);
}
std::int64_t min_over(const Ranks& ranks, std::int64_t value) {
  return reduced(ranks, value, MPI_INT64_T, MPI_MIN);
}
double max_over(const Ranks& ranks, double value) {
  return reduced(ranks, value, MPI_DOUBLE, MPI_MAX);
}
double min_over(const Ranks& ranks, double value) {
  return reduced(ranks, value, MPI_DOUBLE, MPI_MIN);
}

std::int64_t sum_before(const Ranks& ranks, std::int64_t value) {
  std::int64_t sum = 0;
  MPI_Exscan(&value, &sum, 1, MPI_INT64_T, MPI_SUM, ranks.comm);
  return ranks.rank == 0 ? 0 : sum;  // MPI leaves the first rank's undefined
}

Layout layout_of(const Ranks& ranks, std::int64_t count) {
  Layout layout(static_cast<std::size_t>(ranks.size) + 1, 0);
  MPI_Allgather(&count, 1, MPI_INT64_T, layout.data() + 1, 1, MPI_INT64_T, ranks.comm);
  std::partial_sum(layout.begin(), layout.end(), layout.begin());
  return layout;
}

Layout even_layout(std::int64_t total, int parts) {
  Layout layout(static_cast<std::size_t>(parts) + 1);
  for (int p = 0; p <= parts; ++p)
    layout[p] = total / parts * p + std::min<std::int64_t>(p, total % parts);
  return layout;
}

int owner_of(const Layout& layout, std::int64_t number) {
  return static_cast<int>(std::ranges::upper_bound(layout, number) - layout.begin()) - 1;
}

void agree(const Ranks& ranks, const std::function<void()>& work) {
  const Fault fault = fault_of(work);
  const int first =
      reduced(ranks, fault.code == kNoFault ? ranks.size : ranks.rank, MPI_INT, MPI_MIN);
  if (first == ranks.size) return;
  std::int64_t facts[3] = {fault.code, fault.element,
                           static_cast<std::int64_t>(fault.message.size())};
  MPI_Bcast(facts, 3, MPI_INT64_T, first, ranks.comm);
  std::string message = ranks.rank == first ? fault.message : std::string(facts[2], ' ');
  MPI_Bcast(message.data(), static_cast<int>(facts[2]), MPI_CHAR, first, ranks.comm);
  if (facts[0] == kInternal) throw std::runtime_error(message);
  throw AgreedError(static_cast<ErrorCode>(facts[0]), message, facts[1]);
}

std::vector<std::int64_t> exchange_counts(const Ranks& ranks,
                                          std::span<const std::int64_t> counts) {
  std::vector<std::int64_t> received(counts.size());
  MPI_Alltoall(counts.data(), 1, MPI_INT64_T, received.data(), 1, MPI_INT64_T, ranks.comm);
  return received;
}

void exchange_bytes(const Ranks& ranks, const std::byte* from, std::span<const std::int64_t> sent,
                    std::byte* to, std::span<const std::int64_t> received,
                    std::size_t element_bytes, std::size_t round_bytes) {
  const auto size = static_cast<std::size_t>(ranks.size);
  const auto own = static_cast<std::size_t>(ranks.rank);
  std::vector<std::int64_t> send_at(size), receive_at(size);
  std::exclusive_scan(sent.begin(), sent.end(), send_at.begin(), std::int64_t{0});
  std::exclusive_scan(received.begin(), received.end(), receive_at.begin(), std::int64_t{0});
  if (sent[own] > 0) {
    std::memcpy(to + receive_at[own] * element_bytes, from + send_at[own] * element_bytes,
                sent[own] * element_bytes);
  }
  if (size == 1) return;
  std::int64_t largest = 0, out = 0, in = 0;
  for (std::size_t r = 0; r < size; ++r) {
    if (r == own) continue;
    largest = std::max(largest, sent[r]);
    out += sent[r];
    in += received[r];
  }
  const auto limit =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(round_bytes / element_bytes / size));
  // All in one round where no rank's share is too large.
  const std::int64_t most = max_over(ranks, std::max(out, in));
  const bool is_small = most <= static_cast<std::int64_t>(round_bytes / element_bytes);
  const std::int64_t step = is_small ? most : limit;
  const std::int64_t rounds = is_small ? 1 : max_over(ranks, (largest + limit - 1) / limit);
  MPI_Datatype element;
  MPI_Type_contiguous(static_cast<int>(element_bytes), MPI_BYTE, &element);
  MPI_Type_commit(&element);
  std::vector<int> send_counts(size), receive_counts(size), send_from(size), receive_to(size);
  RawVector<std::byte> out_bytes, in_bytes;
  for (std::int64_t round = 0; round < rounds; ++round) {
    std::int64_t out_total = 0, in_total = 0;
    for (std::size_t r = 0; r < size; ++r) {
      const auto piece = [&](std::int64_t count) {
        return r == own ? 0 : std::clamp<std::int64_t>(count - round * step, 0, step);
      };
      send_counts[r] = static_cast<int>(piece(sent[r]));
      receive_counts[r] = static_cast<int>(piece(received[r]));
      send_from[r] = static_cast<int>(out_total);
      receive_to[r] = static_cast<int>(in_total);
      out_total += send_counts[r];
      in_total += receive_counts[r];
    }
    out_bytes.resize(static_cast<std::size_t>(out_total) * element_bytes);
    in_bytes.resize(static_cast<std::size_t>(in_total) * element_bytes);
    for (std::size_t r = 0; r < size; ++r)
      if (send_counts[r] > 0)
        std::memcpy(out_bytes.data() + send_from[r] * element_bytes,
                    from + (send_at[r] + round * step) * element_bytes,
                    send_counts[r] * element_bytes);
    MPI_Alltoallv(out_bytes.data(), send_counts.data(), send_from.data(), element, in_bytes.data(),
                  receive_counts.data(), receive_to.data(), element, ranks.comm);
    for (std::size_t r = 0; r < size; ++r)
      if (receive_counts[r] > 0)
        std::memcpy(to + (receive_at[r] + round * step) * element_bytes,
                    in_bytes.data() + receive_to[r] * element_bytes,
                    receive_counts[r] * element_bytes);
  }
  MPI_Type_free(&element);
}

void broadcast_bytes(const Ranks& ranks, std::span<std::byte> bytes, int root,
                     std::size_t round_bytes) {
  for (std::size_t begin = 0; begin < bytes.size(); begin += round_bytes) {
    const std::size_t count = std::min(round_bytes, bytes.size() - begin);
    MPI_Bcast(bytes.data() + begin, static_cast<int>(count), MPI_BYTE, root, ranks.comm);
  }
}

void exchange_with_peers(const Ranks& ranks, const std::byte* from,
                         std::span<const std::int64_t> sent, std::byte* to,
                         std::span<const std::int64_t> received, std::size_t element_bytes) {
  constexpr int kTag = 1;
  MPI_Datatype element;
  MPI_Type_contiguous(static_cast<int>(element_bytes), MPI_BYTE, &element);
  MPI_Type_commit(&element);
  std::vector<MPI_Request> requests;
  const std::byte* own = from;
  std::byte* own_place = to;
  for (int r = 0; r < ranks.size; ++r) {
    const auto count = static_cast<int>(received[r]);
    if (r == ranks.rank) {
      own_place = to;
    } else if (count > 0) {
      MPI_Irecv(to, count, element, r, kTag, ranks.comm, &requests.emplace_back());
    }
    to += static_cast<std::size_t>(received[r]) * element_bytes;
  }
  for (int r = 0; r < ranks.size; ++r) {
    const auto count = static_cast<int>(sent[r]);
    if (r == ranks.rank) {
      own = from;
    } else if (count > 0) {
      MPI_Isend(from, count, element, r, kTag, ranks.comm, &requests.emplace_back());
    }
    from += static_cast<std::size_t>(sent[r]) * element_bytes;
  }
  const std::size_t own_bytes = static_cast<std::size_t>(sent[ranks.rank]) * element_bytes;
  if (own_bytes > 0) std::memcpy(own_place, own, own_bytes);
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  MPI_Type_free(&element);
}

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
  phases_.back().peak_bytes = static_cast<std::int64_t>(platform::peak_memory());
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
      std::_Exit(1);
    }
    last = now;
  }
}

}  // namespace planish
