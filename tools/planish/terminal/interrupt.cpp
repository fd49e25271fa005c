#include "terminal/interrupt.h"

#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "planish/core/error.h"
#include "planish/job/temporary_folders.h"
#include "planish/job/threads.h"
#include "terminal/console.h"
#include "terminal/exit_codes.h"

namespace planish::command {
namespace {

std::atomic<bool> is_ending = false;

// Jobs on other threads than the one that takes the signal read it, too.
std::atomic<int> noted_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);
StopFlag stop = false;
sem_t signalled;
MessageStyle ending_style;

extern "C" void note_signal(int signal) {
  noted_signal = signal;
  stop = true;
  sem_post(&signalled);
}

// For work that does not come to its next check soon enough.
[[noreturn]] void end_for_good() {
  const auto moving = while_files_move();
  if (is_ending.exchange(true)) {
    for (;;) ::pause();
  }
  remove_temporary_folders();
  Console console(LogLevel::Error, ending_style.color, ending_style.form);
  if (console.is_terminal()) console.status("");
  console.error("interrupted; no partial file is left");
  std::_Exit(static_cast<int>(exit_code_of(ErrorCode::Cancelled)));
}

void wait_for_signal() {
  while (sem_wait(&signalled) != 0) {
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(kPatienceMilliseconds));
  end_for_good();
}

}  // namespace

void install_signal_handlers(MessageStyle style) {
  ending_style = style;
  sem_init(&signalled, 0, 0);
  if constexpr (!kHasThreads) return;  // the engine's own end of a script
  std::thread(wait_for_signal).detach();
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

const StopFlag& interrupt_flag() { return stop; }

void check_interrupt() {
  if (noted_signal != 0) throw Error(ErrorCode::Cancelled, "interrupted");
}

void claim_end() {
  if (!is_ending.exchange(true)) return;
  for (;;) ::pause();
}

}  // namespace planish::command
