#include "reachability.hpp"

namespace mitlplan {

namespace {

constexpr int expansions_between_looks_at_the_clock = 16;

/// The valuations that break a constraint.
Constraint negated(const Constraint& constraint) {
    const Ticks bound = -value(constraint.bound);
    return {constraint.clock, !constraint.upper, is_strict(constraint.bound) ? less_equal(bound) : less(bound)};
}

}  // namespace

Reachability::Reachability(System system, std::size_t memory)
    : system_((system.validate(), std::move(system))),
      memory_(memory),
      rows_(system_.width()),
      active_(system_.bounds, system_.clocks, system_.time_clock, system_.components()),
      bounds_rows_(system_.components()) {
    for (Index guard = 0; guard < system_.guards.count(); ++guard)
        bounds_below_.push_back(
            std::ranges::any_of(system_.guards[guard], [](const Constraint& each) { return !each.upper; }));
    start();
}

std::size_t Reachability::bytes() const noexcept {
    return arena_.bytes() + nodes_.capacity() * sizeof(Node) + parts_.capacity() * sizeof(Part) +
           states_.capacity() * sizeof(State) + rows_.bytes() + waiting_.size() * sizeof(Waiting);
}

void Reachability::start() {
    row_ = system_.initial;
    for (const Variable& variable : system_.variables) row_.push_back(variable.initial);
    const Index state = find_state(row_);
    const ActiveClocks& clocks = clocks_of(state);
    settled_.resize(dbm::size(clocks.dimension()));
    dbm::set_zero(settled_);
    if (elapse(settled_, clocks, std::span(row_).first(system_.components()))) store(none, state, clocks);
}

Index Reachability::find_state(std::span<const Index> row) {
    const auto [state, fresh] = rows_.insert(row);
    if (fresh) {
        for (std::size_t component = 0; component < system_.components(); ++component)
            bounds_rows_[component] = system_.place(row[component]).bounds;
        states_.push_back({active_.find(bounds_rows_), none});
    }
    return state;
}

bool Reachability::elapse(std::span<Bound> zone, const ActiveClocks& clocks, std::span<const Index> locations) {
    const auto within_invariants = [&](auto&& asked) {
        return std::ranges::all_of(locations, [&](Index location) {
            const Index invariant = system_.place(location).invariant;
            return !asked(invariant) || constrain(zone, clocks, system_.guards[invariant]);
        });
    };
    const bool still = std::ranges::any_of(
        locations, [&](Index location) { return system_.place(location).urgency != Urgency::normal; });
    if (still) return within_invariants([](Index) { return true; });
    // An upper bound that holds after a delay has held before.
    if (!within_invariants([&](Index guard) { return bounds_below_[static_cast<std::size_t>(guard)] != 0; }))
        return false;
    const auto dimension = static_cast<std::size_t>(clocks.dimension());
    stopped_.assign(dimension, 0);
    std::size_t stopped = 0;
    for (const Index location : locations)
        for (const Index clock : system_.clock_sets[system_.place(location).stopped]) {
            const int position = clocks.position(clock);
            if (position != none && std::exchange(stopped_[static_cast<std::size_t>(position)], 1) == 0) ++stopped;
        }
    if (stopped == 0) {
        dbm::up(zone, clocks.dimension());
    } else {
        approximated_ = true;
        dbm::up_partly(zone, clocks.dimension(), stopped_);
    }
    return within_invariants([](Index) { return true; });
}

void Reachability::look_for_goals(const ActiveClocks& clocks) {
    goals_.clear();
    for (std::size_t number = 0; number < system_.aims.size(); ++number) {
        const Aim& aim = system_.aims[number];
        const auto places = system_.place_sets[aim.places];
        const bool there = std::ranges::all_of(
            places, [&](Index location) { return row_[system_.component_of(location)] == location; });
        if (!there || !system_.run(aim.tests, std::span(row_).subspan(system_.components()))) continue;
        aimed_ = settled_;
        if (!constrain(aimed_, clocks, system_.guards[aim.guard])) continue;
        const int time = system_.time_clock == none ? 0 : clocks.position(system_.time_clock);
        goals_.emplace_back(static_cast<Index>(number), aimed_[static_cast<std::size_t>(time)]);
    }
}

void Reachability::store(NodeId parent, Index state, const ActiveClocks& clocks) {
    look_for_goals(clocks);
    State& home = states_[static_cast<std::size_t>(state)];
    const std::size_t size = dbm::size(clocks.dimension());
    for (NodeId* link = &home.first; *link != none;) {
        Node& other = nodes_[static_cast<std::size_t>(*link)];
        const std::span<const Bound> zone(other.zone, size);
        if (dbm::simulates(zone, settled_, clocks.dimension(), clocks.lower, clocks.upper)) return;
        if (dbm::simulates(settled_, zone, clocks.dimension(), clocks.lower, clocks.upper)) {
            other.covered = true;
            ++covered_;
            // Nobody looks at its zone again, unless it is the one whose moves are being made.
            if (*link != from_) arena_.give_back(std::exchange(other.zone, nullptr), size);
            *link = other.next;
        } else {
            link = &other.next;
        }
    }
    if (nodes_.size() >= static_cast<std::size_t>(std::numeric_limits<NodeId>::max() - 1))
        throw std::overflow_error("more than 2^31 states");
    const auto node = static_cast<NodeId>(nodes_.size());
    const Index depth = parent == none ? 0 : nodes_[static_cast<std::size_t>(parent)].depth + 1;
    Bound* const zone = arena_.allocate(size);
    std::ranges::copy(settled_, zone);
    nodes_.push_back({state, parent, home.first, depth, parts_.size(), zone, false});
    parts_.insert(parts_.end(), taking_part_.begin(), taking_part_.end());
    home.first = node;
    const int time = system_.time_clock == none ? 0 : clocks.position(system_.time_clock);
    // Without an objective what came first goes first; with one, what has come furthest is nearest to a goal.
    const Index rank = system_.time_clock == none ? depth : -depth;
    const Bound least = zone[time];
    waiting_.push({-value(least), is_strict(least), rank, true, node, none});
    for (const auto& [aim, bound] : goals_) waiting_.push({-value(bound), is_strict(bound), rank, false, node, aim});
}

void Reachability::move(std::span<const Bound> zone) {
    watch_.look_up();
    if (must_leave_committed_ && std::ranges::none_of(taking_part_, [&](const Part& part) {
            return committed(at_[static_cast<std::size_t>(part.component)]);
        }))
        return;
    ++transitions_;
    row_ = at_;
    resets_.clear();
    for (const Part& part : taking_part_) {
        const Action& action = system_.action(part.edge);
        if (!system_.run(action.updates, std::span(row_).subspan(system_.components()))) return;
        row_[static_cast<std::size_t>(part.component)] = action.target;
        const auto resets = system_.clock_sets[action.resets];
        resets_.insert(resets_.end(), resets.begin(), resets.end());
    }
    const Index state = find_state(row_);
    const ActiveClocks& after = clocks_of(state);
    carry_over(zone, *clocks_, resets_, after, source_, settled_);
    if (elapse(settled_, after, std::span(row_).first(system_.components()))) store(from_, state, after);
}

std::span<Bound> Reachability::room(std::span<const Bound> zone, std::size_t depth) {
    while (rooms_.size() <= depth) rooms_.emplace_back();
    rooms_[depth].assign(zone.begin(), zone.end());
    return rooms_[depth];
}

std::optional<std::span<const Bound>> Reachability::taken(const Action& action, std::span<const Bound> zone,
                                                          std::size_t depth) {
    if (!system_.run(action.tests, integers())) return std::nullopt;
    const auto guard = system_.guards[action.guard];
    if (guard.empty()) return zone;
    const auto within = room(zone, depth);
    if (!constrain(within, *clocks_, guard)) return std::nullopt;
    return within;
}

void Reachability::expand(NodeId id) {
    const Node node = nodes_[static_cast<std::size_t>(id)];
    const auto row = rows_[node.state];
    at_.assign(row.begin(), row.end());
    from_ = id;
    clocks_ = &clocks_of(node.state);
    must_leave_committed_ = std::ranges::any_of(locations(), [&](Index location) { return committed(location); });
    const std::span<const Bound> zone(node.zone, dbm::size(clocks_->dimension()));
    for (std::size_t component = 0; component < system_.components(); ++component) {
        const auto location = static_cast<std::size_t>(at_[component]);
        for (Index edge = system_.action_start[location]; edge < system_.action_start[location + 1]; ++edge) {
            const Action& action = system_.action(edge);
            if (action.channel != none && !action.sends) continue;
            const auto within = taken(action, zone, 0);
            if (!within) continue;
            taking_part_.assign(1, {static_cast<Index>(component), edge});
            if (action.channel == none) {
                move(*within);
            } else if (system_.broadcast[static_cast<std::size_t>(action.channel)] != 0) {
                receivers(component, action.channel, 0, *within, 1);
            } else {
                pairs(component, action.channel, *within);
            }
        }
    }
}

void Reachability::pairs(std::size_t sender, Index channel, std::span<const Bound> zone) {
    for (std::size_t component = 0; component < system_.components(); ++component) {
        if (component == sender) continue;
        const auto location = static_cast<std::size_t>(at_[component]);
        for (Index edge = system_.action_start[location]; edge < system_.action_start[location + 1]; ++edge) {
            const Action& action = system_.action(edge);
            if (action.channel != channel || action.sends) continue;
            const auto within = taken(action, zone, 1);
            if (!within) continue;
            taking_part_.push_back({static_cast<Index>(component), edge});
            move(*within);
            taking_part_.pop_back();
        }
    }
}

// A broadcast takes along everyone who can receive it: from `component` on, each takes one of the edges that its guards
// allow, or none in the part of the zone where they all forbid it.
void Reachability::receivers(std::size_t sender, Index channel, std::size_t component, std::span<const Bound> zone,
                             std::size_t depth) {
    if (component == system_.components()) return move(zone);
    if (component == sender) return receivers(sender, channel, component + 1, zone, depth);
    const auto location = static_cast<std::size_t>(at_[component]);
    for (Index edge = system_.action_start[location]; edge < system_.action_start[location + 1]; ++edge) {
        const Action& action = system_.action(edge);
        if (action.channel != channel || action.sends) continue;
        const auto within = taken(action, zone, depth);
        if (!within) continue;
        taking_part_.push_back({static_cast<Index>(component), edge});
        receivers(sender, channel, component + 1, *within, depth + 1);
        taking_part_.pop_back();
    }
    decline(sender, channel, component, system_.action_start[location], zone, depth);
}

void Reachability::decline(std::size_t sender, Index channel, std::size_t component, Index edge,
                           std::span<const Bound> zone, std::size_t depth) {
    const Index last = system_.action_start[static_cast<std::size_t>(at_[component]) + 1];
    for (; edge < last; ++edge) {
        const Action& action = system_.action(edge);
        if (action.channel == channel && !action.sends && system_.run(action.tests, integers())) break;
    }
    if (edge == last) return receivers(sender, channel, component + 1, zone, depth);
    for (const Constraint& constraint : system_.guards[system_.action(edge).guard]) {
        const auto within = room(zone, depth);
        if (constrain(within, *clocks_, negated(constraint)))
            decline(sender, channel, component, edge + 1, within, depth + 1);
    }
}

Ticks Reachability::lower_bound() const noexcept {
    return waiting_.empty() ? std::numeric_limits<Ticks>::max() : waiting_.top().time;
}

Status Reachability::run(Seconds budget, Seconds limit, std::function<void()> poll) {
    watch_.begin(limit, std::move(poll));
    while (true) {
        for (int count = 0; count < expansions_between_looks_at_the_clock; ++count) {
            if (waiting_.empty()) return Status::exhausted;
            const Waiting next = waiting_.top();
            waiting_.pop();
            if (!next.goes_on) {
                goal_ = {next.node, next.time, next.strict, next.aim};
                return Status::found;
            }
            if (nodes_[static_cast<std::size_t>(next.node)].covered) continue;
            try {
                expand(next.node);
            } catch (const OutOfTime&) {
                waiting_.push(next);
                return Status::running;
            } catch (...) {
                waiting_.push(next);
                throw;
            }
            ++visited_;
        }
        if (bytes() > memory_) return Status::out_of_memory;
        if (watch_.over(budget)) return Status::running;
    }
}

std::span<const Part> Reachability::parts_of(const Node& node) const noexcept {
    const auto next = static_cast<std::size_t>(&node - nodes_.data()) + 1;
    const std::size_t last = next < nodes_.size() ? nodes_[next].parts : parts_.size();
    return std::span(parts_).subspan(node.parts, last - node.parts);
}

std::vector<std::span<const Part>> Reachability::path_to(NodeId id) const {
    std::vector<std::span<const Part>> path;
    while (nodes_[static_cast<std::size_t>(id)].parent != none) {
        const Node& node = nodes_[static_cast<std::size_t>(id)];
        path.push_back(parts_of(node));
        id = node.parent;
    }
    std::ranges::reverse(path);
    return path;
}

}  // namespace mitlplan
