#pragma once

namespace oneapi::tbb {

class task_arena {
 public:
  explicit task_arena(int = 1) {}
  template <class Function>
  decltype(auto) execute(const Function& function) {
    return function();
  }
};

namespace this_task_arena {
inline int max_concurrency() { return 1; }
template <class Function>
decltype(auto) isolate(const Function& function) {
  return function();
}
}  // namespace this_task_arena

}  // namespace oneapi::tbb
