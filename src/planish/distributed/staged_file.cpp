#include "planish/distributed/staged_file.h"

#include <algorithm>
#include <filesystem>

#include "planish/core/error.h"

namespace planish {

namespace {

// MPI-IO reports faults by what it returns and goes on; a short file would be renamed over a good
// one if that were not looked at.
std::string text_of(int code) {
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  return {text, static_cast<std::size_t>(length)};
}

}  // namespace

StagedFile::StagedFile(const Ranks& ranks, std::string path, bool replaces)
    : ranks_(ranks), path_(std::move(path)) {
  std::string temporary;
  agree(ranks_, [&] {
    if (ranks_.rank == 0) temporary = output_.emplace(path_, replaces).temporary().string();
  });
  const RawVector<char> name = all_gather<char>(ranks_, temporary);
  temporary.assign(name.begin(), name.end());
  const int code =
      MPI_File_open(ranks_.comm, temporary.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file_);
  // Where it is open on some ranks only, nobody can close it: that is left to the job's end.
  agree(ranks_, [&] {
    if (code == MPI_SUCCESS) return;
    file_ = MPI_FILE_NULL;
    fail("cannot be opened by all ranks: " + text_of(code));
  });
}

StagedFile::~StagedFile() {
  if (file_ != MPI_FILE_NULL) (void)MPI_File_close(&file_);
}

void StagedFile::fail(const std::string& what) const {
  throw Error(ErrorCode::UnwritableOutput, path_ + ": " + what);
}

void StagedFile::write(std::int64_t offset, std::span<const std::byte> bytes) {
  const auto own = static_cast<std::int64_t>(bytes.size());
  constexpr auto kRound = static_cast<std::int64_t>(kRoundBytes);
  const std::int64_t rounds = max_over(ranks_, (own + kRound - 1) / kRound);
  std::string fault;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const std::int64_t begin = std::min(round * kRound, own);
    const int count = static_cast<int>(std::min(kRound, own - begin));
    MPI_Status status;
    int written = 0;
    const int code = MPI_File_write_at_all(file_, offset + begin, bytes.data() + begin, count,
                                           MPI_BYTE, &status);
    if (code != MPI_SUCCESS) {
      fault = "cannot be written: " + text_of(code);
    } else if (MPI_Get_count(&status, MPI_BYTE, &written) != MPI_SUCCESS || written != count) {
      fault = formatted("only {} of {} bytes could be written; is the disk full?", written, count);
    }
  }
  agree(ranks_, [&] {
    if (!fault.empty()) fail(fault);
  });
}

void StagedFile::close(std::int64_t bytes) {
  const int synced = MPI_File_sync(file_);
  const int closed = MPI_File_close(&file_);
  file_ = MPI_FILE_NULL;
  agree(ranks_, [&] {
    if (synced != MPI_SUCCESS) fail("cannot be written: " + text_of(synced));
    if (closed != MPI_SUCCESS) fail("cannot be closed: " + text_of(closed));
    if (ranks_.rank != 0) return;
    std::error_code code;
    const std::uintmax_t found = std::filesystem::file_size(output_->temporary(), code);
    if (code) fail("cannot be looked at: " + code.message());
    if (found != static_cast<std::uintmax_t>(bytes))
      fail(formatted("has {} bytes, {} were written; is the disk full?", found, bytes));
  });
}

void StagedFile::commit() {
  agree(ranks_, [&] {
    if (ranks_.rank == 0) output_->commit();
  });
}

}  // namespace planish
