// Windows 10 and later.
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#define _WIN32_WINNT 0x0A00
#define PSAPI_VERSION 2
#include <windows.h>
// Needs the one before.
#include <fcntl.h>
#include <io.h>
#include <psapi.h>
#include <shellapi.h>
#ifdef __MINGW32__
#include <cxxabi.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cwchar>
#include <cwctype>
#include <random>
#include <type_traits>

#include "planish/core/platform/files.h"
#include "planish/core/platform/machine.h"
#include "planish/core/platform/process.h"
#include "planish/core/words.h"

namespace planish::platform {
namespace {

namespace fs = std::filesystem;

#ifdef __MINGW32__
// GCC keeps a thread's objects in memory that one key of the thread gives back, and calls their
// destructors by another; mingw-w64 comes to keys in the order in which they were made. Before
// anybody has such an object the other one is made here, as by any first call: else destructors
// would find their memory gone, and threads that end would damage the heap.
__attribute__((constructor(101))) void make_key_of_destructors() {
  (void)abi::__cxa_thread_atexit([](void*) {}, nullptr, nullptr);
}
#endif

constexpr DWORD kWhoever = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
// What one call reads or writes.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

std::error_code reason_of(DWORD number) {
  const std::error_code own(static_cast<int>(number), std::system_category());
  // Its own words say more: another program has the file open.
  if (number == ERROR_SHARING_VIOLATION) return own;
  const std::error_condition known = own.default_error_condition();
  return known.category() == std::generic_category()
             ? std::error_code(known.value(), std::generic_category())
             : own;
}
std::error_code last_reason() { return reason_of(::GetLastError()); }
std::error_code result_of(BOOL done) { return done ? std::error_code() : last_reason(); }
std::error_code c_reason() { return {errno, std::generic_category()}; }

constexpr std::wstring_view kAnyLength = L"\\\\?\\";

// As the system takes it: without this start, names end at 260 letters where nobody has said
// otherwise.
std::wstring system_name(const fs::path& path) {
  constexpr std::size_t kShort = 240;  // and a name in the folder
  std::error_code error;
  fs::path whole = fs::absolute(path, error);
  if (error || whole.native().size() < kShort || whole.native().starts_with(L"\\\\"))
    return path.native();
  whole = whole.lexically_normal().make_preferred();
  return std::wstring(kAnyLength) + whole.native();
}

HANDLE handle_of(int file) { return reinterpret_cast<HANDLE>(::_get_osfhandle(file)); }

class Handle {
 public:
  explicit Handle(HANDLE handle) : handle_(handle) {}
  ~Handle() {
    if (is_open()) ::CloseHandle(handle_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  [[nodiscard]] bool is_open() const {
    return handle_ != INVALID_HANDLE_VALUE && handle_ != nullptr;
  }
  [[nodiscard]] HANDLE get() const { return handle_; }
  [[nodiscard]] HANDLE release() { return std::exchange(handle_, nullptr); }

 private:
  HANDLE handle_;
};

HANDLE open_handle(const fs::path& path, DWORD access, DWORD disposition, DWORD flags) {
  return ::CreateFileW(system_name(path).c_str(), access, kWhoever, nullptr, disposition, flags,
                       nullptr);
}

File opened(HANDLE made, int how, std::error_code& error) {
  Handle handle(made);
  error = handle.is_open() ? std::error_code() : last_reason();
  if (error) return File();
  File file(::_open_osfhandle(reinterpret_cast<std::intptr_t>(handle.get()), how));
  if (file.is_open()) {
    (void)handle.release();
  } else {
    error = c_reason();
  }
  return file;
}

// Folders are opened, too, so that what they are can be told.
File open_existing(const fs::path& path, DWORD flags, std::error_code& error) {
  return opened(open_handle(path, GENERIC_READ, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS | flags),
                _O_RDONLY | _O_BINARY | _O_NOINHERIT, error);
}

unsigned random_number() { return std::random_device()(); }

fs::path hidden_name(const fs::path& folder) {
  return folder / (L".planish-" + std::to_wstring(random_number()));
}

}  // namespace

std::error_code File::close() {
  const int number = std::exchange(number_, -1);
  return number < 0 || ::_close(number) == 0 ? std::error_code() : c_reason();
}

File open_to_read(const fs::path& path, std::error_code& error) {
  return open_existing(path, 0, error);
}

File open_regular_to_read(const fs::path& path, std::error_code& error) {
  return open_existing(path, FILE_FLAG_OPEN_REPARSE_POINT, error);
}

File create_new(const fs::path& path, std::error_code& error) {
  return opened(open_handle(path, GENERIC_WRITE, CREATE_NEW, FILE_ATTRIBUTE_NORMAL),
                _O_WRONLY | _O_BINARY | _O_NOINHERIT, error);
}

FileFacts facts_of(int file, std::error_code& error) {
  error.clear();
  const HANDLE handle = handle_of(file);
  const DWORD type = ::GetFileType(handle);
  if (type == FILE_TYPE_CHAR) return {.kind = FileKind::CharacterDevice};
  if (type != FILE_TYPE_DISK) return {};
  BY_HANDLE_FILE_INFORMATION all{};
  error = result_of(::GetFileInformationByHandle(handle, &all));
  if (error) return {};
  if (all.dwFileAttributes & FILE_ATTRIBUTE_REPARSE_POINT) return {};
  if (all.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) return {.kind = FileKind::Folder};
  return {.kind = FileKind::Regular,
          .size = (static_cast<std::uint64_t>(all.nFileSizeHigh) << 32) | all.nFileSizeLow};
}

std::size_t read_some(int file, std::span<std::byte> bytes, std::error_code& error) {
  const int got =
      ::_read(file, bytes.data(), static_cast<unsigned>(std::min(bytes.size(), kMostBytes)));
  error = got < 0 ? c_reason() : std::error_code();
  return static_cast<std::size_t>(std::max(got, 0));
}

std::size_t read_at(int file, std::span<std::byte> bytes, std::uint64_t place,
                    std::error_code& error) {
  OVERLAPPED at{};
  at.Offset = static_cast<DWORD>(place);
  at.OffsetHigh = static_cast<DWORD>(place >> 32);
  DWORD got = 0;
  const BOOL done = ::ReadFile(handle_of(file), bytes.data(),
                               static_cast<DWORD>(std::min(bytes.size(), kMostBytes)), &got, &at);
  error = done || ::GetLastError() == ERROR_HANDLE_EOF ? std::error_code() : last_reason();
  return got;
}

std::error_code write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const int count =
        ::_write(file, bytes.data(), static_cast<unsigned>(std::min(bytes.size(), kMostBytes)));
    if (count < 0) return c_reason();
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

std::error_code set_size(int file, std::uint64_t bytes) {
  const int failed = ::_chsize_s(file, static_cast<long long>(bytes));
  return {failed, std::generic_category()};
}

bool reserve(int file, std::uint64_t bytes, std::error_code& error) {
  error.clear();
  const HANDLE handle = handle_of(file);
  std::wstring name(32768, L'\0');
  name.resize(::GetFinalPathNameByHandleW(handle, name.data(), static_cast<DWORD>(name.size()), 0));
  ULARGE_INTEGER free{};
  const fs::path folder = fs::path(name).parent_path();
  if (::GetDiskFreeSpaceExW(folder.c_str(), &free, nullptr, nullptr) && free.QuadPart < bytes) {
    error = std::make_error_code(std::errc::no_space_on_device);
    return false;
  }
  FILE_ALLOCATION_INFO room{};
  room.AllocationSize.QuadPart = static_cast<LONGLONG>(bytes);
  if (::SetFileInformationByHandle(handle, FileAllocationInfo, &room, sizeof room)) return true;
  if (::GetLastError() == ERROR_DISK_FULL) error = last_reason();
  return false;
}

std::error_code rename_file(const fs::path& from, const fs::path& to, bool replaces) {
  const std::wstring old_name = system_name(from), new_name = system_name(to);
  std::error_code ignored;
  // Folders are not replaced, but one that is empty can go first; one that is not stays.
  if (replaces && fs::is_directory(from, ignored)) ::RemoveDirectoryW(new_name.c_str());
  constexpr int kAttempts = 4;
  constexpr DWORD kPause = 30;  // milliseconds; a virus scanner looks at what is new
  for (int attempt = 1;; ++attempt) {
    if (::MoveFileExW(old_name.c_str(), new_name.c_str(), replaces ? MOVEFILE_REPLACE_EXISTING : 0))
      return {};
    const DWORD failed = ::GetLastError();
    const bool stands = fs::exists(fs::symlink_status(to, ignored));
    if (!replaces && stands) return std::make_error_code(std::errc::file_exists);
    const bool may_pass = failed == ERROR_SHARING_VIOLATION || failed == ERROR_ACCESS_DENIED;
    if (!may_pass || attempt == kAttempts)
      return stands && fs::is_directory(to, ignored)
                 ? std::make_error_code(std::errc::directory_not_empty)
                 : reason_of(failed);
    ::Sleep(kPause);
  }
}

std::error_code link_in_place(const fs::path& from, const fs::path& to) {
  return rename_file(from, to, false);
}

std::optional<FileIdentity> identity_of(const fs::path& path) {
  const Handle file(open_handle(path, 0, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS));
  BY_HANDLE_FILE_INFORMATION all{};
  if (!file.is_open() || !::GetFileInformationByHandle(file.get(), &all)) return std::nullopt;
  return FileIdentity{all.dwVolumeSerialNumber,
                      (static_cast<std::uint64_t>(all.nFileIndexHigh) << 32) | all.nFileIndexLow};
}

fs::path comparable(const fs::path& path) {
  std::wstring name = fs::path(path).make_preferred().native();
  const auto size = static_cast<int>(name.size());
  std::wstring lower(name.size(), L'\0');
  if (::LCMapStringEx(LOCALE_NAME_INVARIANT, LCMAP_LOWERCASE, name.data(), size, lower.data(), size,
                      nullptr, nullptr, 0) == size)
    return lower;
  return name;
}

namespace {

bool is_device(std::wstring_view name) {
  std::wstring stem(name.substr(0, name.find(L'.')));
  stem.erase(stem.find_last_not_of(L' ') + 1);
  for (wchar_t& c : stem) c = static_cast<wchar_t>(std::towupper(c));
  constexpr std::array<std::wstring_view, 6> kDevices{L"CON", L"PRN",    L"AUX",
                                                      L"NUL", L"CONIN$", L"CONOUT$"};
  if (std::ranges::find(kDevices, stem) != kDevices.end()) return true;
  const bool is_port = stem.starts_with(L"COM") || stem.starts_with(L"LPT");
  return is_port && stem.size() == 4 && stem[3] >= L'1' && stem[3] <= L'9';
}

}  // namespace

std::string objection_to_name(const fs::path& path) {
  constexpr std::size_t kLongest = 255;
  const std::wstring name = path.filename().native();
  if (name == L"." || name == L"..") return {};
  if (name.size() > kLongest)
    return "no file name is longer than " + std::to_string(kLongest) +
           " letters; choose a shorter one";
  if (is_device(name)) return "it is the name of a device on Windows; choose another";
  if (name.ends_with(L'.') || name.ends_with(L' '))
    return "no file name ends in a dot or a blank on Windows; choose another";
  const bool has_sign = std::ranges::any_of(name, [](wchar_t c) {
    return c < L' ' || std::wstring_view(L"<>:\"|?*").find(c) != std::wstring_view::npos;
  });
  return has_sign ? "no file name has one of <>:\"|?* on Windows; choose another" : "";
}

fs::path with_end(const fs::path& name, const std::string& end) {
  constexpr std::size_t kShortName = 100;
  std::wstring text = name;
  if (text.size() > kShortName) {
    std::size_t kept = text.size() - end.size();
    if ((text[kept] & 0xfc00) == 0xdc00) --kept;  // the second half of a character
    text.resize(kept);
  }
  return text + path_of(end).native();
}

std::error_code may_read(const fs::path& path) {
  std::error_code error;
  (void)open_to_read(path, error);
  return error;
}

bool may_write_into(const fs::path& folder) {
  const Handle file(open_handle(hidden_name(folder), GENERIC_WRITE, CREATE_NEW,
                                FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE));
  return file.is_open();
}

fs::path make_temporary_folder(const fs::path& folder, std::error_code& error) {
  constexpr int kAttempts = 100;
  fs::path made;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    made = hidden_name(folder);
    const std::wstring name = system_name(made);
    error = result_of(::CreateDirectoryW(name.c_str(), nullptr));
    if (!error) ::SetFileAttributesW(name.c_str(), FILE_ATTRIBUTE_HIDDEN);
    if (error != std::errc::file_exists) break;
  }
  return made;
}

namespace {

constexpr std::size_t kLongestPath = 32768;

// The folder or file whose name fills so much of a buffer of kLongestPath.
void remove_named(wchar_t* name, std::size_t length) noexcept {
  if (::DeleteFileW(name)) return;
  const DWORD kind = ::GetFileAttributesW(name);
  if (kind == INVALID_FILE_ATTRIBUTES || !(kind & FILE_ATTRIBUTE_DIRECTORY)) return;
  // What a link leads to is none of ours.
  if (!(kind & FILE_ATTRIBUTE_REPARSE_POINT) && length + 3 < kLongestPath) {
    std::wcscpy(name + length, L"\\*");
    WIN32_FIND_DATAW entry;
    const HANDLE search = ::FindFirstFileW(name, &entry);
    bool has_more = search != INVALID_HANDLE_VALUE;
    while (has_more) {
      const std::size_t size = std::wcslen(entry.cFileName);
      const bool is_own =
          std::wcscmp(entry.cFileName, L".") == 0 || std::wcscmp(entry.cFileName, L"..") == 0;
      if (!is_own && length + 1 + size + 1 < kLongestPath) {
        std::wcscpy(name + length + 1, entry.cFileName);
        remove_named(name, length + 1 + size);
      }
      has_more = ::FindNextFileW(search, &entry) != 0;
    }
    if (search != INVALID_HANDLE_VALUE) ::FindClose(search);
    name[length] = L'\0';
  }
  ::RemoveDirectoryW(name);
}

}  // namespace

void remove_folder(const fs::path& folder) noexcept {
  constexpr std::size_t kBytes = kLongestPath * sizeof(wchar_t);
  auto* const name = static_cast<wchar_t*>(map_memory(kBytes));
  if (name == nullptr) return;
  kAnyLength.copy(name, kAnyLength.size());
  wchar_t* const whole = name + kAnyLength.size();
  const DWORD length = ::GetFullPathNameW(
      folder.c_str(), static_cast<DWORD>(kLongestPath - kAnyLength.size()), whole, nullptr);
  if (length > 0 && length < kLongestPath - kAnyLength.size()) {
    // Other machines' folders, and such names themselves, begin with two.
    const bool is_special = whole[0] == L'\\' && whole[1] == L'\\';
    remove_named(is_special ? whole : name, is_special ? length : length + kAnyLength.size());
  }
  unmap(name, kBytes);
}

File open_nameless(const fs::path& folder, std::error_code& error) {
  return opened(open_handle(hidden_name(folder), GENERIC_READ | GENERIC_WRITE | DELETE, CREATE_NEW,
                            FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE),
                _O_RDWR | _O_BINARY | _O_NOINHERIT, error);
}

namespace {

PROCESS_MEMORY_COUNTERS memory_of_process() {
  PROCESS_MEMORY_COUNTERS counters{};
  counters.cb = sizeof counters;
  ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &counters, sizeof counters);
  return counters;
}

}  // namespace

std::uint64_t free_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  ::GlobalMemoryStatusEx(&status);
  std::uint64_t available =
      std::min({status.ullAvailPhys, status.ullAvailPageFile, status.ullAvailVirtual});
  JOBOBJECT_EXTENDED_LIMIT_INFORMATION job{};
  if (::QueryInformationJobObject(nullptr, JobObjectExtendedLimitInformation, &job, sizeof job,
                                  nullptr) &&
      (job.BasicLimitInformation.LimitFlags & JOB_OBJECT_LIMIT_PROCESS_MEMORY)) {
    const std::uint64_t limit = job.ProcessMemoryLimit;
    available = std::min(available,
                         limit - std::min<std::uint64_t>(limit, memory_of_process().PagefileUsage));
  }
  return available;
}

