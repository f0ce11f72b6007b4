// Exact times along a path: difference constraints, solved by shortest paths.
//
// The steps of a path happen at times t_0 = 0 < t_1 < ... Each guard and invariant met on the way is a constraint
// t_to - t_from >= weight, or > (an upper bound is one with the roles exchanged and the weight negated). The least
// solution is given by the longest paths from step 0 (Bellman 1958, Ford 1956). A strict constraint adds an
// infinitesimal, so a time is a number of ticks and a number of infinitesimals; the caller chooses how small they are.
#pragma once

#include <cstdint>
#include <limits>
#include <queue>
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
///
/// The steps are fixed one after the other. What bounded a step before still does, so bounds only fall, and all that
/// one more fixed step does is to lower those that lean on it: along most paths none or few.
inline std::vector<Ticks> latest_times(std::span<const Ticks> planned, std::span<const Difference> differences,
                                       std::span<const std::int32_t> asked) {
    const std::size_t steps = planned.size();
    // t_from <= t_to - weight: looked at when t_to has fallen.
    std::vector<std::vector<Difference>> leaning(steps);
    for (const Difference& difference : differences) {
        // Where the planned times keep every constraint no bound can fall round and round.
        if (checked_sum(planned[static_cast<std::size_t>(difference.from)], difference.weight) >
            planned[static_cast<std::size_t>(difference.to)])
            throw std::domain_error("the planned times break a constraint");
        leaning[static_cast<std::size_t>(difference.to)].push_back(difference);
    }
    std::vector<Ticks> latest(steps, unlimited);
    std::vector<Ticks> free(steps);
    // The last step first: most bounds come from the step behind.
    std::priority_queue<std::size_t> fallen;
    for (std::size_t step = 0; step < steps; ++step) {
        free[step] = latest[step];
        if (latest[step] != planned[step]) fallen.push(step);
        latest[step] = planned[step];
        while (!fallen.empty()) {
            const std::size_t lower = fallen.top();
            fallen.pop();
            for (const Difference& difference : leaning[lower]) {
                const auto from = static_cast<std::size_t>(difference.from);
                const Ticks bound = checked_sum(latest[lower], -difference.weight);
                if (bound >= latest[from]) continue;
                latest[from] = bound;
                fallen.push(from);
            }
        }
    }
    std::vector<Ticks> result;
    for (const std::int32_t step : asked) result.push_back(free[static_cast<std::size_t>(step)]);
    return result;
}

}  // namespace mitlplan
