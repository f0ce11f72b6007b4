// A network of timed automata as flat tables of integers, the only thing that crosses the border.
//
// Component 0 is the driver: its edges are tried one by one, and it may also stand still. All components move in
// lock step; each edge reads a set of boolean signals and sets others, which components further back may read.
// Guards, resets, signal sets and clock bounds are interned: an edge names them by index, because a map has a
// million edges and a handful of different guards. Nothing here is trusted: `validate` refuses tables that could
// lead a search outside of them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bound.hpp"

namespace mitlplan {

using Index = std::int32_t;

inline constexpr Index none = -1;

/// More than any formula makes: zones are quadratic in the clocks, and the recursion is as deep as the components.
inline constexpr Index clock_limit = 1 << 14;
inline constexpr Index component_limit = 1 << 12;

/// How a step goes on: by an open phase, not at all, or by a label that never changes again.
enum class StepKind : Index { move = 0, ending = 1, parking = 2 };
inline constexpr std::size_t step_kinds = 3;

/// Whether a step of which the driver is no part is worth trying.
inline constexpr Index restless_never = -1;
inline constexpr Index restless_always = -2;

/// One upper or lower bound on one clock.
struct Constraint {
    Index clock;
    bool upper;  // clock <= or < value; else value <= or < clock
    Bound bound;  // of the matching entry of a zone
};

/// The largest constants a clock is still compared with.
struct ClockBounds {
    Index clock;
    Ticks lower;
    Ticks upper;
};

/// Rows of different lengths, one behind the other.
template <typename Entry>
struct Rows {
    std::vector<Index> start{0};
    std::vector<Entry> entries;

    Index count() const noexcept { return static_cast<Index>(start.size()) - 1; }
    std::span<const Entry> operator[](Index row) const noexcept {
        const auto first = static_cast<std::size_t>(start[static_cast<std::size_t>(row)]);
        const auto last = static_cast<std::size_t>(start[static_cast<std::size_t>(row) + 1]);
        return std::span<const Entry>(entries).subspan(first, last - first);
    }
};

struct Edge {
    Index target;  // a location of the same component
    Index guard;
    Index resets;
    Index reads;  // set of signals that must be set
    Index avoids;  // set of signals that must not be
    Index emits;
    Index marks;  // the number of the Büchi set it visits, from 1, or 0
};

struct Location {
    Index invariant;
    Index still;  // guard of a step in which the component makes no move; driver only
    Index bounds;
    Index emits;  // driver only
    Index restless;  // never, always, or the signal that must be set
    Index target;  // a distance field, or none
    Index deadline_clock;  // or none
    Ticks deadline;
    Index relief;  // a location of the same component that owes less, or none
};

struct Tables {
    Index clocks = 0;  // with clock 0, the constant 0
    Index time_clock = none;  // the objective, or none
    Index driver_clock = none;  // reset by every move of the driver, or none
    Index words = 1;  // of a set of signals
    Rows<Constraint> guards;
    Rows<Index> resets;
    std::vector<std::uint64_t> signals;  // sets of `words` words each
    Rows<ClockBounds> bounds;
    std::vector<Index> component_start;  // first location of each component, and the end
    std::vector<Location> locations;
    std::array<std::vector<Index>, step_kinds> edge_start;  // by location, for each kind of step
    std::array<std::vector<Edge>, step_kinds> edges;
    std::vector<std::uint8_t> parkable;  // by location of the driver
    std::vector<Ticks> distances;  // fields x driver locations; negative: unreachable

    Index components() const noexcept { return static_cast<Index>(component_start.size()) - 1; }
    Index driver_locations() const noexcept { return component_start[1]; }
    Index fields() const noexcept {
        return static_cast<Index>(distances.size() / static_cast<std::size_t>(driver_locations()));
    }
    std::span<const std::uint64_t> signal_set(Index set) const noexcept {
        const auto width = static_cast<std::size_t>(words);
        return std::span(signals).subspan(static_cast<std::size_t>(set) * width, width);
    }
    std::span<const Edge> edges_of(StepKind kind, Index location) const noexcept {
        const auto& start = edge_start[static_cast<std::size_t>(kind)];
        const auto first = static_cast<std::size_t>(start[static_cast<std::size_t>(location)]);
        const auto last = static_cast<std::size_t>(start[static_cast<std::size_t>(location) + 1]);
        return std::span(edges[static_cast<std::size_t>(kind)]).subspan(first, last - first);
    }
    Ticks distance(Index field, Index driver_location) const noexcept {
        return distances[static_cast<std::size_t>(field) * static_cast<std::size_t>(driver_locations()) +
                         static_cast<std::size_t>(driver_location)];
    }