std::uint64_t peak_memory() { return memory_of_process().PeakWorkingSetSize; }
std::uint64_t resident_memory() { return memory_of_process().WorkingSetSize; }

// The heap does of itself.
void keep_freed_memory() {}

void* map_memory(std::size_t bytes) noexcept {
  return ::VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
}

void* map_file(int file, std::size_t bytes, std::error_code& error) noexcept {
  // Makes the file as long, and takes its room.
  const Handle mapping(::CreateFileMappingW(handle_of(file), nullptr, PAGE_READWRITE,
                                            static_cast<DWORD>(std::uint64_t{bytes} >> 32),
                                            static_cast<DWORD>(bytes), nullptr));
  void* const array =
      mapping.is_open() ? ::MapViewOfFile(mapping.get(), FILE_MAP_WRITE, 0, 0, bytes) : nullptr;
  error = array != nullptr ? std::error_code() : last_reason();
  return array;
}

void unmap(void* array, std::size_t) noexcept {
  if (!::UnmapViewOfFile(array)) ::VirtualFree(array, 0, MEM_RELEASE);
}

void let_pages_go(void* array, std::size_t bytes) noexcept {
  // Of what was not locked it says so, and takes the pages out of the working set.
  ::VirtualUnlock(array, bytes);
}

namespace {

std::int64_t nanoseconds_of(const FILETIME& kernel, const FILETIME& user) {
  const auto hundreds = [](const FILETIME& time) {
    return static_cast<std::int64_t>((static_cast<std::uint64_t>(time.dwHighDateTime) << 32) |
                                     time.dwLowDateTime);
  };
  return 100 * (hundreds(kernel) + hundreds(user));
}

}  // namespace

