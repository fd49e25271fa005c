#pragma once

#include <string>
#include <vector>

#include "planish/core/error.h"

namespace planish::command {

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

}  // namespace planish::command
