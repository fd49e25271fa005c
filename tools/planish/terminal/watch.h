#pragma once

#include "planish/job/job.h"
#include "terminal/console.h"
#include "terminal/progress.h"

namespace planish::command {

/// A job's warnings and details on the console, its progress on the display, what is for stdout
/// there. All of it must outlive the job. `page` may be null.
[[nodiscard]] JobWatch watch_of(Console& console, JobDisplay& display, JobPage* page = nullptr);

}  // namespace planish::command
