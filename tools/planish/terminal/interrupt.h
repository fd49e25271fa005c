#pragma once

#include "planish/core/stop.h"
#include "terminal/console.h"

namespace planish::command {

/// From now on the first SIGINT or SIGTERM is only noted, so that work can stop cleanly; a second
/// one ends the process at once. Work that has not stopped after kPatienceMilliseconds (inside
/// another library, or giving back gigabytes) is ended by a thread that waits for the signal: it
/// removes what was staged, says what work itself would have said, and leaves with the same exit
/// code. SIGPIPE is ignored: writes report the broken pipe instead.
void install_signal_handlers(MessageStyle style);

/// With what unwinding takes, work has ended 0.2 s after the signal.
inline constexpr int kPatienceMilliseconds = 50;

/// The signal noted, 0 if none.
[[nodiscard]] int interrupt_signal();

/// Set with the first signal; for a StopScope.
[[nodiscard]] const StopFlag& interrupt_flag();

/// Throws Error{Cancelled} when a signal was noted.
void check_interrupt();

/// Whoever asks first ends the process: nobody else may say anything or touch files any more.
/// Waits forever where the thread above was first.
void claim_end();

}  // namespace planish::command
