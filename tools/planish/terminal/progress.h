#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "planish/job/job_progress.h"
#include "terminal/console.h"

namespace planish::command {

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

}  // namespace planish::command
