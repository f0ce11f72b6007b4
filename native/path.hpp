// What guards and invariants ask of the times of the joint steps of a path.
//
// Each is a constraint between two steps: the one that reads a clock and the one that reset it last. A step reads the
// guards of its edges; the open phase behind it keeps the invariants up to the next step. The columns are those of the
// tables, looked at where they are, because a map has a million edges and a path few steps; they and the path are not
// trusted.
#pragma once

#include "schedule.hpp"
#include "tables.hpp"

namespace mitlplan {

struct PathTables {
    Index clocks;
    std::size_t components;
    std::span<const Index> guard_start;
    std::span<const Index> guard_clock;
    std::span<const std::uint8_t> guard_upper;
    std::span<const std::uint8_t> guard_strict;
    std::span<const Ticks> guard_value;
    std::span<const Index> reset_start;
    std::span<const Index> reset_clock;
    std::span<const Index> move_target;
    std::span<const Index> move_guard;
    std::span<const Index> move_resets;
    std::span<const Index> last_guard;  // of the edges of transducers in the last step
    std::span<const Index> location_invariant;
    std::span<const Index> location_still;
};

namespace detail {

template <typename Entry>
Entry entry_of(std::span<const Entry> column, Index index) {
    demand(within(index, column.size()), "an index along a path");
    return column[static_cast<std::size_t>(index)];
}

}  // namespace detail

inline std::vector<Difference> differences(const PathTables& tables, std::span<const Index> steps) {
    using detail::demand;
    using detail::entry_of;
    demand(tables.components > 0 && !steps.empty() && steps.size() % tables.components == 0, "a path");
    demand(0 <= tables.clocks && tables.clocks <= clock_limit, "too many clocks");
    std::vector<Difference> found;
    std::vector<Index> reset_at(static_cast<std::size_t>(tables.clocks));
    std::vector<Index> locations(tables.components, none);
    const auto guarded = [&](Index guard, Index step) {
        const Index end = entry_of(tables.guard_start, guard + 1);
        for (Index k = entry_of(tables.guard_start, guard); k < end; ++k) {
            const Index origin = entry_of<Index>(reset_at, entry_of(tables.guard_clock, k));
            const Ticks value = entry_of(tables.guard_value, k);
            const bool strict = entry_of(tables.guard_strict, k) != 0;
            if (entry_of(tables.guard_upper, k) != 0) found.push_back({step, origin, -value, strict});
            else found.push_back({origin, step, value, strict});
        }
    };
    const auto count = static_cast<Index>(steps.size() / tables.components);
    for (Index step = 0; step < count; ++step) {
        const auto edges = steps.subspan(static_cast<std::size_t>(step) * tables.components, tables.components);
        const bool last = step == count - 1;
        if (step > 0) found.push_back({step - 1, step, 0, true});
        for (std::size_t component = 0; component < edges.size(); ++component)
            if (edges[component] != none)
                guarded(entry_of(last && component > 0 ? tables.last_guard : tables.move_guard, edges[component]), step);
        if (edges[0] == none) guarded(entry_of(tables.location_still, locations[0]), step);
        if (last) break;
        for (std::size_t component = 0; component < edges.size(); ++component) {
            if (edges[component] == none) continue;
            locations[component] = entry_of(tables.move_target, edges[component]);
            const Index resets = entry_of(tables.move_resets, edges[component]);
            const Index end = entry_of(tables.reset_start, resets + 1);
            for (Index k = entry_of(tables.reset_start, resets); k < end; ++k) {
                const Index clock = entry_of(tables.reset_clock, k);
                demand(detail::within(clock, reset_at.size()), "a reset names no clock");
                reset_at[static_cast<std::size_t>(clock)] = step;
            }
        }
        for (const Index location : locations) guarded(entry_of(tables.location_invariant, location), step + 1);
    }
    return found;
}

}  // namespace mitlplan
