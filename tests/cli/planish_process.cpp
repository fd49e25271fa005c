#include "cli/planish_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace planish::test {
namespace {

int memory_file(std::string_view content) {
  const int file = memfd_create("planish_test", MFD_CLOEXEC);
  if (file < 0) throw std::runtime_error("memfd_create failed");
  if (::pwrite(file, content.data(), content.size(), 0) != static_cast<ssize_t>(content.size())) {
    throw std::runtime_error("writing a memory file failed");
  }
  return file;
}

// Our side of a new terminal, and the name of the other.
int open_terminal(std::string& name) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0)
    throw std::runtime_error("no terminal");
  name = ::ptsname(terminal);
  return terminal;
}

// The writing end of a pipe without a reader.
int broken_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
  ::close(ends[0]);
  return ends[1];
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

PlanishProcess::PlanishProcess(const std::vector<std::string>& arguments, const Options& options) {
  in_ = memory_file(options.input);
  out_ = options.closed_stdout ? broken_pipe() : memory_file("");
  err_ = memory_file("");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in_, STDIN_FILENO);
  std::string terminal;
  if (options.terminal) {
    terminal_ = open_terminal(terminal);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, terminal.c_str(), O_RDWR | O_NOCTTY,
                                     0);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  } else {
    posix_spawn_file_actions_adddup2(&actions, out_, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err_, STDERR_FILENO);
  }
  if (!options.folder.empty())
    posix_spawn_file_actions_addchdir_np(&actions, options.folder.c_str());
  std::vector<std::string> texts{PLANISH_EXECUTABLE};
  if (options.measured) {
    measured_ = memory_file("");
    posix_spawn_file_actions_adddup2(&actions, measured_, 3);
#ifdef PLANISH_MEASURE
    texts.insert(texts.begin(), PLANISH_MEASURE);
#endif
  }
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = options.environment;
  environment.emplace_back("PATH=/usr/bin:/bin");
  for (const std::string name : {"ASAN_OPTIONS", "TSAN_OPTIONS"}) {
    if (const char* own = std::getenv(name.c_str())) environment.push_back(name + "=" + own);
  }
  std::vector<char*> argv = pointers(texts);
  std::vector<char*> envp = pointers(environment);
  const int failed = posix_spawn(&id_, argv.front(), &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error("cannot start " PLANISH_EXECUTABLE);
}

PlanishProcess::~PlanishProcess() {
  if (!ended_) {
    ::kill(id_, SIGKILL);
    reap(true);
  }
  for (const int file : {in_, out_, err_}) ::close(file);
  if (measured_ >= 0) ::close(measured_);
  if (terminal_ >= 0) ::close(terminal_);
}

bool PlanishProcess::reap(bool wait) {
  if (!ended_) ended_ = ::waitpid(id_, &status_, wait ? 0 : WNOHANG) == id_;
  return ended_;
}

std::string PlanishProcess::read_all(int file) const {
  std::string text;
  std::array<char, 65536> buffer{};
  for (;;) {
    const ssize_t count =
        ::pread(file, buffer.data(), buffer.size(), static_cast<off_t>(text.size()));
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

bool PlanishProcess::wait_for_message(std::string_view text) {
  for (;;) {
    const bool ended = reap(false);
    if (read_all(err_).find(text) != std::string::npos) return true;
    if (ended) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// Until the other side is closed, which reads as an error.
void PlanishProcess::read_terminal() {
  std::array<char, 4096> buffer{};
  for (;;) {
    const ssize_t count = ::read(terminal_, buffer.data(), buffer.size());
    if (count <= 0) return;
    shown_.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

ProcessResult PlanishProcess::finish() {
  if (terminal_ >= 0) read_terminal();
  reap(true);
  ProcessResult result;
  if (WIFEXITED(status_)) result.exit_code = WEXITSTATUS(status_);
  if (WIFSIGNALED(status_)) result.signal = WTERMSIG(status_);
  result.out = terminal_ >= 0 ? shown_ : read_all(out_);
  result.err = read_all(err_);
  if (measured_ >= 0)
    std::istringstream(read_all(measured_)) >> result.peak_bytes >> result.cpu_seconds;
  return result;
}

ProcessResult run_planish(const std::vector<std::string>& arguments,
                          const PlanishProcess::Options& options) {
  return PlanishProcess(arguments, options).finish();
}

}  // namespace planish::test
