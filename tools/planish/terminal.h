#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/job/job.h"
#include "planish/job/report.h"

namespace planish::command {

/// What the process tells its caller; part of the command's interface.
enum class ExitCode : int {
  Done = 0,
  InternalError = 1,
  Usage = 2,                       ///< arguments or scene file wrong
  UnreadableInput = 3,             ///< missing or malformed
  UnusableMesh = 4,                ///< read, but no surface can be made of it
  NotConverged = kFallsShortCode,  ///< files are written, and flagged
  NoDevice = 6,                    ///< no device, device lost, or out of memory
  UnwritableOutput = 7,
  JobsFailed = 8,     ///< some jobs of a run
  Interrupted = 130,  ///< SIGINT
  Terminated = 143,   ///< SIGTERM
};

/// Of a job that was done.
[[nodiscard]] inline ExitCode exit_code_of(const JobReport& report) {
  return report.falls_short ? ExitCode::NotConverged : ExitCode::Done;
}

/// The exit code of a library error. Cancelled: after the signal that was received.
[[nodiscard]] ExitCode exit_code_of(ErrorCode code);

enum class LogLevel { Error, Warning, Info, Debug };
enum class ColorMode { Auto, Always, Never };
/// JsonLines: every message is a line `{"level":...,"message":...}`, so that a program which reads
/// the progress as JSON meets nothing else.
enum class MessageForm { Text, JsonLines };

/// How messages look, as far as it is known before arguments are parsed.
struct MessageStyle {
  ColorMode color = ColorMode::Auto;
  MessageForm form = MessageForm::Text;
};

/// Messages for people, all on stderr. One status line may stand below them on a terminal; it is
/// taken away before a message and drawn again by its owner. A closed stderr is no error. What a
/// terminal would obey in a message is shown instead, see visible_lines(); who puts a name from
/// outside into a message cleans it by visible(), line ends included. May be used by several
/// threads.
class Console {
 public:
  /// `program`: what messages begin with.
  Console(LogLevel level, ColorMode color, MessageForm form = MessageForm::Text,
          std::string_view program = "planish");
  ~Console() { clear_status(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void error(std::string_view text);    ///< "planish: error: text"
  void warning(std::string_view text);  ///< "planish: warning: text"
  void info(std::string_view text);
  void debug(std::string_view text);
  /// A line as it is, whatever the level.
  void raw(std::string_view text);

  void status(std::string_view text);
  void clear_status();

  [[nodiscard]] bool is_terminal() const { return terminal_; }
  [[nodiscard]] LogLevel level() const { return level_; }

 private:
  void say(std::string_view level, std::string_view color, std::string_view text);
  void write_line(std::string line);

  LogLevel level_;
  MessageForm form_;
  std::string program_;
  bool terminal_;
  bool color_;
  std::mutex mutex_;
  bool status_shown_ = false;
};

/// Nobody reads stdout any more. No Error: the process ends by SIGPIPE, without a word, as other
/// filters do.
struct BrokenPipe {};

/// Writes bytes to stdout and flushes. Throws Error{UnwritableOutput}, or BrokenPipe.
void write_stdout(std::string_view bytes);

/// The same with a text for people, in which what a terminal would obey is shown instead.
void write_text(std::string_view text);

/// Whether stdout is a terminal.
[[nodiscard]] bool stdout_is_terminal();

/// Columns of the terminal on stdout; 80 where it is none.
[[nodiscard]] int stdout_columns();

enum class Align { Left, Right };

/// Text in aligned columns, two spaces between them. Widths count code points of UTF-8.
class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::Left;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell per column.
  void add_row(std::vector<std::string> cells);

  /// Titles and rows, each with a line end and no spaces before it.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

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

/// Several things that are wrong, each a message of its own.
class FaultList : public Error {
 public:
  FaultList(ErrorCode code, std::vector<std::string> messages);

  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

/// What is wrong with a command before its work starts, gathered so that all of it is said at
/// once, in the order in which it was found.
class Faults {
 public:
  /// Runs `check` and keeps the Error that it throws.
  template <class Check>
  void note(const Check& check) {
    try {
      check();
    } catch (const Error& error) {
      add(error);
    }
  }
  void add(const Error& error);
  [[nodiscard]] bool any() const { return !messages_.empty(); }
  /// Throws the one Error, or a FaultList whose code is the one of the lowest exit code: what is
  /// wrong with the command line comes before what is wrong with files.
  void throw_if_any() const;

 private:
  std::vector<std::string> messages_;
  ErrorCode code_ = ErrorCode::InvalidArgument;
};

enum class ProgressMode { Auto, Bar, Plain, JsonLines, None };

class JobDisplay;

/// Shows how far the work is, on stderr: a bar that is redrawn in place; or plain lines, at most
/// one every 10 seconds a job; or JSON lines, one per step and per percent of it:
/// `{"job":"goblet","step":"solve","fraction":0.5,"number":1,"jobs":1,"share":0.3,"seconds":1.2,
/// "seconds_left":2.8}`: `fraction` of the step and `share` of the whole job, the job's number
/// among all, seconds since it began and an estimate of those left (null before it can be told).
/// Auto: the bar on a terminal, else plain lines; nothing where messages are off. Several threads
/// may report, each on a job of its own.
class Progress {
 public:
  /// Seconds since any fixed moment.
  using Clock = std::function<double()>;

  Progress(Console& console, ProgressMode mode, Clock clock = {}, int job_count = 1);

  void finish() { console_.clear_status(); }

 private:
  friend class JobDisplay;
  void show(JobDisplay& job);
  void draw_bar(JobDisplay& job, double now);
  void write_plain(JobDisplay& job, double now);
  void write_json(JobDisplay& job, double now);

  Console& console_;
  ProgressMode mode_;
  Clock clock_;
  int job_count_;
  std::mutex mutex_;
  double last_bar_;  ///< when it was drawn
};

/// How far one job is.
class JobDisplay {
 public:
  /// `number` counts from 1.
  JobDisplay(Progress& progress, std::string_view name, int number = 1);

  /// Shows what it is told; the display must outlive it.
  [[nodiscard]] ProgressVisit visit();

 private:
  friend class Progress;
  void show(std::string_view step, double fraction, double share);

  Progress& progress_;
  std::string name_;
  int number_;
  std::string step_{};
  double fraction_ = 0, share_ = 0;
  double begun_, last_plain_;
  std::string json_step_{};
  int json_percent_ = -1;
};

/// A job's warnings and details on the console, its progress on the display, what is for stdout
/// there. All of it must outlive the job. `page` may be null.
[[nodiscard]] JobWatch watch_of(Console& console, JobDisplay& display, JobPage* page = nullptr);

}  // namespace planish::command
