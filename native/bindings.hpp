// What each file of bindings adds to the module.
#pragma once

#include <nanobind/nanobind.h>

namespace mitlplan {

void bind_zone(nanobind::module_& m);
void bind_search(nanobind::module_& m);
void bind_reachability(nanobind::module_& m);
void bind_schedule(nanobind::module_& m);
void bind_last_word(nanobind::module_& m);

}  // namespace mitlplan