std::int64_t thread_nanoseconds() {
  FILETIME made{}, ended{}, kernel{}, user{};
  ::GetThreadTimes(::GetCurrentThread(), &made, &ended, &kernel, &user);
  return nanoseconds_of(kernel, user);
}

std::int64_t process_nanoseconds() {
  FILETIME made{}, ended{}, kernel{}, user{};
  ::GetProcessTimes(::GetCurrentProcess(), &made, &ended, &kernel, &user);
  return nanoseconds_of(kernel, user);
}

std::string host_name() {
  std::array<wchar_t, 256> name{};
  auto size = static_cast<DWORD>(name.size());
  if (!::GetComputerNameExW(ComputerNamePhysicalDnsHostname, name.data(), &size)) return {};
  return utf8(fs::path(name.data()));
}

std::optional<std::string> environment(const char* name) {
  const std::wstring wide = path_of(name).native();
  const wchar_t* const value = ::_wgetenv(wide.c_str());
  if (value == nullptr) return std::nullopt;
  return utf8(fs::path(value));
}

std::vector<std::string> program_arguments(int, char**) {
  // What main() is given is in the code page, which lacks letters.
  int count = 0;
  wchar_t** const wide = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  std::vector<std::string> arguments;
  for (int i = 0; i < count; ++i) arguments.push_back(utf8(fs::path(wide[i])));
  ::LocalFree(wide);
  for (const int file : {kStandardInput, kStandardOutput, kStandardError})
    ::_setmode(file, _O_BINARY);
  if (is_terminal(kStandardOutput) || is_terminal(kStandardError)) ::SetConsoleOutputCP(CP_UTF8);
  return arguments;
}

