#pragma once

#include <string>
#include <string_view>

namespace planish::command {

enum class LogLevel { Error, Warning, Info, Debug };
enum class ColorMode { Auto, Always, Never };

/// Messages for people, all on stderr. One status line may stand below them on a terminal; it is
/// taken away before a message and drawn again by its owner. A closed stderr is no error.
class Console {
 public:
  Console(LogLevel level, ColorMode color);
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
  void labelled(std::string_view color, std::string_view label, std::string_view text);

  LogLevel level_;
  bool terminal_;
  bool color_;
  bool status_shown_ = false;
};

/// Writes to stdout and flushes. Throws Error{UnwritableOutput}, a broken pipe included.
void write_stdout(std::string_view text);

}  // namespace planish::command
