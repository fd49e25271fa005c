#include <pybind11/pybind11.h>

#include "bindings.h"
#include "errors.h"
#include "planish/core/version.h"

PYBIND11_MODULE(_planish, module) {
  namespace python = planish::python;
  module.doc() = "The compiled part of planish.";
  module.attr("__version__") = PLANISH_VERSION;
  python::register_errors();
  python::add_mesh(module);
  python::add_fit(module);
  python::add_limit(module);
  python::add_editor(module);
}
