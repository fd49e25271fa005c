#include "call.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <string>
#include <string_view>

#include "arrays.h"
#include "keywords.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "planish/solve/backend.h"

namespace py = pybind11;

namespace planish::python {
namespace {

const char* class_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return "InvalidArgument";
    case ErrorCode::UnreadableInput:
      return "UnreadableInput";
    case ErrorCode::UnusableMesh:
      return "UnusableMesh";
    case ErrorCode::NoDevice:
      return "NoDevice";
    case ErrorCode::DeviceLost:
      return "DeviceLost";
    case ErrorCode::OutOfMemory:
      return "OutOfMemory";
    case ErrorCode::UnwritableOutput:
      return "UnwritableOutput";
    case ErrorCode::Cancelled:
      return "Cancelled";
  }
  return "Error";
}

void raise(const Failure& failure, const char* name) {
  const py::object type = py::module_::import("planish._errors").attr(name);
  const std::string_view text = failure.message;
  // Messages are made visible, but a path may be any bytes.
  const py::object message = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
  PyErr_SetObject(type.ptr(), type(message, failure.element).ptr());
}

}  // namespace

void register_errors() {
  // As pybind11 calls it.  NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const MissingProgram&) {
      raise(current_failure(""), "MissingProgram");
    } catch (const std::exception&) {
      const Failure failure =
          current_failure("out of memory; take a lower level or a smaller mesh");
      if (!failure.code) throw;
      raise(failure, class_name(*failure.code));
    }
  });
}

void refuse(const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); }

void warn(std::span<const Warning> warnings) {
  for (const Warning& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.message.c_str(), 1) != 0)
      throw py::error_already_set();
}

namespace {

constexpr std::chrono::milliseconds kLook{20};

// What functions of Python raise is kept while the library ends its work.
class ReleasedWork {
 public:
  explicit ReleasedWork(const PythonCallbacks& python) : python_(python) {}

  void run(const std::function<void(const Callbacks&)>& work) {
    std::exception_ptr failure;
    {
      const py::gil_scoped_release released;
      const Callbacks callbacks = library_callbacks();
      const HostScope host(callbacks);
      try {
        work(callbacks);
      } catch (...) {
        failure = std::current_exception();
      }
    }
    if (raised_) std::rethrow_exception(raised_);
    if (failure) std::rethrow_exception(failure);
  }

 private:
  using Clock = std::chrono::steady_clock;

  // Runs `call` with Python's lock.
  template <class Call>
  void in_python(const Call& call) {
    const py::gil_scoped_acquire acquired;
    try {
      call();
    } catch (const py::error_already_set&) {
      if (!raised_) raised_ = std::current_exception();
    }
  }

  // Of an exception or a signal, or as asked.
  bool is_cancelled() {
    if (!raised_ && Clock::now() - last_ >= kLook) {
      bool is_asked = false;
      in_python([&] {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        is_asked = !python_.cancelled.is_none() && py::bool_(python_.cancelled());
      });
      last_ = Clock::now();
      if (is_asked) return true;
    }
    return raised_ != nullptr;
  }

  Callbacks library_callbacks() {
    Callbacks callbacks;
    callbacks.cancelled = [this] { return is_cancelled(); };
    if (!python_.progress.is_none()) {
      callbacks.progress = [this](std::string_view step, double fraction) {
        if (raised_) return;
        in_python([&] { python_.progress(py::str(step.data(), step.size()), fraction); });
      };
    }
    return callbacks;
  }

  const PythonCallbacks& python_;
  // `cancelled` is asked at once, so that it stops short work, too.
  Clock::time_point last_ = python_.cancelled.is_none() ? Clock::now() : Clock::time_point();
  std::exception_ptr raised_;
};

}  // namespace

void run_released(const PythonCallbacks& python, const std::function<void(const Callbacks&)>& work,
                  int threads) {
  ReleasedWork(python).run([&](const Callbacks& callbacks) {
    make_cpu_backend({.thread_count = threads})->run_on_host([&] { work(callbacks); });
  });
}

Callbacks collecting(Callbacks callbacks, std::vector<Warning>& warnings) {
  callbacks.warning = [&warnings](const Warning& warning) { warnings.push_back(warning); };
  return callbacks;
}

namespace {

// Keywords, taken one by one.
class Keywords {
 public:
  Keywords(py::kwargs keywords, const char* function)
      : keywords_(std::move(keywords)), function_(function) {}

  [[nodiscard]] bool is_none(const char* name) const {
    return !keywords_.contains(name) || keywords_[name].is_none();
  }

  py::object take(const char* name) {
    if (!keywords_.contains(name)) return py::none();
    py::object value = keywords_[name];
    keywords_.attr("pop")(name);
    return value;
  }

  template <class Value>
  void take(const char* name, Value& target, const char* wanted) {
    const py::object value = take(name);
    if (value.is_none()) return;
    try {
      target = value.cast<Value>();
    } catch (const py::cast_error&) {
      refuse(formatted("{}: {}; {}", name, py::repr(value).cast<std::string>(), wanted));
    }
  }

  // Takes it where it is a number.
  bool take_number(const char* name, double& target) {
    const py::object value = keywords_[name];
    if (!PyFloat_Check(value.ptr()) && !PyLong_Check(value.ptr())) return false;
    take(name, target, "a number is wanted");
    return true;
  }

  void require_none_left() const {
    if (keywords_.empty()) return;
    const auto name = py::cast<std::string>((*keywords_.begin()).first);
    throw py::type_error(
        formatted("{}() got an unexpected keyword argument '{}'", function_, name));
  }

