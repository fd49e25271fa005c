#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "terminal/console.h"

namespace planish::command {

enum class ProgressMode { Auto, Bar, Plain, JsonLines, None };

class JobProgress;

/// A step of a job and how long it takes beside the others, in any unit.
struct PlannedStep {
  std::string name;
  double weight = 1;
};

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
  friend class JobProgress;
  void show(JobProgress& job);
  void draw_bar(JobProgress& job, double now);
  void write_plain(JobProgress& job, double now);
  void write_json(JobProgress& job, double now);

  Console& console_;
  ProgressMode mode_;
  Clock clock_;
  int job_count_;
  std::mutex mutex_;
  double last_bar_;  ///< when it was drawn
};

/// How far one job is.
class JobProgress {
 public:
  /// `number` counts from 1.
  JobProgress(Progress& progress, std::string_view name, int number = 1);

  /// The steps to come, in order; others are parts of the one under way, with its fraction.
  void plan(std::vector<PlannedStep> steps);
  void update(std::string_view step, double fraction);
  /// While it lives, fractions are those of a part of each step: from `begin` to `end`.
  class Part {
   public:
    Part(JobProgress& progress, double begin, double end) : progress_(progress) {
      progress_.begin_ = begin;
      progress_.end_ = end;
    }
    ~Part() {
      progress_.begin_ = 0;
      progress_.end_ = 1;
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    JobProgress& progress_;
  };
  /// Of the whole job, 0 to 1; never falls.
  [[nodiscard]] double share() const { return share_; }

 private:
  friend class Progress;
  void advance();

  Progress& progress_;
  std::string name_;
  int number_;
  std::vector<PlannedStep> steps_{};
  std::size_t place_ = 0;  ///< in steps_
  std::string step_{};
  double fraction_ = 0, share_ = 0;
  double begin_ = 0, end_ = 1;
  double begun_, last_plain_;
  std::string json_step_{};
  int json_percent_ = -1;
};

}  // namespace planish::command
