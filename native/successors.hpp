// The joint steps of a network, and what a step does to a zone.
//
// A state is a location for each component and a zone over the clocks that are active there: those that some
// component may still read before it resets them. The zone holds the valuations of the open phase: after the step that
// led here, after some positive time, within the invariants, and extrapolated. The product is never built: `enumerate`
// walks through the components, carrying the signals along, and calls back for each joint step.
#pragma once

#include <array>

#include "clocks.hpp"

namespace mitlplan {

inline constexpr Index stands_still = -1;

/// What a joint step leads to: the locations behind it, and the edge that each component takes.
struct JointStep {
    std::vector<Index> targets;
    std::vector<Index> edges;  // into the tables' edges of this kind; the driver's are moves, or `stands_still`
};

class Successors {
public:
    explicit Successors(const Tables& tables)
        : tables_(tables),
          signals_(static_cast<std::size_t>(tables.components() + 1) * static_cast<std::size_t>(tables.words)) {
        guarded_.resize(static_cast<std::size_t>(tables.components()));
        step_.targets.resize(static_cast<std::size_t>(tables.components()));
        step_.edges.resize(static_cast<std::size_t>(tables.components()));
    }

    /// Calls `visit(step, zone)` for each joint step of this kind from `locations`, the driver taking its edge
    /// `driver_edge` or standing still, with the part of `zone` that the guards leave.
    template <typename Visit>
    void enumerate(StepKind kind, std::span<const Index> locations, Index driver_edge, const ActiveClocks& clocks,
                   std::span<const Bound> zone, Visit&& visit) {
        const Index driver_target = driver_edge == stands_still ? locations[0] : driver_move(driver_edge).target;
        step_.targets[0] = driver_target;
        step_.edges[0] = driver_edge;
        const auto emitted = tables_.signal_set(tables_.locations[static_cast<std::size_t>(driver_target)].emits);
        std::ranges::copy(emitted, signals_.begin());
        descend({kind, locations, clocks}, 1, zone, visit);
    }

    /// The edges of the driver at `location`, as indices for `enumerate`.
    std::pair<Index, Index> driver_edges(Index location) const noexcept {
        const auto& start = tables_.edge_start[0];
        return {start[static_cast<std::size_t>(location)], start[static_cast<std::size_t>(location) + 1]};
    }

    const Edge& driver_move(Index edge) const noexcept {
        return tables_.edges[0][static_cast<std::size_t>(edge)];
    }

    const Edge& edge_of(StepKind kind, const JointStep& step, Index component) const noexcept {
        const auto edge = static_cast<std::size_t>(step.edges[static_cast<std::size_t>(component)]);
        return component == 0 ? tables_.edges[0][edge] : tables_.edges[static_cast<std::size_t>(kind)][edge];
    }

    /// Whether some component may profit from a step in which the driver stands still.
    bool restless(std::span<const Index> locations) const noexcept {
        const auto label = tables_.signal_set(tables_.locations[static_cast<std::size_t>(locations[0])].emits);
        for (std::size_t component = 1; component < locations.size(); ++component) {
            const Index signal = tables_.locations[static_cast<std::size_t>(locations[component])].restless;
            if (signal == restless_always) return true;
            if (signal >= 0 && (label[static_cast<std::size_t>(signal) / 64] >> (signal % 64) & 1) != 0) return true;
        }
        return false;
    }

    /// The zone behind a move, before time passes: clocks reset, inactive ones dropped.
    void settle(std::span<const Bound> zone, const ActiveClocks& before, const JointStep& step,
                const ActiveClocks& after, std::vector<Bound>& result) {
        resets_.clear();
        for (Index component = step.edges[0] == stands_still ? 1 : 0; component < tables_.components(); ++component) {
            const auto resets = tables_.resets[edge_of(StepKind::move, step, component).resets];
            resets_.insert(resets_.end(), resets.begin(), resets.end());
        }
        carry_over(zone, before, resets_, after, source_, result);
    }

    /// The open phase: some time passes, within the invariants. False if none can.
    bool elapse(std::span<Bound> zone, const ActiveClocks& clocks, std::span<const Index> locations) const {
        dbm::up_strict(zone, clocks.dimension());
        return std::ranges::all_of(locations, [&](Index location) {
            return constrain(zone, clocks, tables_.guards[tables_.locations[static_cast<std::size_t>(location)].invariant]);
        });
    }

private:
    struct Source {
        StepKind kind;
        std::span<const Index> locations;
        const ActiveClocks& clocks;
    };

    template <typename Visit>
    void descend(const Source& source, Index component, std::span<const Bound> zone, Visit& visit) {
        if (component == tables_.components()) {
            visit(static_cast<const JointStep&>(step_), zone);
            return;
        }
        const auto words = static_cast<std::size_t>(tables_.words);
        const auto position = static_cast<std::size_t>(component);
        const std::uint64_t* const set = &signals_[(position - 1) * words];
        std::uint64_t* const next = &signals_[position * words];
        const Index location = source.locations[position];
        const auto& start = tables_.edge_start[static_cast<std::size_t>(source.kind)];
        const auto& edges = tables_.edges[static_cast<std::size_t>(source.kind)];
        const Index last = start[static_cast<std::size_t>(location) + 1];
        for (Index index = start[static_cast<std::size_t>(location)]; index < last; ++index) {
            const Edge& edge = edges[static_cast<std::size_t>(index)];
            const auto reads = tables_.signal_set(edge.reads);
            const auto avoids = tables_.signal_set(edge.avoids);
            const auto emits = tables_.signal_set(edge.emits);
            bool enabled = true;
            for (std::size_t word = 0; word < words && enabled; ++word)
                enabled = (reads[word] & ~set[word]) == 0 && (avoids[word] & set[word]) == 0;
            if (!enabled) continue;
            std::span<const Bound> within = zone;
            if (!tables_.guards[edge.guard].empty()) {
                // Constrained here and not at the end, so that what the clocks forbid is not combined any further.
                auto& guarded = guarded_[position];
                guarded.assign(zone.begin(), zone.end());
                if (!constrain(guarded, source.clocks, tables_.guards[edge.guard])) continue;
                within = guarded;
            }
            for (std::size_t word = 0; word < words; ++word) next[word] = set[word] | emits[word];
            step_.targets[position] = edge.target;
            step_.edges[position] = index;
            descend(source, component + 1, within, visit);
        }
    }

    const Tables& tables_;
    std::vector<std::uint64_t> signals_;
    JointStep step_;
    std::vector<std::vector<Bound>> guarded_;  // by component: the zone within the guards of those before and its own
    std::vector<Index> resets_;
    std::vector<int> source_;
};

}  // namespace mitlplan
