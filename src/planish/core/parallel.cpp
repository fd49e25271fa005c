#include "planish/core/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_group.h>

#include "planish/core/callbacks.h"

namespace planish {

void run_loop(std::size_t count, std::size_t grain, LoopBody body) {
  if (count <= grain) {
    check_stop();
    if (count > 0) body.call(body.object, 0, count);
    return;
  }
  const StopScope* const stop = AdoptedStop::current();
  // Where a loop around this one ends by an error, TBB would leave pieces of this one out without a
  // word, and what follows in its body would take what they have not written.
  oneapi::tbb::task_group_context whole(oneapi::tbb::task_group_context::isolated);
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<std::size_t>(0, count, grain),
      [&](const auto& range) {
        const AdoptedStop adopted(stop);
        const std::size_t piece = stop == nullptr ? range.size() : std::max<std::size_t>(grain, 1);
        for (std::size_t begin = range.begin(); begin < range.end(); begin += piece) {
          check_stop();
          body.call(body.object, begin, std::min(begin + piece, range.end()));
        }
      },
      oneapi::tbb::auto_partitioner(), whole);
}

}  // namespace planish
