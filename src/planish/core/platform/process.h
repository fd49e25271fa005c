#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

/// This process, those that it starts, the libraries that it loads, and the terminal before it.
namespace planish::platform {

/// The arguments of main() in UTF-8, the program's name first. Standard input and output hold bytes
/// from here on, not lines.
[[nodiscard]] std::vector<std::string> program_arguments(int count, char** arguments);

/// A variable of the environment, in UTF-8; empty where there is none.
[[nodiscard]] std::optional<std::string> environment(const char* name);

// Signals.

/// From now on the first interruption (SIGINT) or termination (SIGTERM) calls `note` with it, on a
/// thread or in the midst of one: it may set atomics alone. The next one ends the process at once.
/// What is being read or written goes on. A closed pipe is an error of who writes, no signal.
void on_ending(void (*note)(int signal));
/// Comes back when `note` was called.
void wait_for_ending();
/// Never comes back, for a thread that must not do anything any more.
[[noreturn]] void sleep_for_ever();
/// Ends as other filters do whose reader has gone: on POSIX killed by SIGPIPE, without a word.
[[noreturn]] void end_by_broken_pipe();

// The terminal.

[[nodiscard]] bool is_terminal(int file);
/// Whether it obeys what moves the cursor and colours text.
[[nodiscard]] bool moves_cursor(int file);
/// Empty where it is not known.
[[nodiscard]] std::optional<int> terminal_columns(int file);

// Programs.

/// The file that this process runs, if the system says.
[[nodiscard]] std::optional<std::filesystem::path> own_program();
/// A file with this name that can be run: NAME, or NAME.exe.
[[nodiscard]] std::filesystem::path program_in(const std::filesystem::path& folder,
                                               const std::string& name);
[[nodiscard]] bool is_program(const std::filesystem::path& path);
/// The folders of PATH.
[[nodiscard]] std::vector<std::filesystem::path> program_folders();

/// How a process ended: by a signal, where that is not 0, else with a code.
struct Ending {
  int code = 0;
  int signal = 0;
  bool was_killed = false;  ///< by SIGKILL, as a system does that has no memory left
};

/// A program that reads from us by its standard input and answers by its standard output. Ended
/// with this.
class ChildProcess {
 public:
  ChildProcess();
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] std::error_code start(const std::filesystem::path& program);

  struct Ready {
    bool to_send = false, to_receive = false;
  };
  /// Waits until one of them can be done, no longer than that.
  [[nodiscard]] Ready wait(bool wants_to_send, int milliseconds, std::error_code& error);
  /// How many bytes it has taken. A broken connection shows when the answer is received.
  [[nodiscard]] std::size_t send(std::span<const std::byte> bytes);
  /// Nothing more is sent.
  void end_sending();
  /// How many bytes came, 0 while there are none; empty when none will come any more.
  [[nodiscard]] std::optional<std::size_t> receive(std::span<std::byte> bytes);
  /// Waits for its end.
  [[nodiscard]] Ending wait_for_end();

 private:
  struct System;
  std::unique_ptr<System> system_;
};

// Libraries.

/// The file of a shared library as this system names it: "libvulkan.so.1".
[[nodiscard]] std::string library_file(const std::string& name, int version);
/// Null with what the system says where it cannot be loaded.
[[nodiscard]] void* load_library(const std::string& file, std::string& why);
void unload_library(void* library);
/// Null where it has none of that name.
using Function = void (*)();
[[nodiscard]] Function function_of(void* library, const char* name);

}  // namespace planish::platform
