#pragma once

namespace planish::command {

/// From now on the first SIGINT or SIGTERM is only noted, so that work can stop cleanly; a second
/// one ends the process at once. SIGPIPE is ignored: writes report the broken pipe instead.
void install_signal_handlers();

/// The signal noted, 0 if none.
[[nodiscard]] int interrupt_signal();

/// Throws Error{Cancelled} when a signal was noted.
void check_interrupt();

}  // namespace planish::command
