#pragma once

#include <string>

#include "planish/core/option.h"

namespace planish::python {

/// "method" of the option interpolation.
[[nodiscard]] inline std::string keyword_of(const OptionInfo& option) {
  return std::string(option.keyword.empty() ? option.name : option.keyword);
}

/// What shapes and solves, not what files and devices are told; tags come as arrays.
[[nodiscard]] inline bool is_keyword(const OptionInfo& option) {
  return (option.stage == OptionStage::Shape || option.stage == OptionStage::Solve) &&
         option.kind != OptionKind::Vertices && option.kind != OptionKind::Edges;
}

/// What only functions that write files take, of STEP.
[[nodiscard]] inline bool is_step_keyword(const OptionInfo& option) {
  return option.needs == OptionNeeds::Step;
}

/// What fit_file() takes besides: all but the device.
[[nodiscard]] inline bool is_file_keyword(const OptionInfo& option) {
  return !is_keyword(option) && option.kind != OptionKind::Vertices &&
         option.kind != OptionKind::Edges && option.name != "device";
}

}  // namespace planish::python
