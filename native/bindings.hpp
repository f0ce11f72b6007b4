// What each file of bindings adds to the module.
#pragma once

#include <nanobind/nanobind.h>

namespace mitlplan {

void bind_zone(nanobind::module_& m);

}  // namespace mitlplan
