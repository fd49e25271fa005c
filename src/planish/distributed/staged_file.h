#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "planish/distributed/messages.h"

namespace planish {

/// A file that all ranks write by MPI-IO and that appears whole or not at all: bytes go to
/// `path`.part, which rank 0 renames when all agree that everything is there. Every function is
/// called by all ranks and throws AgreedError{UnwritableOutput} naming the path.
class StagedFile {
 public:
  /// Removes what an ended job may have left of such a file.
  StagedFile(const Ranks& ranks, std::string path);
  /// Closes, and removes the part that was not committed.
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
  std::string path_, part_;
  MPI_File file_ = MPI_FILE_NULL;
  bool committed_ = false;
};

}  // namespace planish
