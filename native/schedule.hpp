// Exact times along a path: difference constraints, solved by shortest paths.
//
// The steps of a path happen at times t_0 = 0 < t_1 < ... Each guard and invariant met on the way is a constraint
// t_to - t_from >= weight, or > (an upper bound is one with the roles exchanged and the weight negated). The least
// solution is given by the longest paths from step 0 (Bellman 1958, Ford 1956). A strict constraint adds an
// infinitesimal, so a time is a number of ticks and a number of infinitesimals; the caller chooses how small they are.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "bound.hpp"

namespace mitlplan {

struct Difference {
    std::int32_t from;
    std::int32_t to;
    Ticks weight;
    bool strict;
};

struct InfinitesimalTime {
    Ticks ticks = std::numeric_limits<Ticks>::min();
    std::int64_t infinitesimals = 0;

    friend auto operator<=>(const InfinitesimalTime&, const InfinitesimalTime&) = default;
};

inline Ticks checked_sum(Ticks a, Ticks b) {
    Ticks sum = 0;
    if (__builtin_add_overflow(a, b, &sum)) detail::throw_overflow();
    return sum;
}

/// The least times of `steps` steps; std::domain_error if there are none.
inline std::vector<InfinitesimalTime> earliest_times(std::int32_t steps, std::span<const Difference> differences) {
    std::vector<InfinitesimalTime> times(static_cast<std::size_t>(steps));
    times[0] = {0, 0};
    for (std::int32_t round = 0; round <= steps; ++round) {
        bool changed = false;
        for (const Difference& difference : differences) {
            const InfinitesimalTime& from = times[static_cast<std::size_t>(difference.from)];
            if (from.ticks == std::numeric_limits<Ticks>::min()) continue;
            const InfinitesimalTime reached{checked_sum(from.ticks, difference.weight),
                                            from.infinitesimals + (difference.strict ? 1 : 0)};
            if (reached > times[static_cast<std::size_t>(difference.to)]) {
                times[static_cast<std::size_t>(difference.to)] = reached;
                changed = true;
            }
        }
        if (!changed) {
            if (times[0] != InfinitesimalTime{0, 0}) break;
            return times;
        }
    }
    throw std::domain_error("no times satisfy the constraints of this path");
}

inline constexpr Ticks unlimited = std::numeric_limits<Ticks>::max();

/// How late each step of `asked` may happen, the steps before it as `planned`, the later ones free; `unlimited`
/// where nothing bounds it. Strictness is ignored: the answer is a supremum.
inline std::vector<Ticks> latest_times(std::span<const Ticks> planned, std::span<const Difference> differences,
                                       std::span<const std::int32_t> asked) {
    const std::size_t steps = planned.size();
    // t_from <= t_to - weight: kept by the step that is bounded.
    std::vector<std::vector<Difference>> bounding(steps);
    for (const Difference& difference : differences)
        bounding[static_cast<std::size_t>(difference.from)].push_back(difference);
    std::vector<Ticks> result;
    std::vector<Ticks> latest(steps);
    for (const std::int32_t step : asked) {
        const auto first = static_cast<std::size_t>(step);
        for (std::size_t k = 0; k < first; ++k) latest[k] = planned[k];
        for (std::size_t k = first; k < steps; ++k) latest[k] = unlimited;
        bool changed = true;
        const auto tighten = [&](std::size_t k) {
            for (const Difference& difference : bounding[k]) {
                const Ticks other = latest[static_cast<std::size_t>(difference.to)];
                if (other == unlimited) continue;
                const Ticks bound = checked_sum(other, -difference.weight);
                if (bound >= latest[k]) continue;
                if (bound < planned[k]) throw std::domain_error("the planned times break a constraint");
                latest[k] = bound;
                changed = true;
            }
        };
        // Deadlines bound from behind and longest stays from the front: sweeps both ways carry either through at
        // once. As planned is always possible, so nothing is left to do once that is the bound.
        while (changed && latest[first] != planned[first]) {
            changed = false;
            for (std::size_t k = first; k < steps; ++k) tighten(k);
            for (std::size_t k = steps; k-- > first;) tighten(k);
        }
        result.push_back(latest[first]);
    }
    return result;
}

}  // namespace mitlplan
