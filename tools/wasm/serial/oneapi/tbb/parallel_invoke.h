#pragma once

namespace oneapi::tbb {

template <class... Function>
void parallel_invoke(const Function&... function) {
  (function(), ...);
}

}  // namespace oneapi::tbb
