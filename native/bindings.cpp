// The native module, mitlplan._core: integers in, integers out. What each half offers stands in its own file.
#include "bindings.hpp"

#include <nanobind/nanobind.h>

NB_MODULE(_core, m) {
    m.doc() = "Native half of mitlplan: zones, and the search over them. Times are ticks (integers).";
    mitlplan::bind_zone(m);
    mitlplan::bind_search(m);
    mitlplan::bind_reachability(m);
    mitlplan::bind_schedule(m);
    mitlplan::bind_last_word(m);
}
