#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "columns.hpp"
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
