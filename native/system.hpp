// A network of timed automata that move one by one, in pairs or by broadcast, as flat tables of integers.
//
// What UPPAAL and TChecker call a system: each component has locations with invariants, edges with guards, resets and
// maybe one side of a channel, and all share bounded integers. Tests and assignments of integers are small programs for
// a stack machine, validated once so that running them needs no checks of the stack. Clocks may stand still in
// locations that stop them. Nothing here is trusted: `validate` refuses tables that could lead a search outside them.
#pragma once

#include <array>
#include <optional>

#include "tables.hpp"

namespace mitlplan {

enum class Urgency : std::uint8_t { normal = 0, urgent = 1, committed = 2 };
inline constexpr std::uint8_t urgencies = 3;

/// What a program is made of; `push`, `load` and `store` are followed by a number or a variable.
enum class Word : Index { push, load, store, add, subtract, multiply, equal, unequal, less, at_most, greater, at_least };
inline constexpr std::size_t word_count = 12;

/// More than any expression in a model: programs run on a stack of this size.
inline constexpr std::size_t stack_size = 64;

/// A location of a component.
struct Place {
    Index invariant;  // a guard
    Index bounds;
    Index stopped;  // a set of clocks
    Urgency urgency;
};

/// An edge of a component.
struct Action {
    Index target;  // a location of the same component
    Index guard;
    Index resets;  // a set of clocks
    Index channel;  // or none
    bool sends;
    Index tests;  // a program
    Index updates;  // a program
};

struct Variable {
    Index least;
    Index most;
    Index initial;
};

/// A set of states: locations that must be taken, a guard, a test of the integers.
struct Aim {
    Index places;  // a set of locations, at most one a component
    Index guard;
    Index tests;
};

struct System {
    Index clocks = 0;  // with clock 0, the constant 0
    Index time_clock = none;  // never reset or stopped, the objective; or none
    Rows<Constraint> guards;
    Rows<Index> clock_sets;
    Rows<ClockBounds> bounds;
    Rows<Index> programs;
    Rows<Index> place_sets;
    std::vector<Variable> variables;
    std::vector<std::uint8_t> broadcast;  // by channel
    std::vector<Index> component_start;  // first location of each component, and the end
    std::vector<Index> initial;  // a location of each component
    std::vector<Place> places;
    std::vector<Index> action_start;  // by location
    std::vector<Action> actions;
    std::vector<Aim> aims;

    std::size_t components() const noexcept { return component_start.size() - 1; }
    /// Of a row that tells a state: the locations, then the integers.
    std::size_t width() const noexcept { return components() + variables.size(); }
    const Place& place(Index location) const noexcept { return places[static_cast<std::size_t>(location)]; }
    const Action& action(Index edge) const noexcept { return actions[static_cast<std::size_t>(edge)]; }
    std::size_t component_of(Index location) const noexcept {
        const auto above = std::upper_bound(component_start.begin(), component_start.end(), location);
        return static_cast<std::size_t>(above - component_start.begin()) - 1;
    }

