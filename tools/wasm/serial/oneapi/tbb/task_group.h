#pragma once

namespace oneapi::tbb {

struct task_group_context {
  enum kind_type { isolated, bound };
  explicit task_group_context(kind_type = bound) {}
};

}  // namespace oneapi::tbb
