#include "work.h"

#include <chrono>
#include <exception>

#include "planish/backend/cpu_backend.h"
#include "planish/core/host_scope.h"

namespace py = pybind11;

namespace planish::python {
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

}  // namespace planish::python
