// Zones for Python, so that property tests can hold them against a slow matrix. The search never comes this way.
//
// A Python zone is a value: every operation returns a new one, hence an overflow spoils nothing. All that Python
// sends is validated here, because the operations themselves trust their arguments.
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "zone.hpp"

namespace mitlplan {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

// A bound as Python sees it: (value, strict), or None for infinity.
using Pair = std::optional<std::pair<Ticks, bool>>;

constexpr int dimension_limit = 1024;

Bound from_pair(const Pair& pair) {
    if (!pair) return infinity;
    return pair->second ? less(pair->first) : less_equal(pair->first);
}

Pair to_pair(Bound bound) {
    if (bound == infinity) return std::nullopt;
    return std::pair{value(bound), is_strict(bound)};
}

int checked_dimension(std::size_t dimension) {
    if (dimension < 1 || dimension > dimension_limit)
        throw std::invalid_argument("a zone has between 1 and 1024 clocks, the reference included");
    return static_cast<int>(dimension);
}

int checked_dimension(int dimension) { return checked_dimension(static_cast<std::size_t>(std::max(dimension, 0))); }

void check_index(const Zone& zone, int i) {
    if (i < 0 || i >= zone.dimension()) throw std::invalid_argument("the zone has no such clock");
}

void check_clock(const Zone& zone, int i) {
    check_index(zone, i);
    if (i == 0) throw std::invalid_argument("clock 0 is the reference and always 0");
}

void check_same_dimension(const Zone& a, const Zone& b) {
    if (a.dimension() != b.dimension()) throw std::invalid_argument("the zones have different dimensions");
}

Zone from_matrix(const std::vector<std::vector<Pair>>& rows) {
    const int dimension = checked_dimension(rows.size());
    for (const auto& row : rows)
        if (row.size() != rows.size()) throw std::invalid_argument("the matrix is not square");
    std::vector<Bound> matrix(dbm::size(dimension));
    for (int i = 0; i < dimension; ++i)
        for (int j = 0; j < dimension; ++j)
            matrix[dbm::entry(dimension, i, j)] =
                from_pair(rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
    return Zone::from_matrix(matrix, dimension);
}

std::vector<Ticks> largest_constants(const Zone& zone, const std::vector<std::optional<Ticks>>& constants) {
    if (constants.size() != static_cast<std::size_t>(zone.dimension()))
        throw std::invalid_argument("one constant for each clock, the reference included, or None");
    std::vector<Ticks> largest;
    for (const auto& constant : constants) {
        if (constant && *constant < 0) throw std::invalid_argument("the constants are not negative");
        largest.push_back(constant ? value(less(*constant)) : no_bound);
    }
    return largest;
}

}  // namespace

void bind_zone(nb::module_& m) {
    nb::class_<Zone>(m, "Zone", "A set of clock valuations, as a closed difference bound matrix; a value.")
        .def_static(
            "zero", [](int dimension) { return Zone::zero(checked_dimension(dimension)); }, "dimension"_a,
            "Every clock is 0.")
        .def_static(
            "universe", [](int dimension) { return Zone::universe(checked_dimension(dimension)); },
            "dimension"_a, "Every clock has any value >= 0.")
        .def_static("from_matrix", &from_matrix, "rows"_a,
                    "The valuations, of clocks >= 0, that satisfy every entry: (value, strict), or None.")
        .def_prop_ro("dimension", &Zone::dimension, "The number of clocks, the reference included.")
        .def_prop_ro("empty", &Zone::empty, "Whether no valuation is left.")
        .def(
            "at",
            [](const Zone& zone, int i, int j) {
                check_index(zone, i);
                check_index(zone, j);
                return to_pair(zone.at(i, j));
            },
            "i"_a, "j"_a, "The bound on x_i - x_j: (value, strict), or None for infinity.")
        .def(
            "constrain",
            [](Zone zone, int i, int j, Ticks value, bool strict) {
                check_index(zone, i);
                check_index(zone, j);
                zone.constrain(i, j, strict ? less(value) : less_equal(value));
                return zone;
            },
            "i"_a, "j"_a, "value"_a, "strict"_a = false, "The part where x_i - x_j <= value, or < value.")
        .def(
            "up",
            [](Zone zone) {
                zone.up();
                return zone;
            },
            "Any time >= 0 passes.")
        .def(
            "up_strict",
            [](Zone zone) {
                zone.up_strict();
                return zone;
            },
            "Any time > 0 passes.")
        .def(
            "up_partly",
            [](Zone zone, const std::vector<int>& stopped) {
                std::vector<std::uint8_t> stands_still(static_cast<std::size_t>(zone.dimension()));
                for (const int i : stopped) {
                    check_clock(zone, i);
                    stands_still[static_cast<std::size_t>(i)] = 1;
                }
                zone.up_partly(stands_still);
                return zone;
            },
            "stopped"_a, "Any time >= 0 passes for the other clocks: the least zone around what is then possible.")
        .def(
            "reset",
            [](Zone zone, int i, Ticks value) {
                check_clock(zone, i);
                if (value < 0) throw std::invalid_argument("a clock is never negative");
                zone.reset(i, value);
                return zone;
            },
            "i"_a, "value"_a = 0, "x_i := value.")
        .def(
            "free",
            [](Zone zone, int i) {
                check_clock(zone, i);
                zone.free(i);
                return zone;
            },
            "i"_a, "x_i has any value >= 0.")
        .def(
            "intersect",
            [](Zone zone, const Zone& other) {
                check_same_dimension(zone, other);
                zone.intersect(other);
                return zone;
            },
            "other"_a, "The valuations of both.")
        .def(
            "intersects",
            [](const Zone& zone, const Zone& other) {
                check_same_dimension(zone, other);
                return zone.intersects(other);
            },
            "other"_a, "Whether some valuation is in both.")
        .def(
            "includes",
            [](const Zone& zone, const Zone& other) {
                check_same_dimension(zone, other);
                return zone.includes(other);
            },
            "other"_a, "Whether every valuation of the other is in this one.")
        .def(
            "simulates",
            [](const Zone& zone, const Zone& other, const std::vector<std::optional<Ticks>>& lower,
               const std::vector<std::optional<Ticks>>& upper) {
                check_same_dimension(zone, other);
                return zone.simulates(other, largest_constants(zone, lower), largest_constants(zone, upper));
            },
            "other"_a, "lower"_a, "upper"_a,
            "Whether each valuation of the other is simulated by one of this: the other lies in a_LU of this.")
        .def(
            "extrapolate_lu_plus",
            [](Zone zone, const std::vector<std::optional<Ticks>>& lower,
               const std::vector<std::optional<Ticks>>& upper) {
                zone.extrapolate_lu_plus(largest_constants(zone, lower), largest_constants(zone, upper));
                return zone;
            },
            "lower"_a, "upper"_a,
            "Extra+_LU: the largest constants each clock is compared with from below and above, or None.")
        .def(
            "remap",
            [](const Zone& zone, const std::vector<int>& source) {
                checked_dimension(source.size());
                for (const int i : source)
                    if (i != fresh_clock) check_index(zone, i);
                if (source[0] != 0) throw std::invalid_argument("clock 0 comes from clock 0");
                return zone.remap(source);
            },
            "source"_a, "The zone whose clock k is clock source[k] of this one, or a new clock, 0, for -1.")
        .def(
            "project",
            [](const Zone& zone, const std::vector<int>& kept) {
                checked_dimension(kept.size() + 1);
                for (const int i : kept) check_clock(zone, i);
                return zone.project(kept);
            },
            "kept"_a, "The zone of the kept clocks alone, in that order.")
        .def(
            "__eq__", [](const Zone& a, const Zone& b) { return a.equals(b); }, nb::is_operator(),
            nb::sig("def __eq__(self, other: object, /) -> bool"))
        .def("__hash__", &Zone::hash);
}

}  // namespace mitlplan
