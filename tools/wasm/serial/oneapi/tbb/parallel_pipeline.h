#pragma once

#include <oneapi/tbb/task_group.h>

#include <cstddef>
#include <functional>
#include <type_traits>
#include <utility>

namespace oneapi::tbb {

enum class filter_mode { parallel, serial_in_order, serial_out_of_order };

class flow_control {
 public:
  void stop() { is_stopped = true; }
  bool is_stopped = false;
};

/// A step from In to Out; the first, whose In is void, says by its flow_control when there is no
/// more.
template <class In, class Out>
struct filter {
  using Input = std::conditional_t<std::is_void_v<In>, flow_control&, In>;
  std::function<Out(Input)> step;
};

template <class In, class Out, class Step>
filter<In, Out> make_filter(filter_mode, const Step& step) {
  return {step};
}

template <class In, class Between, class Out>
filter<In, Out> operator&(filter<In, Between> first, filter<Between, Out> second) {
  return {[first = std::move(first),
           second = std::move(second)](typename filter<In, Between>::Input input) -> Out {
    if constexpr (std::is_void_v<In>) {
      Between between = first.step(input);
      // oneTBB drops what came with stop().
      if (input.is_stopped) return Out();
      return second.step(std::move(between));
    } else {
      return second.step(first.step(std::move(input)));
    }
  }};
}

inline void parallel_pipeline(std::size_t, const filter<void, void>& chain, task_group_context&) {
  for (flow_control control; !control.is_stopped;) chain.step(control);
}

}  // namespace oneapi::tbb
