#include "work.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "planish/core/stop.h"

namespace py = pybind11;

namespace planish::python {
namespace {

constexpr std::chrono::milliseconds kLook{20};

class ReleasedWork {
 public:
  explicit ReleasedWork(const PythonCallbacks& python) : python_(python) {}

  void run(const std::function<void(const Callbacks&)>& work) {
    const Callbacks callbacks = library_callbacks();
    const bool asks = !python_.cancelled.is_none();
    {
      const py::gil_scoped_release released;
      std::thread worker([&] { do_work(work, callbacks); });
      std::unique_lock lock(mutex_);
      while (!ended_.wait_for(lock, kLook, [&] { return has_ended_; })) {
        lock.unlock();
        look(asks);
        lock.lock();
      }
      lock.unlock();
      worker.join();
    }
    if (raised_) std::rethrow_exception(raised_);
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void do_work(const std::function<void(const Callbacks&)>& work, const Callbacks& callbacks) {
    try {
      const StopScope scope(stop_);
      work(callbacks);
    } catch (...) {
      failure_ = std::current_exception();
    }
    const std::scoped_lock lock(mutex_);
    has_ended_ = true;
    ended_.notify_one();
  }

  // With Python's lock.
  void keep_raised() {
    if (!raised_) raised_ = std::current_exception();
    stop_ = true;
  }

  void look(bool asks) {
    const py::gil_scoped_acquire acquired;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (asks && !stop_ && py::bool_(python_.cancelled())) stop_ = true;
    } catch (const py::error_already_set&) {
      keep_raised();
    }
  }

  Callbacks library_callbacks() {
    Callbacks callbacks;
    if (python_.progress.is_none()) return callbacks;
    callbacks.progress = [this](std::string_view step, double fraction) {
      const py::gil_scoped_acquire acquired;
      if (stop_) return;
      try {
        python_.progress(py::str(step.data(), step.size()), fraction);
      } catch (const py::error_already_set&) {
        keep_raised();
      }
    };
    return callbacks;
  }

  const PythonCallbacks& python_;
  StopFlag stop_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::exception_ptr failure_, raised_;
};

}  // namespace

void run_released(const PythonCallbacks& python,
                  const std::function<void(const Callbacks&)>& work) {
  ReleasedWork(python).run(work);
}

}  // namespace planish::python