namespace {

void (*note_ending)(int signal) = nullptr;
std::atomic<bool> has_ended = false;
HANDLE ending_noted = nullptr;

// On a thread of the system's.
BOOL WINAPI take_event(DWORD event) {
  // Back to the default after the first, so that the second ends the process.
  if (has_ended.exchange(true)) return FALSE;
  const bool is_interruption = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT;
  note_ending(is_interruption ? SIGINT : SIGTERM);
  ::SetEvent(ending_noted);
  // Of a closed window the process ends when this comes back.
  if (!is_interruption) ::Sleep(INFINITE);
  return TRUE;
}

}  // namespace

void on_ending(void (*note)(int signal)) {
  note_ending = note;
  ending_noted = ::CreateEventW(nullptr, TRUE, FALSE, nullptr);
  ::SetConsoleCtrlHandler(take_event, TRUE);
}

void wait_for_ending() { ::WaitForSingleObject(ending_noted, INFINITE); }

void sleep_for_ever() {
  for (;;) ::Sleep(INFINITE);
}

void end_by_broken_pipe() {
  constexpr int kAsElsewhere = 128 + 13;  // what shells say of SIGPIPE
  std::_Exit(kAsElsewhere);
}

bool is_terminal(int file) {
  DWORD mode = 0;
  return ::GetConsoleMode(handle_of(file), &mode) != 0;
}

