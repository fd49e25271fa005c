#pragma once

#include <string>

namespace CLI {
class App;
}

namespace planish::command {

/// The flags of the memory that a command's arrays and the programs it starts may take.
struct MemoryFlags {
  std::string budget, folder;

  void add_to(CLI::App& command);
  /// Where a budget is given, holds large arrays within it from now on; files lie beside `output`
  /// where no folder is named. Throws Error{InvalidArgument, UnwritableOutput}.
  void apply(const std::string& output) const;
};

}  // namespace planish::command
