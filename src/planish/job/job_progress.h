#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace planish {

/// A step of a job and how long it takes beside the others, in any unit.
struct PlannedStep {
  std::string name;
  double weight = 1;
};

/// What is told of a job: the `fraction` of the step, 0 to 1, and the `share` of the whole job,
/// which never falls.
using ProgressVisit = std::function<void(std::string_view step, double fraction, double share)>;

/// How far a job is, of the steps that it will take.
class JobProgress {
 public:
  /// `visit` may be empty.
  explicit JobProgress(ProgressVisit visit) : visit_(std::move(visit)) {}

  /// The steps to come, in order; others are parts of the one under way, with its fraction.
  void plan(std::vector<PlannedStep> steps) { steps_ = std::move(steps); }
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
  void advance();

  ProgressVisit visit_;
  std::vector<PlannedStep> steps_{};
  std::size_t place_ = 0;  ///< in steps_
  std::string step_{};
  double fraction_ = 0, share_ = 0;
  double begin_ = 0, end_ = 1;
};

}  // namespace planish
