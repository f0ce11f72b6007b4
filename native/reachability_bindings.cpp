// The search for a state of an aim as Python sees it, in the manner of search_bindings.cpp.
#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "columns.hpp"
#include "reachability.hpp"

namespace mitlplan {

namespace {

System read_system(const nb::dict& from) {
    System system;
    system.clocks = number(from, "clocks");
    system.time_clock = number(from, "time_clock");
    system.guards = read_guards(from);
    system.bounds = read_bounds(from);
    system.clock_sets = rows(column<Index>(from, "clock_set_start"), column<Index>(from, "clock_set_clock"));
    system.programs = rows(column<Index>(from, "program_start"), column<Index>(from, "program_word"));
    system.place_sets = rows(column<Index>(from, "place_set_start"), column<Index>(from, "place_set_place"));
    const auto least = column<Index>(from, "variable_least");
    const auto most = column<Index>(from, "variable_most");
    const auto initial = column<Index>(from, "variable_initial");
    same_length(most.size(), least.size());
    same_length(initial.size(), least.size());
    for (std::size_t k = 0; k < least.size(); ++k) system.variables.push_back({least[k], most[k], initial[k]});
    system.broadcast = column<std::uint8_t>(from, "broadcast");
    system.component_start = column<Index>(from, "component_start");
    system.initial = column<Index>(from, "initial");
    const auto invariants = column<Index>(from, "place_invariant");
    const auto bounds = column<Index>(from, "place_bounds");
    const auto stopped = column<Index>(from, "place_stopped");
    const auto urgency = column<std::uint8_t>(from, "place_urgency");
    for (const std::size_t size : {bounds.size(), stopped.size(), urgency.size()}) same_length(size, invariants.size());
    for (std::size_t k = 0; k < invariants.size(); ++k)
        system.places.push_back({invariants[k], bounds[k], stopped[k], static_cast<Urgency>(urgency[k])});
    system.action_start = column<Index>(from, "edge_start");
    const auto targets = column<Index>(from, "edge_target");
    const auto guards = column<Index>(from, "edge_guard");
    const auto resets = column<Index>(from, "edge_resets");
    const auto channels = column<Index>(from, "edge_channel");
    const auto sends = column<std::uint8_t>(from, "edge_sends");
    const auto tests = column<Index>(from, "edge_tests");
    const auto updates = column<Index>(from, "edge_updates");
    for (const std::size_t size :
         {guards.size(), resets.size(), channels.size(), sends.size(), tests.size(), updates.size()})
        same_length(size, targets.size());
    for (std::size_t k = 0; k < targets.size(); ++k)
        system.actions.push_back(
            {targets[k], guards[k], resets[k], channels[k], sends[k] != 0, tests[k], updates[k]});
    const auto places = column<Index>(from, "aim_places");
    const auto aim_guards = column<Index>(from, "aim_guard");
    const auto aim_tests = column<Index>(from, "aim_tests");
    same_length(aim_guards.size(), places.size());
    same_length(aim_tests.size(), places.size());
    for (std::size_t k = 0; k < places.size(); ++k) system.aims.push_back({places[k], aim_guards[k], aim_tests[k]});
    return system;
}

}  // namespace

void bind_reachability(nb::module_& module) {
    nb::class_<Reachability>(module, "Reachability", "Search of the zone graph of a system given as tables.")
        .def(
            "__init__",
            [](Reachability* self, const NamedTables& tables, std::size_t memory) {
                new (self) Reachability(read_system(tables), memory > 0 ? memory : std::size_t{1} << 62);
            },
            nb::arg("tables"), nb::kw_only(), nb::arg("memory") = 0, "`memory` in bytes, if positive, is a limit.")
        .def(
            "run",
            [](Reachability& self, double seconds, double limit) {
                return run_interruptibly(self, seconds, limit);
            },
            nb::arg("seconds"), nb::arg("limit") = std::numeric_limits<double>::infinity(),
            "Searches for about this long, and no longer than the limit. 0: not done, 1: found, 2: exhausted, "
            "3: out of memory. After 1, goes on to the next goal.")
        .def_prop_ro("visited", &Reachability::visited, "States expanded.")
        .def_prop_ro("stored", &Reachability::stored, "States stored that lie in no other.")
        .def_prop_ro("transitions", &Reachability::transitions, "Moves tried.")
        .def_prop_ro("bytes", &Reachability::bytes, "Memory in use.")
        .def_prop_ro("lower_bound", &Reachability::lower_bound, "No goal still to be found is earlier, in ticks.")
        .def_prop_ro("approximated", &Reachability::approximated, "Whether a clock that is read has stood still.")
        .def_prop_ro(
            "goal",
            [](const Reachability& self) {
                if (self.goal().node == none) throw nb::value_error("no goal has been found");
                return std::tuple(self.goal().time, self.goal().strict, self.goal().aim);
            },
            "The time of the goal, whether it is an infimum that is not attained, and the number of its aim.")
        .def(
            "path",
            [](const Reachability& self) {
                if (self.goal().node == none) throw nb::value_error("no goal has been found");
                std::vector<Index> start{0};
                std::vector<Index> parts;
                for (const auto& move : self.path_to(self.goal().node)) {
                    for (const Part& part : move) parts.insert(parts.end(), {part.component, part.edge});
                    start.push_back(static_cast<Index>(parts.size() / 2));
                }
                return std::tuple(to_array(std::move(start)), to_array(std::move(parts)));
            },
            "The moves up to the goal: where each begins, and pairs of component and edge.");
}

}  // namespace mitlplan
