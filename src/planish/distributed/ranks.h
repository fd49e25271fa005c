#pragma once

#include <mpi.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/raw_vector.h"

namespace planish {

/// The processes of one job, which all call the functions below together.
struct Ranks {
  explicit Ranks(MPI_Comm communicator);

  MPI_Comm comm;
  int rank = 0, size = 1;
};

[[nodiscard]] std::int64_t sum_over(const Ranks& ranks, std::int64_t value);
[[nodiscard]] std::int64_t max_over(const Ranks& ranks, std::int64_t value);
[[nodiscard]] std::int64_t min_over(const Ranks& ranks, std::int64_t value);
[[nodiscard]] double max_over(const Ranks& ranks, double value);
[[nodiscard]] double min_over(const Ranks& ranks, double value);
/// The sum of the values of the ranks before this one.
[[nodiscard]] std::int64_t sum_before(const Ranks& ranks, std::int64_t value);

/// Runs of global numbers: rank r has [layout[r], layout[r + 1]).
using Layout = std::vector<std::int64_t>;
/// Of runs of this length, one a rank.
[[nodiscard]] Layout layout_of(const Ranks& ranks, std::int64_t count);
/// `total` cut into runs whose lengths differ by at most 1.
[[nodiscard]] Layout even_layout(std::int64_t total, int parts);
/// The rank whose run holds a number below the total.
[[nodiscard]] int owner_of(const Layout& layout, std::int64_t number);

/// An error that every rank throws at the same place, so that all can leave in order.
class AgreedError : public Error {
 public:
  using Error::Error;
};

/// Runs `work`, which must not talk to other ranks, on every rank. Where it threw on some, all
/// throw AgreedError with code and message of the lowest of them; std::bad_alloc counts as
/// Error{OutOfMemory}, any other exception is thrown on all as std::runtime_error.
void agree(const Ranks& ranks, const std::function<void()>& work);

/// MPI counts in `int`: what is larger than this goes in several rounds.
inline constexpr std::size_t kRoundBytes = std::size_t{1} << 30;

/// How many elements each rank sends here. One count a rank.
[[nodiscard]] std::vector<std::int64_t> exchange_counts(const Ranks& ranks,
                                                        std::span<const std::int64_t> counts);
/// `from` holds the elements for rank 0, rank 1, ...; `to` those from rank 0, rank 1, ...
void exchange_bytes(const Ranks& ranks, const std::byte* from, std::span<const std::int64_t> sent,
                    std::byte* to, std::span<const std::int64_t> received,
                    std::size_t element_bytes, std::size_t round_bytes = kRoundBytes);

/// The same where most counts are 0 and none is above 2^31 - 1, as in a halo: messages to and from
/// those with a count alone.
void exchange_with_peers(const Ranks& ranks, const std::byte* from,
                         std::span<const std::int64_t> sent, std::byte* to,
                         std::span<const std::int64_t> received, std::size_t element_bytes);

/// The elements from rank 0, rank 1, ...; `send` holds `counts[r]` for each rank r.
template <class T>
[[nodiscard]] RawVector<T> all_to_all(const Ranks& ranks, std::span<const T> send,
                                      std::span<const std::int64_t> counts,
                                      std::vector<std::int64_t>* received = nullptr) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<std::int64_t> incoming = exchange_counts(ranks, counts);
  const std::int64_t total = std::accumulate(incoming.begin(), incoming.end(), std::int64_t{0});
  RawVector<T> result(static_cast<std::size_t>(total));
  exchange_bytes(ranks, reinterpret_cast<const std::byte*>(send.data()), counts,
                 reinterpret_cast<std::byte*>(result.data()), incoming, sizeof(T));
  if (received != nullptr) *received = std::move(incoming);
  return result;
}

/// The elements of rank 0, then those of rank 1, ...: on rank 0; empty on all others.
template <class T>
[[nodiscard]] RawVector<T> gather(const Ranks& ranks, std::span<const T> own) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.size), 0);
  counts[0] = std::ssize(own);
  return all_to_all<T>(ranks, own, counts);
}

/// The bytes of rank `root` to all others, however many they are.
void broadcast_bytes(const Ranks& ranks, std::span<std::byte> bytes, int root,
                     std::size_t round_bytes = kRoundBytes);

/// The elements of rank 0, then those of rank 1, ...: on all ranks. Takes memory for the result
/// alone, however many ranks there are.
template <class T>
[[nodiscard]] RawVector<T> all_gather(const Ranks& ranks, std::span<const T> own) {
  static_assert(std::is_trivially_copyable_v<T>);
  const Layout layout = layout_of(ranks, std::ssize(own));
  RawVector<T> result(static_cast<std::size_t>(layout.back()));
  std::ranges::copy(own, result.begin() + layout[ranks.rank]);
  for (int r = 0; r < ranks.size; ++r)
    broadcast_bytes(
        ranks,
        std::as_writable_bytes(std::span(result).subspan(layout[r], layout[r + 1] - layout[r])), r);
  return result;
}

