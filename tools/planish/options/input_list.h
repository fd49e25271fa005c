#pragma once

#include <string>
#include <vector>

#include "planish/files/formats.h"

namespace planish::command {

/// The inputs of a command line, folders replaced by the files in them (not in folders below) whose
/// extension is read, in the order of their names; the order of the arguments stays.
struct InputList {
  std::vector<std::string> paths;
  bool has_folder = false;  ///< one of the arguments was a folder
};

/// Throws Error{UnreadableInput} for a folder without such a file.
[[nodiscard]] InputList expand_inputs(const std::vector<std::string>& arguments);

/// Throws Error{InvalidArgument} where two inputs have one stem, so that their outputs would have
/// one name.
void require_distinct_stems(const std::vector<std::string>& paths);

/// Whether a path names a folder to write into: "-" does not, one that ends in a separator does, or
/// one that is a folder.
[[nodiscard]] bool names_folder(const std::string& path);

/// FOLDER/STEM.EXTENSION of an input; of stdin, FOLDER/stdin.EXTENSION.
[[nodiscard]] std::string path_in_folder(const std::string& folder, const std::string& input,
                                         FileFormat format);

/// A surface's name to propose in a message: NAME.glb, unless that is the input.
[[nodiscard]] std::string output_beside(const std::string& input);

/// What a job of that input is called: its stem, made visible.
[[nodiscard]] std::string job_name_of(const std::string& input);

}  // namespace planish::command
