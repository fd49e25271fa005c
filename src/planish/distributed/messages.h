#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
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

}  // namespace planish
