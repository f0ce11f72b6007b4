// Which state of an aim a system reaches first, or whether it reaches none: the zone graph, searched forwards.
//
// A state is a location for each component, the integers, and a zone over the active clocks: all valuations that
// delays lead to (Bengtsson and Yi 2004). With an objective clock the waiting list is ordered by the least time, as in
// search.hpp; without, first in first out, which makes it breadth first. A zone that another one with the same locations
// and integers simulates is dropped, whichever came first: Z in a_LU(Z') (Herbreteau, Srivathsan and Walukiewicz 2012),
// the coarsest test that the bounds of clocks allow. Zones are kept as they are, so none has to be extrapolated and
// closed again; that there are finitely many to keep follows from the test.
// Where a clock that is still read stands still while time passes, zones are only over-approximated: a goal may then be
// no real one, and `run` goes on behind it; an empty waiting list is a proof all the same.
#pragma once

#include <queue>

#include "clocks.hpp"
#include "system.hpp"
#include "watch.hpp"

namespace mitlplan {

using NodeId = std::int32_t;

/// One component's part of a move.
struct Part {
    Index component;
    Index edge;
};

class Reachability {
public:
    /// `memory` in bytes is a limit.
    Reachability(System system, std::size_t memory);
    Reachability(const Reachability&) = delete;
    Reachability& operator=(const Reachability&) = delete;

    /// Searches for about this long, at most up to the limit; `running` means: call again. After `found`, calling
    /// again goes on to the next goal, which is not earlier. `poll` may throw.
    Status run(Seconds budget, Seconds limit = Seconds::max(), std::function<void()> poll = nullptr);

    struct Goal {
        NodeId node = none;
        Ticks time = 0;
        bool strict = false;  // the time is an infimum that is not attained
        Index aim = 0;
    };
    const Goal& goal() const noexcept { return goal_; }
    /// A lower bound on the time of every goal not yet found.
    Ticks lower_bound() const noexcept;
    /// The moves up to a state, the sender of each first.
    std::vector<std::span<const Part>> path_to(NodeId node) const;

    bool approximated() const noexcept { return approximated_; }
    std::size_t visited() const noexcept { return visited_; }
    /// States that lie in no other.
    std::size_t stored() const noexcept { return nodes_.size() - covered_; }
    std::size_t transitions() const noexcept { return transitions_; }
    std::size_t bytes() const noexcept;

private:
    struct Node {
        Index state;
        NodeId parent;
        NodeId next;  // the next one with the same locations and integers
        Index depth;
        std::size_t parts;  // where the move that led here begins
        Bound* zone;
        bool covered;
    };

    struct State {
        Index active;
        NodeId first;
    };

    // A goal goes before the states of its time, and then what came first.
    struct Waiting {
        Ticks time;
        bool strict;
        Index depth;
        bool goes_on;
        NodeId node;
        Index aim;

        friend auto operator<=>(const Waiting&, const Waiting&) = default;
    };

    const ActiveClocks& clocks_of(Index state) const noexcept {
        return active_[states_[static_cast<std::size_t>(state)].active];
    }
    std::span<const Index> locations() const noexcept { return std::span(at_).first(system_.components()); }
    std::span<Index> integers() noexcept { return std::span(at_).subspan(system_.components()); }
    std::span<const Part> parts_of(const Node& node) const noexcept;
    bool committed(Index location) const noexcept { return system_.place(location).urgency == Urgency::committed; }

    void start();
    Index find_state(std::span<const Index> row);
    void expand(NodeId node);
    /// The zone within the guard of an edge whose tests hold, if anything is left: in the room at this depth.
    std::optional<std::span<const Bound>> taken(const Action& action, std::span<const Bound> zone, std::size_t depth);
    std::span<Bound> room(std::span<const Bound> zone, std::size_t depth);
    void pairs(std::size_t sender, Index channel, std::span<const Bound> zone);
    void receivers(std::size_t sender, Index channel, std::size_t component, std::span<const Bound> zone,
                   std::size_t depth);
    void decline(std::size_t sender, Index channel, std::size_t component, Index edge, std::span<const Bound> zone,
                 std::size_t depth);
    /// Makes the move at hand from the part of a zone that its guards leave.
    void move(std::span<const Bound> zone);
    bool elapse(std::span<Bound> zone, const ActiveClocks& clocks, std::span<const Index> locations);
    void store(NodeId parent, Index state, const ActiveClocks& clocks);
    void look_for_goals(const ActiveClocks& clocks);

    System system_;
    std::size_t memory_;
    RowSet rows_;
    ActiveSets active_;
    std::vector<std::uint8_t> bounds_below_;  // by guard: whether it has a lower bound
    std::vector<Node> nodes_;
    std::vector<Part> parts_;
    std::vector<State> states_;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting_;
    Arena arena_;
    Goal goal_;
    bool approximated_ = false;
    std::size_t covered_ = 0;
    std::size_t visited_ = 0;
    std::size_t transitions_ = 0;
    Watch watch_;
    // The expansion at hand: the state and its clocks, and the move that is put together.
    NodeId from_ = none;
    const ActiveClocks* clocks_ = nullptr;
    std::vector<Index> at_;
    std::vector<Part> taking_part_;
    bool must_leave_committed_ = false;
    // Room for the work at hand, kept to avoid allocating in the loop.
    std::deque<std::vector<Bound>> rooms_;
    std::vector<Bound> settled_;
    std::vector<Bound> aimed_;
    std::vector<Index> row_;
    std::vector<Index> resets_;
    std::vector<Index> bounds_rows_;
    std::vector<int> source_;
    std::vector<std::uint8_t> stopped_;
    std::vector<std::pair<Index, Bound>> goals_;  // aims that the settled zone meets, with the bound on their time
};

}  // namespace mitlplan