    /// Runs a program on the integers of a state; false if a test fails or an integer leaves its range.
    bool run(Index program, std::span<Index> integers) const;
    void validate() const;

private:
    void validate_program(Index program) const;
};

inline bool System::run(Index program, std::span<Index> integers) const {
    std::array<Ticks, stack_size> stack{};
    std::size_t size = 0;
    const std::span<const Index> code = programs[program];
    for (std::size_t at = 0; at < code.size(); ++at) {
        const auto word = static_cast<Word>(code[at]);
        if (word == Word::push || word == Word::load) {
            const Index operand = code[++at];
            stack[size++] = word == Word::push ? operand : integers[static_cast<std::size_t>(operand)];
            continue;
        }
        if (word == Word::store) {
            const auto variable = static_cast<std::size_t>(code[++at]);
            const Ticks stored = stack[--size];
            if (stored < variables[variable].least || stored > variables[variable].most) return false;
            integers[variable] = static_cast<Index>(stored);
            continue;
        }
        const Ticks right = stack[--size];
        const Ticks left = stack[--size];
        Ticks result = 0;
        bool overflows = false;
        bool holds = true;
        switch (word) {
            case Word::add: overflows = __builtin_add_overflow(left, right, &result); break;
            case Word::subtract: overflows = __builtin_sub_overflow(left, right, &result); break;
            case Word::multiply: overflows = __builtin_mul_overflow(left, right, &result); break;
            case Word::equal: holds = left == right; break;
            case Word::unequal: holds = left != right; break;
            case Word::less: holds = left < right; break;
            case Word::at_most: holds = left <= right; break;
            case Word::greater: holds = left > right; break;
            default: holds = left >= right; break;
        }
        if (overflows) throw std::overflow_error("an integer expression leaves 64 bits");
        if (!holds) return false;
        if (word <= Word::multiply) stack[size++] = result;
    }
    return true;
}

inline void System::validate_program(Index program) const {
    using detail::demand;
    std::size_t size = 0;
    const std::span<const Index> code = programs[program];
    for (std::size_t at = 0; at < code.size(); ++at) {
        demand(detail::within(code[at], word_count), "a word of a program");
        const auto word = static_cast<Word>(code[at]);
        if (word <= Word::store) {
            demand(++at < code.size(), "a program ends too early");
            demand(word == Word::push || detail::within(code[at], variables.size()), "a variable");
        }
        const std::size_t taken = word <= Word::load ? 0 : word == Word::store ? 1 : 2;
        demand(size >= taken, "a program takes more than there is");
        size -= taken;
        size += word <= Word::load || (word >= Word::add && word <= Word::multiply) ? 1 : 0;
        demand(size <= stack_size, "an integer expression is nested too deeply");
    }
    demand(size == 0, "a program leaves something behind");
}

inline void System::validate() const {
    using detail::demand;
    using detail::within;
    demand(clocks >= 1 && clocks <= clock_limit, "no clock, or too many");
    const auto clock_count = static_cast<std::size_t>(clocks);
    const auto is_clock = [&](Index clock) { return clock > 0 && within(clock, clock_count); };
    demand(time_clock == none || is_clock(time_clock), "the objective is no clock");
    for (const Constraint& each : guards.entries)
        demand(is_clock(each.clock) && each.clock != time_clock, "a guard names no clock, or the time");
    for (const Index clock : clock_sets.entries)
        demand(is_clock(clock) && clock != time_clock, "a set names no clock, or the time");
    for (const ClockBounds& each : bounds.entries)
        demand(is_clock(each.clock) && each.clock != time_clock, "a bound names no clock, or the time");
    for (const Variable& each : variables)
        demand(each.least <= each.initial && each.initial <= each.most, "the range of an integer");
    for (Index program = 0; program < programs.count(); ++program) validate_program(program);
    demand(component_start.size() >= 2, "no component");
    demand(detail::rises(component_start, component_start.size() - 1, places.size()), "components");
    demand(components() <= static_cast<std::size_t>(component_limit), "too many components");
    demand(initial.size() == components(), "the locations to begin in");
    for (std::size_t component = 0; component < components(); ++component)
        demand(component_start[component] <= initial[component] && initial[component] < component_start[component + 1],
               "the location to begin in");
    const auto guard_count = static_cast<std::size_t>(guards.count());
    const auto set_count = static_cast<std::size_t>(clock_sets.count());
    const auto program_count = static_cast<std::size_t>(programs.count());
    for (const Place& each : places) {
        demand(within(each.invariant, guard_count), "an invariant");
        demand(within(each.bounds, static_cast<std::size_t>(bounds.count())), "bounds of a location");
        demand(within(each.stopped, set_count), "stopped clocks");
        demand(static_cast<std::uint8_t>(each.urgency) < urgencies, "an urgency");
    }
    demand(detail::rises(action_start, places.size(), actions.size()), "edges");
    for (std::size_t component = 0; component < components(); ++component)
        for (Index location = component_start[component]; location < component_start[component + 1]; ++location)
            for (Index edge = action_start[static_cast<std::size_t>(location)];
                 edge < action_start[static_cast<std::size_t>(location) + 1]; ++edge) {
                const Action& each = action(edge);
                demand(component_start[component] <= each.target && each.target < component_start[component + 1],
                       "the target of an edge");
                demand(within(each.guard, guard_count), "the guard of an edge");
                demand(within(each.resets, set_count), "the resets of an edge");
                demand(each.channel == none || within(each.channel, broadcast.size()), "the channel of an edge");
                demand(within(each.tests, program_count), "the tests of an edge");
                demand(within(each.updates, program_count), "the updates of an edge");
            }
    for (const Index location : place_sets.entries) demand(within(location, places.size()), "a location of an aim");
    for (const Aim& each : aims) {
        demand(within(each.places, static_cast<std::size_t>(place_sets.count())), "the locations of an aim");
        demand(within(each.guard, guard_count), "the guard of an aim");
        demand(within(each.tests, program_count), "the tests of an aim");
    }
}

}  // namespace mitlplan