 private:
  py::kwargs keywords_;
  const char* function_;
};

std::string keyword_of_name(std::string_view name) { return keyword_of(*find_setting(name)); }

// A list, or one value, as flags have it: "2,1,0".
std::string list_text(const py::object& value) {
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value))
    return py::str(value).cast<std::string>();
  std::string text;
  for (const py::handle one : value) {
    if (!text.empty()) text += ',';
    text += py::str(one).cast<std::string>();
  }
  return text;
}

OptionValue value_of(Keywords& keywords, const OptionInfo& option, const std::string& name,
                     std::string& text) {
  OptionValue value;
  switch (option.kind) {
    case OptionKind::Whole:
      keywords.take(name.c_str(), value.whole, "a whole number is wanted");
      return value;
    case OptionKind::Number:
      keywords.take(name.c_str(), value.number, "a number is wanted");
      return value;
    case OptionKind::Switch:
      keywords.take(name.c_str(), value.is_on, "True or False is wanted");
      return value;
    case OptionKind::Words:
    case OptionKind::Wholes:
    case OptionKind::Numbers:
      text = list_text(keywords.take(name.c_str()));
      return parse_option(option, text, name);
    default:
      break;
  }
  if (option.kind == OptionKind::TextOrNumber && keywords.take_number(name.c_str(), value.number)) {
    text = shortest(value.number);
  } else {
    const std::string wanted = "one of " + choices_of(option) + " is wanted";
    keywords.take(name.c_str(), text, wanted.c_str());
  }
  value.text = text;
  return value;
}

template <class Target>
void take_option(Keywords& keywords, const Option<Target>& option, Target& target) {
  const std::string name = keyword_of(option);
  if (keywords.is_none(name.c_str())) return (void)keywords.take(name.c_str());
  std::string text;
  const OptionValue value = value_of(keywords, option, name, text);
  set_option(option, target, value, name);
}

}  // namespace

std::unique_ptr<Backend> FitArguments::make_backend() const {
  return make_cpu_backend({.solve_precision = solve_precision(settings), .thread_count = threads});
}

FitArguments fit_arguments(py::kwargs given, const char* function) {
  Keywords keywords(std::move(given), function);
  FitArguments result;
  const bool is_of_files = std::string_view(function).starts_with("fit_file");
  for (const FitOption& option : option_table())
    if (is_keyword(option) || (is_of_files && is_file_keyword(option)))
      take_option<FitSettings>(keywords, option, result.settings);
  if (is_of_files)
    for (const PointOption& option : point_option_table())
      take_option(keywords, option, result.settings.points);
  if (result.settings.creases.split_normals && !is_of_files)
    refuse("creases: normals are a file's; take fit_file(), or read() with split_normals");
  check_consistent(result.settings, keyword_of_name);
  constexpr int kMostThreads = 4096;
  keywords.take("threads", result.threads, "a whole number is wanted");
  if (result.threads < 0 || result.threads > kMostThreads)
    refuse(formatted("threads: {} is out of range; 0 to 4096 is wanted", result.threads));
  if (is_of_files) {
    const char* const wanted = "a number from 0 on is wanted";
    keywords.take("memory_limit", result.limits.memory_bytes, wanted);
    keywords.take("point_limit", result.limits.points, wanted);
    keywords.take("output_limit", result.limits.output_bytes, wanted);
    keywords.take("time_limit", result.limits.cpu_seconds, wanted);
  }
  result.callbacks.progress = keywords.take("progress");
  result.callbacks.cancelled = keywords.take("cancelled");
  result.mesh.visit([&](const char* name, py::object& value) {
    const bool is_taken = is_of_files && find_setting(name) != nullptr;
    value = is_taken ? py::none() : keywords.take(name);
  });
  keywords.require_none_left();
  return result;
}

Settings write_arguments(py::kwargs given, std::optional<int> level) {
  Keywords keywords(std::move(given), "write");
  Settings settings;
  if (level) settings.set_levels({*level});
  for (const FitOption& option : option_table())
    if (is_write_keyword(option)) take_option<FitSettings>(keywords, option, settings);
  keywords.require_none_left();
  if (settings.adaptive.count() > 1)
    refuse(keyword_of_name(settings.adaptive.kinds()[0]) + ": several are a file each; take one");
  check_consistent(settings, keyword_of_name);
  return settings;
}

FileReach reach_argument(const std::string& textures) {
  FitSettings settings;
  const FitOption& option = fit_option("textures");
  set_option(option, settings, {.text = textures}, keyword_of(option));
  return settings.textures;
}

namespace {

std::string keyword_text(const OptionInfo& option) {
  const std::string values = option.words.empty() ? std::string() : choices_of(option) + "; ";
  return formatted("\n    {}: {}{}", keyword_of(option), values, help_of(option));
}

}  // namespace

std::string keywords_text(bool (*is_wanted)(const OptionInfo&)) {
  std::string text;
  for (const FitOption& option : option_table())
    if (is_wanted(option)) text += keyword_text(option);
  return text;
}

std::string file_keywords() {
  std::string text = keywords_text(is_file_keyword);
  for (const PointOption& option : point_option_table()) text += keyword_text(option);
  return text;
}

std::string fit_keywords() {
  return keywords_text(is_keyword) +
         R"(
    threads: 0 takes all cores. Results are the same bits for any number.
    progress: progress(step, fraction) is called on this thread while work goes on: what is being
        done, and the fraction of the whole call that is done, which never falls and ends at 1.
    cancelled: cancelled() -> bool is asked every 20 ms; planish.Cancelled follows. Ctrl-C stops
        work as soon.)";
}

}  // namespace planish::python