    void validate() const;
};

namespace detail {

inline void demand(bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("the tables of the network are damaged: ") + what);
}

inline bool within(Index index, std::size_t count) noexcept {
    return index >= 0 && static_cast<std::size_t>(index) < count;
}

inline bool rises(std::span<const Index> start, std::size_t rows, std::size_t entries) noexcept {
    if (start.size() != rows + 1 || start.front() != 0) return false;
    for (std::size_t row = 0; row < rows; ++row)
        if (start[row + 1] < start[row]) return false;
    return static_cast<std::size_t>(start.back()) == entries;
}

}  // namespace detail

inline void Tables::validate() const {
    using detail::demand;
    using detail::rises;
    using detail::within;
    demand(clocks >= 1 && words >= 1, "no clock or no signal");
    demand(clocks <= clock_limit, "too many clocks");
    const auto clock_count = static_cast<std::size_t>(clocks);
    const auto is_clock = [&](Index clock) { return clock > 0 && within(clock, clock_count); };
    demand(time_clock == none || is_clock(time_clock), "the objective is no clock");
    demand(driver_clock == none || is_clock(driver_clock), "the driver has no clock");
    for (const auto& constraint : guards.entries) demand(is_clock(constraint.clock), "a guard names no clock");
    for (const Index clock : resets.entries)
        demand(is_clock(clock) && clock != time_clock, "a reset names no clock, or the time");
    for (const auto& bound : bounds.entries)
        demand(is_clock(bound.clock) && bound.clock != time_clock, "a bound names no clock, or the time");
    demand(rises(guards.start, guards.start.size() - 1, guards.entries.size()), "guards");
    demand(rises(resets.start, resets.start.size() - 1, resets.entries.size()), "resets");
    demand(rises(bounds.start, bounds.start.size() - 1, bounds.entries.size()), "bounds");
    demand(signals.size() % static_cast<std::size_t>(words) == 0, "signals");
    const std::size_t sets = signals.size() / static_cast<std::size_t>(words);
    demand(component_start.size() >= 2, "no component");
    demand(rises(component_start, component_start.size() - 1, locations.size()), "components");
    demand(components() <= component_limit, "too many components");
    for (std::size_t component = 0; component + 1 < component_start.size(); ++component)
        demand(component_start[component] < component_start[component + 1], "a component without a location");
    demand(parkable.size() == static_cast<std::size_t>(driver_locations()), "parkable");
    demand(distances.size() % static_cast<std::size_t>(driver_locations()) == 0, "distances");
    for (const auto& location : locations) {
        demand(within(location.invariant, static_cast<std::size_t>(guards.count())), "an invariant");
        demand(within(location.still, static_cast<std::size_t>(guards.count())), "a guard for standing still");
        demand(within(location.bounds, static_cast<std::size_t>(bounds.count())), "bounds of a location");
        demand(within(location.emits, sets), "signals of a location");
        demand(location.restless >= restless_always && location.restless < words * 64, "a restless signal");
        demand(location.target == none || within(location.target, static_cast<std::size_t>(fields())), "a target");
        demand(location.deadline_clock == none || is_clock(location.deadline_clock), "a deadline");
        demand(-tick_limit < location.deadline && location.deadline < tick_limit, "a deadline is too large");
    }
    for (const Ticks distance : distances) demand(distance < tick_limit, "a distance is too large");
    for (std::size_t kind = 0; kind < step_kinds; ++kind) {
        demand(rises(edge_start[kind], locations.size(), edges[kind].size()), "edges");
        for (Index component = 0; component < components(); ++component) {
            const Index first = component_start[static_cast<std::size_t>(component)];
            const Index last = component_start[static_cast<std::size_t>(component) + 1];
            for (Index location = first; location < last; ++location) {
                const Index relief = locations[static_cast<std::size_t>(location)].relief;
                // Chains of reliefs end, because they lead to locations further to the front.
                demand(relief == none || (first <= relief && relief < location), "a relief");
                for (const Edge& edge : edges_of(static_cast<StepKind>(kind), location)) {
                    demand(first <= edge.target && edge.target < last, "the target of an edge");
                    demand(within(edge.guard, static_cast<std::size_t>(guards.count())), "the guard of an edge");
                    demand(within(edge.resets, static_cast<std::size_t>(resets.count())), "the resets of an edge");
                    demand(within(edge.marks, 64), "the Büchi set of an edge");
                    demand(within(edge.reads, sets) && within(edge.avoids, sets) && within(edge.emits, sets),
                           "the signals of an edge");
                }
            }
        }
    }
}

}  // namespace mitlplan
