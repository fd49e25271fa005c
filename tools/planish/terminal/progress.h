#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "terminal/console.h"

namespace planish::command {

enum class ProgressMode { Auto, Bar, Plain, Json, None };

/// Shows how far the work is, on stderr: a bar that is redrawn in place; or plain lines, at most
/// one every 10 seconds; or JSON lines `{"job":...,"step":...,"fraction":...}`, one per step and
/// per percent. Auto: the bar on a terminal, else plain lines; nothing where messages are off.
class Progress {
 public:
  /// Seconds since any fixed moment.
  using Clock = std::function<double()>;

  Progress(Console& console, ProgressMode mode, Clock clock = {});

  /// The name that the next updates belong to.
  void begin_job(std::string_view name);
  void update(std::string_view step, double fraction);
  void finish() { console_.clear_status(); }

 private:
  void draw_bar(double now);
  void write_plain(double now);
  void write_json();

  Console& console_;
  ProgressMode mode_;
  Clock clock_;
  std::string job_, step_;
  double fraction_ = 0;
  double last_shown_;      ///< time of the last bar or plain line
  std::string json_step_;  ///< the last JSON line's step and percent
  int json_percent_ = -1;
};

}  // namespace planish::command
