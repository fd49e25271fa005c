#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace planish::test {

/// What a finished process left.
struct ProcessResult {
  int exit_code = -1;  ///< -1: killed by a signal
  int signal = 0;      ///< that killed it
  std::string out, err;
  // Of Options::measured.
  double peak_bytes = 0;   ///< of memory, with what it started
  double cpu_seconds = 0;  ///< likewise
};

/// The built command as a child process. Its stdin, stdout and stderr are files, so that no pipe
/// can fill up.
class PlanishProcess {
 public:
  struct Options {
    std::string input;           ///< on stdin
    bool closed_stdout = false;  ///< stdout is a pipe that nobody reads
    bool terminal = false;  ///< stdout and stderr are a terminal; both come as ProcessResult::out
    std::vector<std::string> environment;  ///< "NAME=value", beside PATH
    std::string folder;                    ///< working folder; empty: this process's
    bool measured = false;                 ///< memory and time, by a process between
  };

  PlanishProcess(const std::vector<std::string>& arguments, const Options& options);
  ~PlanishProcess();
  PlanishProcess(const PlanishProcess&) = delete;
  PlanishProcess& operator=(const PlanishProcess&) = delete;

  [[nodiscard]] pid_t id() const { return id_; }
  /// Waits until stderr holds `text`; false when the process ends before.
  [[nodiscard]] bool wait_for_message(std::string_view text);
  [[nodiscard]] ProcessResult finish();

 private:
  [[nodiscard]] std::string read_all(int file) const;
  void read_terminal();
  bool reap(bool wait);

  pid_t id_ = -1;
  int in_ = -1, out_ = -1, err_ = -1;
  int measured_ = -1;  ///< what that process writes
  int terminal_ = -1;  ///< our side of it
  std::string shown_;  ///< on the terminal
  bool ended_ = false;
  int status_ = 0;
};

/// Runs the command to its end.
[[nodiscard]] ProcessResult run_planish(const std::vector<std::string>& arguments,
                                        const PlanishProcess::Options& options = {});

}  // namespace planish::test
