#pragma once

#include <mutex>
#include <string>
#include <string_view>

namespace planish::command {

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

}  // namespace planish::command
