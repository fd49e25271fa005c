#pragma once

#include <gtest/gtest.h>

#include <string>

#include "planish/core/error.h"

namespace planish::test {

/// Runs `action` and returns the message of the Error{code} that it must throw.
template <class Action>
std::string message_of(ErrorCode code, const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

}  // namespace planish::test
