// The search as Python sees it: a dictionary of integer arrays in, integer arrays out. The arrays are copied and
// validated once; `run` works for a while with the interpreter's lock released and comes back, so that Ctrl-C, progress
// and time limits stay with Python.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "columns.hpp"
#include "distances.hpp"
#include "search.hpp"

namespace mitlplan {

namespace {

std::vector<Location> read_locations(const nb::dict& from) {
    const auto invariants = view<Index>(from, "location_invariant");
    const auto stills = view<Index>(from, "location_still");
    const auto bounds = view<Index>(from, "location_bounds");
    const auto emits = view<Index>(from, "location_emits");
    const auto restless = view<Index>(from, "location_restless");
    const auto targets = view<Index>(from, "location_target");
    const auto clocks = view<Index>(from, "location_deadline_clock");
    const auto deadlines = view<Ticks>(from, "location_deadline");
    const auto reliefs = view<Index>(from, "location_relief");
    for (const std::size_t size : {stills.size(), bounds.size(), emits.size(), restless.size(), targets.size(),
                                   clocks.size(), deadlines.size(), reliefs.size()})
        same_length(size, invariants.size());
    std::vector<Location> locations;
    locations.reserve(invariants.size());
    for (std::size_t k = 0; k < invariants.size(); ++k)
        locations.push_back({invariants[k], stills[k], bounds[k], emits[k], restless[k], targets[k], clocks[k],
                             deadlines[k], reliefs[k]});
    return locations;
}

std::vector<Edge> read_edges(const nb::dict& from, const std::string& kind) {
    const auto name = [&](const char* part) { return kind + "_" + part; };
    const auto targets = view<Index>(from, name("target").c_str());
    const auto guards = view<Index>(from, name("guard").c_str());
    const auto resets = view<Index>(from, name("resets").c_str());
    const auto reads = view<Index>(from, name("reads").c_str());
    const auto avoids = view<Index>(from, name("avoids").c_str());
    const auto emits = view<Index>(from, name("emits").c_str());
    const auto marks = view<Index>(from, name("marks").c_str());
    for (const std::size_t size :
         {guards.size(), resets.size(), reads.size(), avoids.size(), emits.size(), marks.size()})
        same_length(size, targets.size());
    std::vector<Edge> edges;
    edges.reserve(targets.size());
    for (std::size_t k = 0; k < targets.size(); ++k)
        edges.push_back({targets[k], guards[k], resets[k], reads[k], avoids[k], emits[k], marks[k]});
    return edges;
}

Tables read_tables(const nb::dict& from) {
    Tables tables;
    tables.clocks = number(from, "clocks");
    tables.time_clock = number(from, "time_clock");
    tables.driver_clock = number(from, "driver_clock");
    tables.words = number(from, "words");
    tables.guards = read_guards(from);
    tables.resets = rows(column<Index>(from, "reset_start"), column<Index>(from, "reset_clock"));
    tables.signals = column<std::uint64_t>(from, "signals");
    tables.bounds = read_bounds(from);
    tables.component_start = column<Index>(from, "component_start");
    tables.locations = read_locations(from);
    const std::array<std::string, step_kinds> kinds{"move", "ending", "parking"};
    for (std::size_t kind = 0; kind < step_kinds; ++kind) {
        tables.edge_start[kind] = column<Index>(from, (kinds[kind] + "_start").c_str());
        tables.edges[kind] = read_edges(from, kinds[kind]);
    }
    tables.parkable = column<std::uint8_t>(from, "parkable");
    tables.distances = column<Ticks>(from, "distances");
    return tables;
}

}  // namespace

void bind_search(nb::module_& module) {
    module.def(
        "distances",
        [](Index locations, const Column<Index>& sources, const Column<Index>& targets, const Column<Index>& times,
           const Column<Ticks>& ticks, const std::vector<Column<Index>>& goals) {
            if (locations < 0) throw nb::value_error("a negative number of locations");
            const auto span = [](const auto& of) { return std::span(of.data(), of.shape(0)); };
            Distances moves(locations, span(sources), span(targets), span(times), span(ticks));
            const auto count = static_cast<std::size_t>(locations);
            std::vector<Ticks> result(goals.size() * count);
            for (std::size_t field = 0; field < goals.size(); ++field)
                moves.to(span(goals[field]), std::span(result).subspan(field * count, count));
            return to_array(std::move(result));
        },
        nb::arg("locations"), nb::arg("source"), nb::arg("target"), nb::arg("time"), nb::arg("ticks"),
        nb::arg("goals"),
        "For each array of goals a row of the least ticks from every location to one of them, -1 where there is no "
        "way; `time` is the index of each move into `ticks`. What is farther than 2^53 ticks is given as that.");
    nb::class_<Search>(module, "Search", "Best-first search over the zone graph of a network given as tables.")
        .def(
            "__init__",
            [](Search* self, const NamedTables& tables, bool record, bool endings, bool parkings, Ticks horizon,
               std::size_t memory) {
                Options options;
                options.record = record;
                options.endings = endings;
                options.parkings = parkings;
                if (horizon >= 0) options.horizon = horizon;
                if (memory > 0) options.memory = memory;
                new (self) Search(read_tables(tables), options);
            },
            nb::arg("tables"), nb::kw_only(), nb::arg("record") = false, nb::arg("endings") = true,
            nb::arg("parkings") = true, nb::arg("horizon") = -1, nb::arg("memory") = 0,
            "Takes over the tables; `horizon` in ticks and `memory` in bytes, if positive, are limits.")
        .def(
            "run",
            [](Search& self, double seconds, double limit) { return run_interruptibly(self, seconds, limit); },
            nb::arg("seconds"), nb::arg("limit") = std::numeric_limits<double>::infinity(),
            "Searches for about this long, and no longer than the limit. 0: not done, 1: found, 2: exhausted, "
            "3: out of memory.")
        .def_prop_ro("found", [](const Search& self) { return self.goal().parent != none; }, "Whether a goal is known.")
        .def_prop_ro("visited", &Search::visited, "States expanded.")
        .def_prop_ro("stored", &Search::stored, "States stored.")
        .def_prop_ro("bytes", &Search::bytes, "Memory in use.")
        .def_prop_ro("lower_bound", &Search::lower_bound, "No goal is earlier, in ticks.")
        .def_prop_ro(
            "goal", [](const Search& self) { return std::tuple(self.goal().time, self.goal().strict); },
            "The time of the goal, and whether it is an infimum that is not attained.")
        .def(
            "path",
            [](const Search& self) {
                if (self.goal().parent == none) throw nb::value_error("no goal has been found");
                auto path = self.path_to(self.goal().parent);
                path.insert(path.end(), self.goal().edges.begin(), self.goal().edges.end());
                return std::pair(to_array(std::move(path)), static_cast<int>(self.goal().kind));
            },
            "The edges of all joint steps up to the goal, a row of components each; and the kind of the last step.")
        .def(
            "path_to",
            [](const Search& self, NodeId node) {
                if (node < 0 || static_cast<std::size_t>(node) >= self.stored()) throw nb::index_error("no such state");
                return to_array(self.path_to(node));
            },
            nb::arg("node"), "The edges of the joint steps up to a state.")
        .def(
            "graph",
            [](const Search& self) {
                std::vector<NodeId> sources;
                std::vector<NodeId> targets;
                std::vector<std::uint64_t> marks;
                for (const RecordedStep& step : self.recorded()) {
                    sources.push_back(step.source);
                    targets.push_back(step.target);
                    marks.push_back(step.marks);
                }
                return std::tuple(to_array(std::move(sources)), to_array(std::move(targets)), to_array(std::move(marks)));
            },
            "Sources, targets and marks of all recorded steps.")
        .def(
            "recorded_driver_edges",
            [](const Search& self) {
                std::vector<Index> edges;
                for (std::size_t step = 0; step < self.recorded().size(); ++step)
                    edges.push_back(self.recorded_edges(step)[0]);
                return to_array(std::move(edges));
            },
            "The driver's edge of every recorded step; -1 where it stands still.")
        .def(
            "recorded_edges",
            [](const Search& self, std::size_t step) {
                if (step >= self.recorded().size()) throw nb::index_error("no such step");
                const auto edges = self.recorded_edges(step);
                return to_array(std::vector<Index>(edges.begin(), edges.end()));
            },
            nb::arg("step"), "The edges of a recorded step.")
        .def(
            "locations",
            [](const Search& self, NodeId node) {
                if (node < 0 || static_cast<std::size_t>(node) >= self.stored()) throw nb::index_error("no such state");
                const auto locations = self.locations_of(node);
                return to_array(std::vector<Index>(locations.begin(), locations.end()));
            },
            nb::arg("node"), "The locations of a state.");
}

}  // namespace mitlplan
