#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace planish {

/// A body of parallel_for() that its caller keeps. The loop takes it by this, so that its tasks are
/// compiled once for all bodies.
struct LoopBody {
  const void* object;
  void (*call)(const void* object, std::size_t begin, std::size_t end);
};

/// What parallel_for() does with it.
void run_loop(std::size_t count, std::size_t grain, LoopBody body);

/// Calls body(begin, end) on disjoint pieces of [0, count), at least `grain` long but the last,
/// on TBB's threads. Pieces vary with the thread count: body must not let results depend on them.
/// Callers limit threads with tbb::task_arena or tbb::global_control. Under a StopScope the pieces
/// are no longer than `grain`, and Error{Cancelled} ends the loop between two of them. It returns
/// when all pieces are done, or throws: an error in a loop around it leaves none of them out.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  run_loop(count, grain, {&body, [](const void* object, std::size_t begin, std::size_t end) {
                            (*static_cast<const Body*>(object))(begin, end);
                          }});
}

/// The same one by one: calls body(i) for each i in [0, count).
template <class Body>
void parallel_each(std::size_t count, std::size_t grain, const Body& body) {
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// For bodies of a few hundred cycles or less.
template <class Body>
void parallel_each(std::size_t count, const Body& body) {
  parallel_each(count, 4096, body);
}

/// Calls of_range(begin, end) for pieces of [0, count) that are `piece` long, the last as long as
/// is left, on all threads, and join(total, result) with each result in the pieces' order. Returns
/// the total: the same bits for every thread count. of_range must return the same type as `total`.
template <class Total, class OfRange, class Join>
[[nodiscard]] Total ordered_reduce(std::size_t count, std::size_t piece, Total total,
                                   const OfRange& of_range, const Join& join) {
  std::vector<Total> results((count + piece - 1) / piece);
  parallel_each(results.size(), 1, [&](std::size_t p) {
    results[p] = of_range(p * piece, std::min((p + 1) * piece, count));
  });
  for (const Total& result : results) join(total, result);
  return total;
}

}  // namespace planish
