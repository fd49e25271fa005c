#include "terminal/interrupt.h"

#include <csignal>

#include "planish/core/error.h"

namespace planish::command {
namespace {

volatile std::sig_atomic_t noted_signal = 0;

extern "C" void note_signal(int signal) { noted_signal = signal; }

}  // namespace

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  sigemptyset(&action.sa_mask);
  // Back to the default after the first, so that the second kills. SA_RESTART: a read or write in
  // progress goes on, and the work stops at its next check.
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int interrupt_signal() { return noted_signal; }

void check_interrupt() {
  if (noted_signal != 0) throw Error(ErrorCode::Cancelled, "interrupted");
}

}  // namespace planish::command
