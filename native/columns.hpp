// What the bindings of searches share: columns by name, put together again as tables, and running interruptibly.
//
// Whatever is missing, of the wrong type or of the wrong length is a ValueError that names it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include "tables.hpp"
#include "watch.hpp"
#include "zone.hpp"

namespace mitlplan {

namespace nb = nanobind;

template <typename Entry>
using Column = nb::ndarray<const Entry, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// By name: integers, and arrays of them.
using NamedTables = nb::typed<nb::dict, nb::str, nb::object>;

/// The entries where they are. The dictionary keeps them: an array of another type is not converted, since the copy
/// would be gone when this returns.
template <typename Entry>
std::span<const Entry> view(const nb::dict& tables, const char* name) {
    if (!tables.contains(name)) throw nb::value_error((std::string("the tables lack ") + name).c_str());
    try {
        const auto array = nb::cast<Column<Entry>>(tables[name], false);
        return {array.data(), array.shape(0)};
    } catch (const nb::cast_error&) {
        throw nb::value_error((std::string("the wrong type of array: ") + name).c_str());
    }
}

template <typename Entry>
std::vector<Entry> column(const nb::dict& tables, const char* name) {
    const auto entries = view<Entry>(tables, name);
    return {entries.begin(), entries.end()};
}

inline Index number(const nb::dict& tables, const char* name) {
    if (!tables.contains(name)) throw nb::value_error((std::string("the tables lack ") + name).c_str());
    try {
        return nb::cast<Index>(tables[name]);
    } catch (const nb::cast_error&) {
        throw nb::value_error((std::string("not a small integer: ") + name).c_str());
    }
}

template <typename Entry>
Rows<Entry> rows(std::vector<Index> start, std::vector<Entry> entries) {
    detail::demand(detail::rises(start, start.empty() ? 0 : start.size() - 1, entries.size()), "rows");
    return {std::move(start), std::move(entries)};
}

inline Ticks checked(Ticks ticks) {
    if (ticks <= -tick_limit || ticks >= tick_limit) detail::throw_overflow();
    return ticks;
}

inline void same_length(std::size_t a, std::size_t b) { detail::demand(a == b, "columns of different lengths"); }

inline Rows<Constraint> read_guards(const nb::dict& from) {
    const auto clocks = column<Index>(from, "guard_clock");
    const auto uppers = column<std::uint8_t>(from, "guard_upper");
    const auto stricts = column<std::uint8_t>(from, "guard_strict");
    const auto values = column<Ticks>(from, "guard_value");
    same_length(clocks.size(), uppers.size());
    same_length(clocks.size(), stricts.size());
    same_length(clocks.size(), values.size());
    std::vector<Constraint> constraints;
    for (std::size_t k = 0; k < clocks.size(); ++k) {
        const Ticks bound = uppers[k] != 0 ? values[k] : -checked(values[k]);
        constraints.push_back({clocks[k], uppers[k] != 0, stricts[k] != 0 ? less(bound) : less_equal(bound)});
    }
    return rows(column<Index>(from, "guard_start"), std::move(constraints));
}

inline Rows<ClockBounds> read_bounds(const nb::dict& from) {
    const auto clocks = column<Index>(from, "bounds_clock");
    const auto lowers = column<Ticks>(from, "bounds_lower");
    const auto uppers = column<Ticks>(from, "bounds_upper");
    same_length(clocks.size(), lowers.size());
    same_length(clocks.size(), uppers.size());
    // Negative: the clock is never compared from that side.
    const auto constant = [](Ticks ticks) { return ticks < 0 ? no_bound : checked(ticks); };
    std::vector<ClockBounds> bounds;
    for (std::size_t k = 0; k < clocks.size(); ++k)
        bounds.push_back({clocks[k], constant(lowers[k]), constant(uppers[k])});
    return rows(column<Index>(from, "bounds_start"), std::move(bounds));
}

template <typename Entry>
auto to_array(std::vector<Entry> entries) {
    const std::size_t size = entries.size();
    auto owner = std::make_unique<std::vector<Entry>>(std::move(entries));
    Entry* const data = owner->data();
    const nb::capsule capsule(owner.release(),
                              [](void* held) noexcept { delete static_cast<std::vector<Entry>*>(held); });
    return nb::ndarray<nb::numpy, Entry, nb::ndim<1>>(data, {size}, capsule);
}

/// Lets a search run with the interpreter's lock released; Ctrl-C gets through.
template <typename Search>
int run_interruptibly(Search& search, double seconds, double limit) {
    const nb::gil_scoped_release unlocked;
    const auto interrupted = [] {
        const nb::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
    };
    return static_cast<int>(search.run(Seconds(seconds), Seconds(limit), interrupted));
}

}  // namespace mitlplan
