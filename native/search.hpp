// Best-first search over the zone graph of a network.
//
// The waiting list is ordered by a lower bound on the objective, the time of the goal: the least time of the zone plus
// what the map says still has to be driven (A*: Hart, Nilsson, Raphael 1968). A new zone that lies in one stored with
// the same locations is dropped; because the time is extrapolated with lower constant minus infinity and upper constant
// infinity (Behrmann et al. 2006), "later is never better" is part of the inclusion, and nothing else is discarded. The
// first goal to leave the waiting list is the fastest; an empty list proves that there is none.
// With `record`, states are told apart exactly and every step is kept: the graph in which loops are sought.
#pragma once

#include <queue>
#include <unordered_map>

#include "successors.hpp"
#include "tours.hpp"
#include "watch.hpp"

namespace mitlplan {

using NodeId = std::int32_t;

struct Options {
    bool record = false;  // keep every step, and compare zones by equality
    bool endings = true;  // goals: a last step after which nothing is owed
    bool parkings = true;  // goals: a step after which the driver may stand still for ever
    Ticks horizon = tick_limit;  // goals later than this are of no interest
    std::size_t memory = std::size_t{1} << 62;  // bytes
};

/// A joint step on the way to a goal or in the recorded graph.
struct Goal {
    NodeId parent = none;
    StepKind kind = StepKind::ending;
    std::vector<Index> edges;
    Ticks time = 0;
    bool strict = false;  // the time is an infimum that is not attained
    Index moves = 0;
};

struct RecordedStep {
    NodeId source;
    NodeId target;
    std::uint64_t marks;  // Büchi sets visited, a bit each; bit 0: the driver has moved
};

class Search {
public:
    Search(Tables tables, const Options& options);
    Search(const Search&) = delete;
    Search& operator=(const Search&) = delete;

    /// Searches for about this long, at most up to the limit; `running` means: call again. Some states have so many
    /// successors that `poll` is called in their midst; it may throw, and what was cut short is begun again.
    Status run(Seconds budget, Seconds limit = Seconds::max(), std::function<void()> poll = nullptr);

    /// A lower bound on the time of every goal not yet found.
    Ticks lower_bound() const noexcept;
    const Goal& goal() const noexcept { return goal_; }
    const std::vector<RecordedStep>& recorded() const noexcept { return recorded_; }
    std::size_t visited() const noexcept { return visited_; }
    std::size_t stored() const noexcept { return nodes_.size(); }
    std::size_t bytes() const noexcept;
    const Tables& tables() const noexcept { return tables_; }

    /// The edges of the joint steps that lead from the start to `node`, one after the other, a row of
    /// `components` each.
    std::vector<Index> path_to(NodeId node) const;
    /// The edges of the joint step that led to `node` first.
    std::span<const Index> step_to(NodeId node) const noexcept;
    std::span<const Index> recorded_edges(std::size_t step) const noexcept {
        const auto width = static_cast<std::size_t>(tables_.components());
        return std::span(recorded_edges_).subspan(step * width, width);
    }
    std::span<const Index> locations_of(NodeId node) const noexcept {
        return locations(nodes_[static_cast<std::size_t>(node)].state);
    }

private:
    struct Node {
        Index state;
        NodeId parent;
        NodeId next;  // the next one with the same locations
        Index moves;
        Bound* zone;
        bool covered;
    };

    struct State {
        Index active;
        NodeId first;
        bool listed = false;  // among the debtors
    };

    /// States with zones that share the driver's location and the components, modulo 64, that have a relief: only
    /// where these are fewer can a state owe less.
    struct Debtors {
        std::uint64_t owing;
        std::vector<Index> states;
    };

    /// What lies beyond a state: lower bounds on the time of a goal and on the moves up to it.
    struct Estimate {
        Ticks time;
        Ticks moves;
    };

    // Among equal bounds the state that has come furthest goes first: it is the nearest to a goal.
    struct Waiting {
        Ticks time;
        Ticks moves;
        Index moves_made_negated;
        NodeId node;

        friend auto operator<=>(const Waiting&, const Waiting&) = default;
    };

    std::span<const Index> locations(Index state) const noexcept { return rows_[state]; }
    std::span<const Bound> zone_of(const Node& node) const noexcept {
        const auto& state = states_[static_cast<std::size_t>(node.state)];
        return {node.zone, dbm::size(active_[state.active].dimension())};
    }

    void start();
    void expand(NodeId node);
    void take(NodeId parent, const ActiveClocks& clocks, std::span<const Bound> zone, StepKind kind,
              const JointStep& step, bool silent);
    void reach_goal(NodeId parent, const ActiveClocks& clocks, std::span<const Bound> zone, StepKind kind,
                    const JointStep& step, Index moves);
    void store(NodeId parent, const JointStep& step, Index state, const ActiveClocks& clocks, Index moves,
               const Estimate& estimated);
    bool finished() const noexcept;
    /// Whether every component of `easier` is where it is in `state`, or in a relief of that.
    bool relieves(Index easier, Index state) const noexcept;
    std::uint64_t owing(Index state) const noexcept;
    void enlist(Index state);
    /// Whether the settled zone lies in one stored for a state that owes less.
    bool relieved(Index state, const ActiveClocks& clocks, Index moves);
    Index find_state(std::span<const Index> locations);
    /// Lower bounds on a goal beyond this zone; the time is `Tours::unreachable` if there is none.
    Estimate estimate(std::span<const Bound> zone, const ActiveClocks& clocks, std::span<const Index> locations,
                      Index moves);

    Tables tables_;
    Options options_;
    Successors successors_;
    Tours tours_;
    Ticks longest_move_ = 0;  // the least time of the slowest move
    std::vector<std::pair<Ticks, Index>> due_;  // targets with the time left for each
    std::vector<Node> nodes_;
    std::vector<Index> steps_;  // the joint step that led to each node
    std::vector<State> states_;
    std::vector<std::vector<Debtors>> debtors_;  // by location of the driver
    bool relief_ = false;  // whether states are compared with those that owe less
    RowSet rows_;  // the locations of each state
    ActiveSets active_;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting_;
    Arena arena_;
    std::unordered_multimap<std::size_t, NodeId> by_zone_;  // the recorded states, by locations and zone
    Goal goal_;
    std::vector<RecordedStep> recorded_;
    std::vector<Index> recorded_edges_;
    std::size_t visited_ = 0;
    Watch watch_;
    // Room for the work at hand, kept to avoid allocating in the loop.
    std::vector<Bound> driven_;
    std::vector<Bound> settled_;
    std::vector<Index> bounds_;
    std::vector<int> positions_;
};

}  // namespace mitlplan
