// Lower bounds on the time it takes to see several targets, in any order.
//
// Each target is a set of cells; the table of distances says how far every cell is from it. A tour from target to
// target takes at least the least distance between their cells, and the best order is found by dynamic programming
// over subsets (Bellman; Held and Karp 1962), computed only for the subsets that a search meets. With more targets than
// a subset table should hold, the farthest single one is the bound.
#pragma once

#include <bit>

#include "tables.hpp"

namespace mitlplan {

class Tours {
public:
    using Subset = std::uint32_t;

    static constexpr Index largest = 16;

    explicit Tours(const Tables& tables) : tables_(tables), count_(tables.fields()) {
        if (count_ > largest) return;
        const auto count = static_cast<std::size_t>(count_);
        between_.assign(count * count, unreachable);
        // The location before the first is no cell.
        for (Index cell = 0; cell + 1 < tables.driver_locations(); ++cell)
            for (Index from = 0; from < count_; ++from) {
                if (tables.distance(from, cell) != 0) continue;
                for (Index to = 0; to < count_; ++to) {
                    const Ticks distance = tables.distance(to, cell);
                    Ticks& least = between_[index(from, to)];
                    if (distance >= 0) least = std::min(least, distance);
                }
            }
        rest_.assign(count << count, unknown);
    }

    /// The least time from the entry of `cell` until all of `targets` have been seen; `unreachable` if never.
    Ticks bound(Subset targets, Index cell) {
        Ticks least = unreachable;
        Ticks farthest = 0;
        for (Subset left = targets; left != 0; left &= left - 1) {
            const auto first = static_cast<Index>(std::countr_zero(left));
            const Ticks there = tables_.distance(first, cell);
            if (there < 0) return unreachable;
            farthest = std::max(farthest, there);
            if (count_ <= largest) least = std::min(least, sum(there, rest(first, targets & ~(Subset{1} << first))));
        }
        return count_ <= largest && targets != 0 ? least : farthest;
    }

    static constexpr Ticks unreachable = std::numeric_limits<Ticks>::max();

private:
    static constexpr Ticks unknown = -1;

    static Ticks sum(Ticks a, Ticks b) noexcept { return a == unreachable || b == unreachable ? unreachable : a + b; }

    std::size_t index(Index from, Index to) const noexcept {
        return static_cast<std::size_t>(from) * static_cast<std::size_t>(count_) + static_cast<std::size_t>(to);
    }

    Ticks rest(Index from, Subset targets) {
        if (targets == 0) return 0;
        Ticks& known = rest_[(static_cast<std::size_t>(targets) * static_cast<std::size_t>(count_)) +
                             static_cast<std::size_t>(from)];
        if (known != unknown) return known;
        Ticks least = unreachable;
        for (Subset left = targets; left != 0; left &= left - 1) {
            const auto next = static_cast<Index>(std::countr_zero(left));
            least = std::min(least, sum(between_[index(from, next)], rest(next, targets & ~(Subset{1} << next))));
        }
        return known = least;
    }

    const Tables& tables_;
    Index count_;
    std::vector<Ticks> between_;
    std::vector<Ticks> rest_;
};

}  // namespace mitlplan
