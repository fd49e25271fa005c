#include "terminal/faults.h"

#include <algorithm>

#include "terminal/exit_codes.h"

namespace planish::command {
namespace {

std::string joined(const std::vector<std::string>& messages) {
  std::string text;
  for (const std::string& message : messages) text += (text.empty() ? "" : "\n") + message;
  return text;
}

}  // namespace

FaultList::FaultList(ErrorCode code, std::vector<std::string> messages)
    : Error(code, joined(messages)), messages_(std::move(messages)) {}

void Faults::add(const Error& error) {
  if (messages_.empty() || exit_code_of(error.code()) < exit_code_of(code_)) code_ = error.code();
  const std::string message = error.what();
  if (std::ranges::find(messages_, message) == messages_.end()) messages_.push_back(message);
}

void Faults::throw_if_any() const {
  if (messages_.empty()) return;
  if (messages_.size() == 1) throw Error(code_, messages_.front());
  throw FaultList(code_, messages_);
}

}  // namespace planish::command