bool moves_cursor(int file) {
  DWORD mode = 0;
  return ::GetConsoleMode(handle_of(file), &mode) &&
         ::SetConsoleMode(handle_of(file), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

std::optional<int> terminal_columns(int file) {
  CONSOLE_SCREEN_BUFFER_INFO screen{};
  if (!::GetConsoleScreenBufferInfo(handle_of(file), &screen)) return std::nullopt;
  return screen.srWindow.Right - screen.srWindow.Left + 1;
}

std::optional<fs::path> own_program() {
  std::wstring name(32768, L'\0');
  const DWORD size = ::GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size()));
  if (size == 0) return std::nullopt;
  name.resize(size);
  return name;
}

fs::path program_in(const fs::path& folder, const std::string& name) {
  return folder / path_of(name + ".exe");
}

bool is_program(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

std::vector<fs::path> program_folders() {
  const wchar_t* const path = ::_wgetenv(L"PATH");
  std::wstring_view left = path != nullptr ? path : L"";
  std::vector<fs::path> folders;
  while (!left.empty()) {
    const std::wstring_view folder = left.substr(0, left.find(L';'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    if (!folder.empty()) folders.emplace_back(folder);
  }
  return folders;
}

// planish-reconstruct, which alone is started, is not there for Windows.
struct ChildProcess::System {};
ChildProcess::ChildProcess() = default;
ChildProcess::~ChildProcess() = default;
std::error_code ChildProcess::start(const fs::path&) {
  return std::make_error_code(std::errc::function_not_supported);
}
ChildProcess::Ready ChildProcess::wait(bool, int, std::error_code& error) {
  error = std::make_error_code(std::errc::function_not_supported);
  return {};
}
std::size_t ChildProcess::send(std::span<const std::byte>) { return 0; }
void ChildProcess::end_sending() {}
std::optional<std::size_t> ChildProcess::receive(std::span<std::byte>) { return std::nullopt; }
Ending ChildProcess::wait_for_end() { return {}; }

std::string library_file(const std::string& name, int version) {
  return name + "-" + std::to_string(version) + ".dll";
}

void* load_library(const std::string& file, std::string& why) {
  void* const library = ::LoadLibraryExW(path_of(file).c_str(), nullptr, 0);
  if (library == nullptr) why = file + ": " + last_reason().message();
  return library;
}

void unload_library(void* library) { ::FreeLibrary(static_cast<HMODULE>(library)); }

Function function_of(void* library, const char* name) {
  return reinterpret_cast<Function>(::GetProcAddress(static_cast<HMODULE>(library), name));
}

}  // namespace planish::platform
