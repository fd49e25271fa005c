// Stands for that of core/parallel.cpp in programs that link it: pieces of lengths by lot, handed
// out to the threads in an order by lot. PLANISH_PIECES_SEED is where the draw begins.
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

std::mt19937 next_draw() {
  static const char* const seed = std::getenv("PLANISH_PIECES_SEED");
  static std::atomic<std::uint32_t> drawn{
      seed != nullptr ? static_cast<std::uint32_t>(std::atoi(seed)) : 1};
  return std::mt19937(drawn++);
}

std::vector<std::pair<std::size_t, std::size_t>> pieces_by_lot(std::size_t count,
                                                               std::size_t grain) {
  std::mt19937 random = next_draw();
  std::uniform_int_distribution<std::size_t> length(1, 2 * std::max<std::size_t>(grain, 1));
  std::vector<std::pair<std::size_t, std::size_t>> pieces;
  for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
    end = begin + std::min(length(random), count - begin);
    pieces.emplace_back(begin, end);
  }
  std::ranges::shuffle(pieces, random);
  return pieces;
}

}  // namespace

void run_loop(std::size_t count, std::size_t grain, LoopBody body) {
  const auto pieces = pieces_by_lot(count, grain);
  check_stop();
  const StopScope* const stop = AdoptedStop::current();
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<std::size_t>(0, pieces.size(), 1),
      [&](const auto& range) {
        const AdoptedStop adopted(stop);
        for (std::size_t p = range.begin(); p < range.end(); ++p) {
          check_stop();
          body.call(body.object, pieces[p].first, pieces[p].second);
        }
      },
      oneapi::tbb::simple_partitioner());
}

}  // namespace planish
