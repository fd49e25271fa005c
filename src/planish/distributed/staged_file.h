#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "planish/core/output_file.h"
#include "planish/distributed/messages.h"

namespace planish {

/// An OutputFile that all ranks write by MPI-IO: it appears whole or not at all, when all agree
/// that everything is there. A job that is killed may leave its temporary, as on one machine: it
/// has a name of its own, so that no other job and no other program's file is touched. Every
/// function is called by all ranks and throws AgreedError{UnwritableOutput} naming the path.
class StagedFile {
 public:
  /// `replaces`: as OutputFile has it.
  StagedFile(const Ranks& ranks, std::string path, bool replaces = true);
  /// Closes, and removes what was not committed.
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  /// Each rank its own bytes at its own place.
  void write(std::int64_t offset, std::span<const std::byte> bytes);
  /// Closes, looks whether the file has `bytes` bytes, and agrees on it.
  void close(std::int64_t bytes);
  /// Renames.
  void commit();

 private:
  void fail(const std::string& what) const;

  const Ranks& ranks_;
  std::string path_;
  std::optional<OutputFile> output_;  // on rank 0
  MPI_File file_ = MPI_FILE_NULL;
};

}  // namespace planish
