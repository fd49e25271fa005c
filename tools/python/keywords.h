#pragma once

#include <string>

#include "planish/core/option.h"
#include "planish/job/job_settings.h"

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

/// What write() takes: what files hold, and how finely the surface is cut where no level says it.
[[nodiscard]] inline bool is_write_keyword(const OptionInfo& option) {
  return (option.stage == OptionStage::Output || option.stage == OptionStage::Fineness ||
          option.needs == OptionNeeds::Step) &&
         !is_of_inputs(option) && option.name != "levels" && option.name != "device";
}

/// What fit_file() takes besides: all but the device.
[[nodiscard]] inline bool is_file_keyword(const OptionInfo& option) {
  return !is_keyword(option) && option.kind != OptionKind::Vertices &&
         option.kind != OptionKind::Edges && option.name != "device";
}

}  // namespace planish::python
