#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "columns.hpp"
#include "path.hpp"
#include "schedule.hpp"

namespace mitlplan {

namespace {

std::vector<Difference> read_differences(std::int32_t steps, const Column<std::int32_t>& from,
                                         const Column<std::int32_t>& to, const Column<Ticks>& weight,
                                         const Column<std::uint8_t>& strict) {
    if (steps < 1) throw nb::value_error("a path has a first step");
    if (to.shape(0) != from.shape(0) || weight.shape(0) != from.shape(0) || strict.shape(0) != from.shape(0))
        throw nb::value_error("columns of different lengths");
    std::vector<Difference> differences;
    for (std::size_t k = 0; k < from.shape(0); ++k) {
        const Difference difference{from(k), to(k), weight(k), strict(k) != 0};
        if (difference.from < 0 || difference.from >= steps || difference.to < 0 || difference.to >= steps)
            throw nb::value_error("a constraint names no step");
        if (difference.weight <= -tick_limit || difference.weight >= tick_limit) detail::throw_overflow();
        differences.push_back(difference);
    }
    return differences;
}

}  // namespace

void bind_schedule(nb::module_& module) {
    module.def(
        "differences",
        [](const NamedTables& tables, const Column<Index>& steps, const std::string& last) {
            const PathTables columns{
                .clocks = number(tables, "clocks"),
                .components = view<Index>(tables, "component_start").size() - 1,
                .guard_start = view<Index>(tables, "guard_start"),
                .guard_clock = view<Index>(tables, "guard_clock"),
                .guard_upper = view<std::uint8_t>(tables, "guard_upper"),
                .guard_strict = view<std::uint8_t>(tables, "guard_strict"),
                .guard_value = view<Ticks>(tables, "guard_value"),
                .reset_start = view<Index>(tables, "reset_start"),
                .reset_clock = view<Index>(tables, "reset_clock"),
                .move_target = view<Index>(tables, "move_target"),
                .move_guard = view<Index>(tables, "move_guard"),
                .move_resets = view<Index>(tables, "move_resets"),
                .last_guard = view<Index>(tables, (last + "_guard").c_str()),
                .location_invariant = view<Index>(tables, "location_invariant"),
                .location_still = view<Index>(tables, "location_still"),
            };
            const auto found = differences(columns, {steps.data(), steps.shape(0)});
            std::vector<Index> from;
            std::vector<Index> to;
            std::vector<Ticks> weight;
            std::vector<std::uint8_t> strict;
            for (const Difference& one : found) {
                from.push_back(one.from);
                to.push_back(one.to);
                weight.push_back(one.weight);
                strict.push_back(one.strict);
            }
            return std::tuple(to_array(std::move(from)), to_array(std::move(to)), to_array(std::move(weight)),
                              to_array(std::move(strict)));
        },
        nb::arg("tables"), nb::arg("steps"), nb::arg("last"),
        "What guards and invariants ask of the times of the steps of a path, a row of edges each, the last one of the "
        "kind `last`: sources, targets, weights and strictness, as `earliest_times` takes them.");
    module.def(
        "earliest_times",
        [](std::int32_t steps, const Column<std::int32_t>& from, const Column<std::int32_t>& to,
           const Column<Ticks>& weight, const Column<std::uint8_t>& strict) {
            const auto times = earliest_times(steps, read_differences(steps, from, to, weight, strict));
            std::vector<std::pair<Ticks, std::int64_t>> result;
            for (const auto& time : times) result.emplace_back(time.ticks, time.infinitesimals);
            return result;
        },
        nb::arg("steps"), nb::arg("source"), nb::arg("target"), nb::arg("weight"), nb::arg("strict"),
        "The least times, as ticks and infinitesimals, with t[target] - t[source] >= weight (> if strict), t[0] = 0.");
    module.def(
        "latest_times",
        [](const Column<Ticks>& planned, const Column<std::int32_t>& from, const Column<std::int32_t>& to,
           const Column<Ticks>& weight, const Column<std::uint8_t>& strict, const Column<std::int32_t>& asked) {
            const auto steps = static_cast<std::int32_t>(planned.shape(0));
            const auto differences = read_differences(steps, from, to, weight, strict);
            for (std::size_t k = 0; k < asked.shape(0); ++k)
                if (asked(k) < 0 || asked(k) >= steps) throw nb::value_error("no such step");
            auto times = latest_times({planned.data(), planned.shape(0)}, differences, {asked.data(), asked.shape(0)});
            for (Ticks& time : times)
                if (time == unlimited) time = -1;
            return times;
        },
        nb::arg("planned"), nb::arg("source"), nb::arg("target"), nb::arg("weight"), nb::arg("strict"),
        nb::arg("asked"),
        "How late each asked step may happen, the steps before it as planned; -1 where nothing bounds it.");
}

}  // namespace mitlplan