/// Each item to rank_of(item, its place); those from one rank arrive in their order, ranks in
/// theirs.
template <class T, class RankOf>
[[nodiscard]] RawVector<T> route(const Ranks& ranks, std::span<const T> items,
                                 const RankOf& rank_of) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.size), 0);
  std::vector<std::int32_t> targets(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    targets[i] = rank_of(items[i], i);
    ++counts[targets[i]];
  }
  std::vector<std::int64_t> places(counts.size(), 0);
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), std::int64_t{0});
  RawVector<T> send(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) send[places[targets[i]]++] = items[i];
  return all_to_all<T>(ranks, send, counts);
}

/// value_of(place in the owner's run) of ascending global numbers, from their owners.
template <class Value, class ValueOf>
[[nodiscard]] RawVector<Value> fetch(const Ranks& ranks, std::span<const std::int64_t> numbers,
                                     const Layout& layout, const ValueOf& value_of) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.size), 0), asked;
  for (const std::int64_t number : numbers) ++counts[owner_of(layout, number)];
  const RawVector<std::int64_t> wanted = all_to_all<std::int64_t>(ranks, numbers, counts, &asked);
  RawVector<Value> reply(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    reply[i] = value_of(wanted[i] - layout[ranks.rank]);
  return all_to_all<Value>(ranks, reply, asked);
}

/// The parts of a job in their order.
inline constexpr std::string_view kPhases[] = {"read", "sort",  "faces", "rings",
                                               "rows", "solve", "tiles", "write"};

/// Tells rank 0 how far all ranks are: each counts its units of work, and one sum over all ranks is
/// under way at a time, begun by each at most once an interval, which nobody waits for.
class RankProgress {
 public:
  /// Of a phase, 0 to 1. Called on rank 0, in the thread that made the progress.
  using Show = std::function<void(std::string_view phase, double fraction)>;

  /// All ranks together.
  RankProgress(const Ranks& ranks, double interval_seconds, Show show);
  RankProgress(const RankProgress&) = delete;
  RankProgress& operator=(const RankProgress&) = delete;

  /// This rank begins one of kPhases, of so many units.
  void begin(std::string_view phase, std::int64_t units);
  /// A unit is done; any thread.
  void step();
  /// All units of the phase are done.
  void end();
  /// All ranks together, after the job: ends what is under way. Without it nothing is freed, for
  /// ranks that leave by an error of their own meet no others.
  void finish();

  /// Sums that this rank began.
  [[nodiscard]] std::int64_t sum_count() const { return sum_count_; }

 private:
  static constexpr std::size_t kPhaseCount = std::size(kPhases);
  using Figures = std::array<std::int64_t, 2 * kPhaseCount>;  // done, then all, by phase

  void look();
  void begin_sum();
  void show_sum();

  MPI_Comm job_comm_;
  MPI_Comm comm_ = MPI_COMM_NULL;  // of its own: sums match by their order
  bool is_first_ = false;
  std::chrono::duration<double> interval_;
  std::chrono::steady_clock::time_point last_;
  Show show_;
  std::thread::id thread_ = std::this_thread::get_id();
  std::size_t phase_ = 0;
  std::int64_t units_ = 0;
  double shown_ = 0;  // of the phase
  std::atomic<std::int64_t> done_{0};
  Figures own_{}, sent_{}, sum_{};
  MPI_Request request_ = MPI_REQUEST_NULL;
  std::int64_t sum_count_ = 0;
};

/// What a phase took on this rank.
struct PhaseFigures {
  std::string_view name;
  double seconds = 0;
  std::int64_t peak_bytes = 0;  ///< of the process so far
};

/// Follows one rank's job: times, memory, and signs of life. Where there is none for too long, for
/// another rank hangs or a file system does, the process ends with a message, and mpirun ends the
/// others.
class RankWatch {
 public:
  /// 0 seconds: nothing is watched. `progress`: is told of phases and signs of life; may be null.
  explicit RankWatch(int rank, double watchdog_seconds = 0, RankProgress* progress = nullptr);
  ~RankWatch();
  RankWatch(const RankWatch&) = delete;
  RankWatch& operator=(const RankWatch&) = delete;

  /// Ends the phase before, and begins one of kPhases, which gives so many signs of life.
  void begin(std::string_view phase, std::int64_t ticks = 1);
  void end();
  /// A sign of life, from any thread.
  void tick() {
    ++ticks_;
    if (progress_ != nullptr) progress_->step();
  }
  /// In builds for tests: where PLANISH_MPI_FAULT is "rank:phase" of this place, the process kills
  /// itself, and stops with "rank:phase:stop".
  void fault_point() const;

  [[nodiscard]] const std::vector<PhaseFigures>& phases() const { return phases_; }

 private:
  void watch(double seconds);

  int rank_;
  RankProgress* progress_;
  std::vector<PhaseFigures> phases_;
  std::chrono::steady_clock::time_point begun_;
  bool in_phase_ = false;
  std::atomic<std::int64_t> ticks_{0};
  std::atomic<const char*> phase_now_{"start"};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace planish
