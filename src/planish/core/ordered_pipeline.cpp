#include "planish/core/ordered_pipeline.h"

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include "planish/core/callbacks.h"

namespace planish {

void ordered_pipeline(std::size_t count, std::size_t slots, const PieceStep& make,
                      std::span<const PieceStep> takers) {
  namespace tbb = oneapi::tbb;
  std::size_t next = 0;
  const StopScope* const stop = AdoptedStop::current();
  tbb::filter<void, std::size_t> chain =
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                          [&](tbb::flow_control& control) -> std::size_t {
                                            if (next == count) control.stop();
                                            return next++;
                                          }) &
      tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, [&](std::size_t i) {
        const AdoptedStop adopted(stop);
        check_stop();
        make(i, i % slots);
        return i;
      });
  for (const PieceStep& take : takers) {
    chain = chain & tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::serial_in_order,
                                                               [&](std::size_t i) {
                                                                 const AdoptedStop adopted(stop);
                                                                 take(i, i % slots);
                                                                 return i;
                                                               });
  }
  tbb::task_group_context whole(tbb::task_group_context::isolated);  // as run_loop()'s
  tbb::parallel_pipeline(slots,
                         chain & tbb::make_filter<std::size_t, void>(
                                     tbb::filter_mode::serial_in_order, [](std::size_t) {}),
                         whole);
}

std::size_t pipeline_threads() {
  return static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency());
}

}  // namespace planish
