// Which clocks a state needs, and how a zone over these alone is constrained.
//
// A clock that every component resets before it reads it is not active and leaves the zone (Daws and Yovine 1996). The
// constants an active clock is still compared with, from below and from above, are those of the extrapolation; each
// location names its own, and a state has the largest of its components (Behrmann, Bouyer, Fleury, Larsen 2003).
#pragma once

#include <deque>

#include "store.hpp"

namespace mitlplan {

namespace detail {

[[noreturn, gnu::cold, gnu::noinline]] inline void throw_inactive() {
    throw std::invalid_argument("the tables of the network are damaged: a guard reads a clock that is not active");
}

}  // namespace detail

/// The clocks of a state, ascending, with clock 0 first, and their bounds for extrapolation.
struct ActiveClocks {
    std::vector<int> clocks;
    std::vector<Ticks> lower;
    std::vector<Ticks> upper;

    int dimension() const noexcept { return static_cast<int>(clocks.size()); }
    int position(Index clock) const noexcept {
        const auto found = std::ranges::lower_bound(clocks, clock);
        return found != clocks.end() && *found == clock ? static_cast<int>(found - clocks.begin()) : none;
    }
};

/// The active clocks of all states met so far.
class ActiveSets {
public:
    /// `time` is the clock of the objective, or none: it is always active.
    ActiveSets(const Rows<ClockBounds>& bounds, Index clocks, Index time, std::size_t components)
        : bounds_(bounds),
          time_(time),
          keys_(components),
          lower_(static_cast<std::size_t>(clocks)),
          upper_(static_cast<std::size_t>(clocks)),
          seen_(static_cast<std::size_t>(clocks)) {}

    /// The number of the set that belongs to these rows of bounds, one of each component.
    Index find(std::span<const Index> rows) {
        const auto [number, fresh] = keys_.insert(rows);
        if (fresh) sets_.push_back(join(rows));
        return number;
    }

    /// Stays where it is while others are added.
    const ActiveClocks& operator[](Index number) const noexcept { return sets_[static_cast<std::size_t>(number)]; }

private:
    ActiveClocks join(std::span<const Index> rows) {
        ActiveClocks result;
        result.clocks.assign(1, 0);
        if (time_ != none) result.clocks.push_back(time_);
        for (const Index row : rows)
            for (const ClockBounds& bounds : bounds_[row]) {
                const auto clock = static_cast<std::size_t>(bounds.clock);
                if (!seen_[clock]) {
                    seen_[clock] = 1;
                    lower_[clock] = bounds.lower;
                    upper_[clock] = bounds.upper;
                    result.clocks.push_back(bounds.clock);
                } else {
                    lower_[clock] = std::max(lower_[clock], bounds.lower);
                    upper_[clock] = std::max(upper_[clock], bounds.upper);
                }
            }
        std::ranges::sort(result.clocks);
        result.lower.resize(result.clocks.size());
        result.upper.resize(result.clocks.size());
        for (std::size_t k = 1; k < result.clocks.size(); ++k) {
            const auto clock = static_cast<std::size_t>(result.clocks[k]);
            if (result.clocks[k] == time_) {
                // Later is never better: no lower bound is ever asked of the time. What it is, is the objective.
                result.lower[k] = no_bound;
                result.upper[k] = std::numeric_limits<Ticks>::max();
                continue;
            }
            result.lower[k] = lower_[clock];
            result.upper[k] = upper_[clock];
            seen_[clock] = 0;
        }
        return result;
    }

    const Rows<ClockBounds>& bounds_;
    Index time_;
    RowSet keys_;
    std::deque<ActiveClocks> sets_;
    // Room for the work at hand, by clock.
    std::vector<Ticks> lower_;
    std::vector<Ticks> upper_;
    std::vector<std::uint8_t> seen_;
};

/// Intersects a zone with one bound; false if nothing is left.
inline bool constrain(std::span<Bound> zone, const ActiveClocks& clocks, const Constraint& constraint) {
    const int position = clocks.position(constraint.clock);
    // Whether the bounds of the locations name every clock that is read there shows only here.
    if (position == none) detail::throw_inactive();
    const int i = constraint.upper ? position : 0;
    const int j = constraint.upper ? 0 : position;
    return dbm::constrain(zone, clocks.dimension(), i, j, constraint.bound);
}

/// Intersects a zone with a guard; false if nothing is left.
inline bool constrain(std::span<Bound> zone, const ActiveClocks& clocks, std::span<const Constraint> guard) {
    return std::ranges::all_of(guard, [&](const Constraint& each) { return constrain(zone, clocks, each); });
}

/// What is left of a zone over the clocks of `before` when some are reset and only those of `after` are needed.
/// `source` is room for the work at hand.
inline void carry_over(std::span<const Bound> zone, const ActiveClocks& before, std::span<const Index> resets,
                       const ActiveClocks& after, std::vector<int>& source, std::vector<Bound>& result) {
    source.assign(after.clocks.begin(), after.clocks.end());
    for (int& clock : source) clock = clock == 0 ? 0 : before.position(clock);
    for (const Index clock : resets) {
        const int position = after.position(clock);
        if (position != none) source[static_cast<std::size_t>(position)] = fresh_clock;
    }
    result.resize(dbm::size(after.dimension()));
    dbm::remap(zone, before.dimension(), source, result);
}

}  // namespace mitlplan
