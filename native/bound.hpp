// A bound on a difference of two clocks: x - y < v, x - y <= v, or no bound at all.
//
// The pair (value, strictness) is one integer, 2v for < and 2v + 1 for <=, so that the tighter of two bounds
// is the smaller integer and the sum along a path is an addition and a mask (Bengtsson and Yi, Timed Automata:
// Semantics, Algorithms and Tools, 2004, section 4). Values are ticks, |v| < 2^60: two of them can always be
// added in 64 bits, and a sum that leaves the range throws. Infinity is the largest integer and absorbs.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace mitlplan {

using Ticks = std::int64_t;

inline constexpr Ticks tick_limit = Ticks{1} << 60;

struct Bound {
    std::int64_t code;

    friend constexpr auto operator<=>(Bound, Bound) noexcept = default;
};

inline constexpr Bound infinity{std::numeric_limits<std::int64_t>::max()};

namespace detail {

// Out of line, so that the check costs the callers one comparison and a jump never taken.
[[noreturn, gnu::cold, gnu::noinline]] inline void throw_overflow() {
    throw std::overflow_error("a time is too large: more than 2^60 ticks of the common denominator");
}

constexpr bool in_range(std::int64_t number, std::int64_t limit) noexcept {
    return -limit < number && number < limit;
}

}  // namespace detail

/// x - y < value.
constexpr Bound less(Ticks value) {
    if (!detail::in_range(value, tick_limit)) detail::throw_overflow();
    return {value * 2};
}

/// x - y <= value.
constexpr Bound less_equal(Ticks value) {
    if (!detail::in_range(value, tick_limit)) detail::throw_overflow();
    return {value * 2 + 1};
}

inline constexpr Bound zero_bound = less_equal(0);

/// The value of a finite bound.
constexpr Ticks value(Bound bound) noexcept { return bound.code >> 1; }

/// Infinity is no bound on anything, hence not strict.
constexpr bool is_strict(Bound bound) noexcept { return (bound.code & 1) == 0; }

/// The bound that follows from x - y ~ b and y - z ~ c on x - z.
constexpr Bound add(Bound b, Bound c) {
    if (b == infinity || c == infinity) return infinity;
    // The last bit of the sum is to be the conjunction of the last bits: with w and u, w + u - (w | u) = w & u.
    const std::int64_t sum = b.code + c.code - ((b.code | c.code) & 1);
    // -2^60 < v < 2^60 reads -2^61 + 2 <= code <= 2^61 - 1; the code -2^61 + 1 would be v = -2^60.
    if (sum >= 2 * tick_limit || sum < 2 - 2 * tick_limit) detail::throw_overflow();
    return {sum};
}

}  // namespace mitlplan
