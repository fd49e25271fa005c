#pragma once

#include <string>
#include <vector>

#include "help/command_page.h"
#include "planish/core/error.h"

namespace CLI {
class ParseError;
}

namespace planish::command {

/// The arguments (argv) with what hands type by themselves turned into what is meant: `help fit`
/// into `fit --help`, `help` into `--help`, `version` and `-V` into `--version`.
[[nodiscard]] std::vector<std::string> with_reflexes_understood(std::vector<std::string> arguments);

/// Names the command or flag that is not known before anything else is found amiss: "INPUT is
/// required" would hide the slip that moved the input into a flag's place. A file in the place of a
/// command is answered with the whole line to type, and an empty argument with whose it is. Throws
/// Error{InvalidArgument}.
void check_names(const CLI::App& app, const std::vector<std::string>& arguments);

/// What CLI11 found wrong, in words of ours, with what to type.
[[nodiscard]] Error parse_fault(const CLI::App& app, const HelpPage& page,
                                const CLI::ParseError& error);

}  // namespace planish::command
