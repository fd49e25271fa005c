#include "errors.h"

#include <pybind11/pybind11.h>

#include <exception>
#include <string_view>

#include "planish/core/error.h"

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

}  // namespace planish::python
