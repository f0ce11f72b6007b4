#include "search.hpp"

namespace mitlplan {

namespace {

constexpr int expansions_between_looks_at_the_clock = 16;

}  // namespace

Search::Search(Tables tables, const Options& options)
    : tables_((tables.validate(), std::move(tables))),
      options_(options),
      successors_(tables_),
      tours_(tables_),
      rows_(static_cast<std::size_t>(tables_.components())),
      active_(tables_.bounds, tables_.clocks, tables_.time_clock, static_cast<std::size_t>(tables_.components())),
      bounds_(static_cast<std::size_t>(tables_.components())) {
    const auto driver_locations = static_cast<std::size_t>(tables_.driver_locations());
    // Worth its price where components choose when to act, which makes states differ that need not.
    relief_ = !options_.record && std::ranges::any_of(tables_.locations, [](const Location& location) {
        return location.restless == restless_always;
    });
    const auto [first, last] = std::pair(tables_.edge_start[0].front(), tables_.edge_start[0][driver_locations]);
    for (Index edge = first; edge < last; ++edge)
        for (const Constraint& constraint : tables_.guards[successors_.driver_move(edge).guard])
            if (constraint.clock == tables_.driver_clock && !constraint.upper)
                longest_move_ = std::max(longest_move_, -value(constraint.bound));
    if (relief_) debtors_.resize(driver_locations);
    start();
}

std::size_t Search::bytes() const noexcept {
    return arena_.bytes() + nodes_.capacity() * sizeof(Node) + steps_.capacity() * sizeof(Index) +
           states_.capacity() * sizeof(State) + rows_.bytes() + waiting_.size() * sizeof(Waiting) +
           recorded_.capacity() * sizeof(RecordedStep) + recorded_edges_.capacity() * sizeof(Index);
}

void Search::start() {
    // Every component begins in its initial location; the driver's is its last, with the edges to where it starts.
    std::vector<Index> initial(static_cast<std::size_t>(tables_.components()));
    for (std::size_t component = 0; component < initial.size(); ++component)
        initial[component] = tables_.component_start[component];
    initial[0] = tables_.driver_locations() - 1;
    const Index state = find_state(initial);
    const auto& clocks = active_[states_[static_cast<std::size_t>(state)].active];
    settled_.resize(dbm::size(clocks.dimension()));
    dbm::set_zero(settled_);
    JointStep nothing;
    nothing.edges.assign(initial.size(), none);
    nothing.targets = initial;
    store(none, nothing, state, clocks, 0, {0, 0});
}

Index Search::find_state(std::span<const Index> wanted) {
    const auto [state, fresh] = rows_.insert(wanted);
    if (fresh) {
        for (std::size_t component = 0; component < wanted.size(); ++component)
            bounds_[component] = tables_.locations[static_cast<std::size_t>(wanted[component])].bounds;
        states_.push_back({active_.find(bounds_), none});
    }
    return state;
}

Search::Estimate Search::estimate(std::span<const Bound> zone, const ActiveClocks& clocks, std::span<const Index> at,
                                  Index moves) {
    constexpr Estimate hopeless{Tours::unreachable, 0};
    const int dimension = clocks.dimension();
    const int time = tables_.time_clock == none ? none : clocks.position(tables_.time_clock);
    const int driver = tables_.driver_clock == none ? none : clocks.position(tables_.driver_clock);
    // The least value of a clock at the last move of the driver, from where distances count.
    const auto since_move = [&](int clock) {
        const Ticks least = -value(zone[dbm::entry(dimension, 0, clock)]);
        if (driver == none || driver == clock) return least;
        // The next move is under way, but everything behind it has still to be driven.
        const Bound difference = zone[dbm::entry(dimension, driver, clock)];
        return difference == infinity ? least - longest_move_ : std::max(least - longest_move_, -value(difference));
    };
    Tours::Subset targets = 0;
    due_.clear();
    for (const Index index : at) {
        const Location& location = tables_.locations[static_cast<std::size_t>(index)];
        if (location.target == none) continue;
        const int clock = location.deadline_clock == none ? none : clocks.position(location.deadline_clock);
        if (location.target < Tours::largest) targets |= Tours::Subset{1} << location.target;
        else if (tables_.distance(location.target, at[0]) < 0) return hopeless;
        if (clock != none) due_.emplace_back(location.deadline - since_move(clock), location.target);
    }
    // All that is due by some time has to be seen by then, in whatever order.
    std::ranges::sort(due_);
    Tours::Subset due = 0;
    for (const auto& [left, target] : due_) {
        if (target < Tours::largest) due |= Tours::Subset{1} << target;
        else if (tables_.distance(target, at[0]) > left) return hopeless;
        if (tours_.bound(due, at[0]) > left) return hopeless;
    }
    const Ticks rest = tours_.bound(targets, at[0]);
    if (rest == Tours::unreachable) return hopeless;
    const Ticks moves_left = longest_move_ == 0 ? 0 : (rest + longest_move_ - 1) / longest_move_;
    if (time == none) return {0, moves + moves_left};
    const Ticks now = -value(zone[dbm::entry(dimension, 0, time)]);
    return {targets == 0 ? now : std::max(now, since_move(time) + rest), moves + moves_left};
}

bool Search::relieves(Index easier, Index state) const noexcept {
    const auto there = locations(easier);
    const auto here = locations(state);
    for (std::size_t component = 1; component < here.size(); ++component) {
        Index location = here[component];
        while (location > there[component]) location = tables_.locations[static_cast<std::size_t>(location)].relief;
        if (location != there[component]) return false;
    }
    return true;
}

std::uint64_t Search::owing(Index state) const noexcept {
    std::uint64_t result = 0;
    const auto here = locations(state);
    for (std::size_t component = 0; component < here.size(); ++component)
        if (tables_.locations[static_cast<std::size_t>(here[component])].relief != none)
            result |= std::uint64_t{1} << (component % 64);
    return result;
}

void Search::enlist(Index state) {
    auto& groups = debtors_[static_cast<std::size_t>(locations(state)[0])];
    const std::uint64_t owed = owing(state);
    auto group = std::ranges::find(groups, owed, &Debtors::owing);
    if (group == groups.end()) group = groups.insert(groups.end(), {owed, {}});
    group->states.push_back(state);
}

bool Search::relieved(Index state, const ActiveClocks& clocks, Index moves) {
    const int dimension = clocks.dimension();
    const std::uint64_t owed = owing(state);
    const auto covers = [&](const State& easier) {
        const ActiveClocks& fewer = active_[easier.active];
        positions_.clear();
        for (const int clock : fewer.clocks) positions_.push_back(clock == 0 ? 0 : clocks.position(clock));
        if (std::ranges::find(positions_, static_cast<int>(none)) != positions_.end()) return false;
        for (NodeId id = easier.first; id != none; id = nodes_[static_cast<std::size_t>(id)].next) {
            const Node& node = nodes_[static_cast<std::size_t>(id)];
            if (node.moves > moves) continue;
            const Bound* outer = node.zone;
            bool included = true;
            for (const int i : positions_) {
                for (const int j : positions_) included = included && *outer++ >= settled_[dbm::entry(dimension, i, j)];
                if (!included) break;
            }
            if (included) return true;
        }
        return false;
    };
    for (const Debtors& group : debtors_[static_cast<std::size_t>(locations(state)[0])]) {
        if ((group.owing & ~owed) != 0) continue;
        for (const Index easier : group.states)
            if (easier != state && relieves(easier, state) && covers(states_[static_cast<std::size_t>(easier)]))
                return true;
    }
    return false;
}

void Search::store(NodeId parent, const JointStep& step, Index state, const ActiveClocks& clocks, Index moves,
                   const Estimate& estimated) {
    State& home = states_[static_cast<std::size_t>(state)];
    const auto marks = [&] {
        std::uint64_t set = 0;
        for (Index component = 1; component < tables_.components(); ++component)
            set |= std::uint64_t{1} << successors_.edge_of(StepKind::move, step, component).marks;
        return step.edges[0] == stands_still ? set & ~std::uint64_t{1} : set | 1;
    };
    const auto record = [&](NodeId target) {
        if (!options_.record || parent == none) return;
        recorded_.push_back({parent, target, marks()});
        recorded_edges_.insert(recorded_edges_.end(), step.edges.begin(), step.edges.end());
    };
    const std::size_t key = options_.record ? dbm::hash(settled_) ^ static_cast<std::size_t>(state) : 0;
    if (options_.record) {
        const auto [first, last] = by_zone_.equal_range(key);
        for (auto same = first; same != last; ++same) {
            const Node& other = nodes_[static_cast<std::size_t>(same->second)];
            if (other.state == state && dbm::equals(zone_of(other), settled_)) return record(same->second);
        }
    }
    NodeId* link = &home.first;
    while (!options_.record && *link != none) {
        Node& other = nodes_[static_cast<std::size_t>(*link)];
        const auto old_zone = zone_of(other);
        if (other.moves <= moves && dbm::includes(old_zone, settled_)) return;
        if (moves <= other.moves && dbm::includes(settled_, old_zone)) {
            other.covered = true;
            *link = other.next;
            continue;
        }
        link = &other.next;
    }
    if (relief_ && relieved(state, clocks, moves)) return;
    if (nodes_.size() >= static_cast<std::size_t>(std::numeric_limits<NodeId>::max() - 1))
        throw std::overflow_error("more than 2^31 states");
    if (relief_ && std::exchange(home.listed, true) == false) enlist(state);
    const auto node = static_cast<NodeId>(nodes_.size());
    const std::size_t size = dbm::size(clocks.dimension());
    Bound* const zone = arena_.allocate(size);
    std::ranges::copy(settled_, zone);
    nodes_.push_back({state, parent, home.first, moves, zone, false});
    home.first = node;
    if (options_.record) by_zone_.emplace(key, node);
    steps_.insert(steps_.end(), step.edges.begin(), step.edges.end());
    waiting_.push({estimated.time, estimated.moves, -moves, node});
    record(node);
}

void Search::reach_goal(NodeId parent, const ActiveClocks& clocks, std::span<const Bound> zone, StepKind kind,
                        const JointStep& step, Index moves) {
    const int time = clocks.position(tables_.time_clock);
    const Bound least = zone[static_cast<std::size_t>(time)];
    const auto found = std::tuple(-value(least), is_strict(least), moves);
    if (std::get<0>(found) > options_.horizon) return;
    if (goal_.parent != none && found >= std::tuple(goal_.time, goal_.strict, goal_.moves)) return;
    goal_ = {parent, kind, step.edges, -value(least), is_strict(least), moves};
}

void Search::take(NodeId parent, const ActiveClocks& clocks, std::span<const Bound> zone, StepKind kind,
                  const JointStep& step, bool silent) {
    watch_.look_up();
    const Index moves = nodes_[static_cast<std::size_t>(parent)].moves + (silent ? 0 : 1);
    if (kind != StepKind::move) return reach_goal(parent, clocks, zone, kind, step, moves);
    const Index state = find_state(step.targets);
    const ActiveClocks& after = active_[states_[static_cast<std::size_t>(state)].active];
    successors_.settle(zone, clocks, step, after, settled_);
    if (!successors_.elapse(settled_, after, step.targets)) return;
    const Estimate estimated = estimate(settled_, after, step.targets, moves);
    if (estimated.time > options_.horizon) return;
    dbm::extrapolate_lu_plus(settled_, after.dimension(), after.lower, after.upper);
    store(parent, step, state, after, moves, estimated);
}

void Search::expand(NodeId id) {
    const Node node = nodes_[static_cast<std::size_t>(id)];
    const std::vector<Index> at(locations(node.state).begin(), locations(node.state).end());
    const ActiveClocks& clocks = active_[states_[static_cast<std::size_t>(node.state)].active];
    const std::span<const Bound> zone = zone_of(node);
    const bool initial = node.parent == none;
    const bool goals = tables_.time_clock != none;
    const auto enumerate = [&](StepKind kind, Index driver_edge, std::span<const Bound> driven) {
        const bool silent = driver_edge == stands_still || initial;
        successors_.enumerate(kind, at, driver_edge, clocks, driven,
                              [&](const JointStep& step, std::span<const Bound> guarded) {
                                  take(id, clocks, guarded, kind, step, silent);
                              });
    };
    const auto [first, last] = successors_.driver_edges(at[0]);
    for (Index edge = first; edge < last; ++edge) {
        driven_.assign(zone.begin(), zone.end());
        const Edge& move = successors_.driver_move(edge);
        if (!constrain(driven_, clocks, tables_.guards[move.guard])) continue;
        enumerate(StepKind::move, edge, driven_);
        if (goals && options_.endings) enumerate(StepKind::ending, edge, driven_);
        if (goals && options_.parkings && tables_.parkable[static_cast<std::size_t>(move.target)] != 0)
            enumerate(StepKind::parking, edge, driven_);
    }
    if (initial) return;
    const bool restless = successors_.restless(at);
    if (!restless && !(goals && options_.endings)) return;
    // At the end of its longest stay the driver is no longer there.
    driven_.assign(zone.begin(), zone.end());
    const Index still = tables_.locations[static_cast<std::size_t>(at[0])].still;
    if (!constrain(driven_, clocks, tables_.guards[still])) return;
    if (restless) enumerate(StepKind::move, stands_still, driven_);
    if (goals && options_.endings) enumerate(StepKind::ending, stands_still, driven_);
}

bool Search::finished() const noexcept {
    if (waiting_.empty()) return true;
    if (goal_.parent == none) return false;
    const Waiting& next = waiting_.top();
    if (next.time != goal_.time) return next.time > goal_.time;
    return !goal_.strict && next.moves >= goal_.moves;
}

Ticks Search::lower_bound() const noexcept {
    Ticks bound = waiting_.empty() ? std::numeric_limits<Ticks>::max() : waiting_.top().time;
    return goal_.parent == none ? bound : std::min(bound, goal_.time);
}

Status Search::run(Seconds budget, Seconds limit, std::function<void()> poll) {
    watch_.begin(limit, std::move(poll));
    while (true) {
        for (int count = 0; count < expansions_between_looks_at_the_clock; ++count) {
            if (finished()) return goal_.parent == none ? Status::exhausted : Status::found;
            const Waiting next = waiting_.top();
            waiting_.pop();
            if (nodes_[static_cast<std::size_t>(next.node)].covered) continue;
            ++visited_;
            try {
                expand(next.node);
            } catch (const OutOfTime&) {
                waiting_.push(next);
                return Status::running;
            } catch (...) {
                waiting_.push(next);
                throw;
            }
        }
        if (bytes() > options_.memory) return Status::out_of_memory;
        if (watch_.over(budget)) return Status::running;
    }
}

std::span<const Index> Search::step_to(NodeId node) const noexcept {
    const auto width = static_cast<std::size_t>(tables_.components());
    return std::span(steps_).subspan(static_cast<std::size_t>(node) * width, width);
}

std::vector<Index> Search::path_to(NodeId node) const {
    std::vector<NodeId> chain;
    for (; nodes_[static_cast<std::size_t>(node)].parent != none; node = nodes_[static_cast<std::size_t>(node)].parent)
        chain.push_back(node);
    std::vector<Index> path;
    for (auto id = chain.rbegin(); id != chain.rend(); ++id) {
        const auto step = step_to(*id);
        path.insert(path.end(), step.begin(), step.end());
    }
    return path;
}

}  // namespace mitlplan
