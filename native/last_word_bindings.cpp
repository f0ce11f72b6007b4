// The last word for Python, which says when, what and with which exit code.
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "last_word.hpp"

namespace mitlplan {

void bind_last_word(nanobind::module_& m) {
    namespace nb = nanobind;
    m.def(
        "have_the_last_word",
        [](int descriptor, const std::vector<std::tuple<int, double, int, std::string>>& words) {
            std::vector<LastWord> kept;
            for (const auto& [signal, patience, code, sentence] : words) {
                if (!(patience >= 0) || patience > 1e6) throw nb::value_error("a patience out of range");
                kept.push_back({signal, patience, code, sentence});
            }
            have_the_last_word(descriptor, std::move(kept));
        },
        nb::arg("descriptor"), nb::arg("words"),
        "From now on a signal whose number can be read from the descriptor ends the process after so many seconds, "
        "with an exit code and a sentence on stderr, unless a 0 is read before. A word is (signal, seconds, code, "
        "sentence).");
}

}  // namespace mitlplan
