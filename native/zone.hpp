// Zones: the sets of clock valuations that a conjunction of constraints x_i - x_j ~ b describes.
//
// A zone of dimension n is an n x n matrix D (a difference bound matrix: Dill 1989), row-major, D[i][j] bounding
// x_i - x_j; x_0 is the constant 0, so D[i][0] is the upper bound of clock i and D[0][i] its lower bound, negated.
// The matrix is a weighted graph. It describes no valuation at all if and only if a cycle is negative; otherwise
// replacing every entry by the shortest path makes it closed, which is a normal form: every entry is then attained
// (or approached), inclusion is entrywise <=, and projection is deletion of rows and columns.
//
// Invariant, of every function here: a zone that comes in closed goes out closed. The empty zone has one
// representation too, every entry (0, <), and stays empty. All clocks are >= 0. If an overflow is thrown the zone
// written to is lost; nothing else is.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "bound.hpp"

namespace mitlplan {

/// The largest constant a clock is compared with, when it is compared with none.
inline constexpr Ticks no_bound = std::numeric_limits<Ticks>::min();

/// In `remap`: no clock of the old zone, but a new one with the value 0.
inline constexpr int fresh_clock = -1;

/// The operations, on matrices that live anywhere: a search keeps its zones in one flat arena.
namespace dbm {

constexpr std::size_t size(int dimension) noexcept {
    return static_cast<std::size_t>(dimension) * static_cast<std::size_t>(dimension);
}

constexpr std::size_t entry(int dimension, int i, int j) noexcept {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(j);
}

/// Not named `empty`: a call on a span would silently mean std::empty.
inline bool is_empty(std::span<const Bound> zone) noexcept { return zone[0] < zero_bound; }

inline void mark_empty(std::span<Bound> zone) noexcept { std::ranges::fill(zone, Bound{less(0)}); }

/// Every clock is 0.
inline void set_zero(std::span<Bound> zone) noexcept { std::ranges::fill(zone, zero_bound); }

/// Every clock has any value >= 0.
inline void set_universe(std::span<Bound> zone, int dimension) noexcept {
    std::ranges::fill(zone, infinity);
    for (int i = 0; i < dimension; ++i) {
        zone[entry(dimension, 0, i)] = zero_bound;
        zone[entry(dimension, i, i)] = zero_bound;
    }
}

/// Closes any matrix (Floyd and Warshall); false, and the empty zone, if there is a negative cycle. O(n^3).
inline bool close(std::span<Bound> zone, int dimension) {
    for (int k = 0; k < dimension; ++k) {
        const Bound* const through = &zone[entry(dimension, k, 0)];
        for (int i = 0; i < dimension; ++i) {
            Bound* const row = &zone[entry(dimension, i, 0)];
            const Bound first = row[k];
            if (first == infinity) continue;
            for (int j = 0; j < dimension; ++j) row[j] = std::min(row[j], add(first, through[j]));
            // Looked at in every round: past a negative cycle the numbers would double with each one, and
            // an inconsistent matrix be reported as an overflow.
            if (row[i] < zero_bound) return mark_empty(zone), false;
        }
    }
    return true;
}

/// Adds x_i - x_j ~ bound; false, and the empty zone, if nothing is left. O(n^2).
inline bool constrain(std::span<Bound> zone, int dimension, int i, int j, Bound bound) {
    if (is_empty(zone)) return false;
    if (bound >= zone[entry(dimension, i, j)]) return true;
    if (add(bound, zone[entry(dimension, j, i)]) < zero_bound) return mark_empty(zone), false;
    // A shortest path uses the new edge at most once: k to i, the edge, j to l. Row j and column i, which are
    // read, do not change, because the cycle over the new edge is not negative: the update may be in place.
    const Bound* const from_j = &zone[entry(dimension, j, 0)];
    for (int k = 0; k < dimension; ++k) {
        Bound* const row = &zone[entry(dimension, k, 0)];
        const Bound to_j = add(row[i], bound);
        if (to_j >= row[j]) continue;
        for (int l = 0; l < dimension; ++l) row[l] = std::min(row[l], add(to_j, from_j[l]));
    }
    return true;
}

/// Time passes, possibly none: { v + d | v in zone, d >= 0 }.
inline void up(std::span<Bound> zone, int dimension) noexcept {
    if (is_empty(zone)) return;
    for (int i = 1; i < dimension; ++i) zone[entry(dimension, i, 0)] = infinity;
}

/// Some time passes: { v + d | v in zone, d > 0 }. Upper bounds go, lower bounds become strict.
///
/// Exact: w is in the result iff some d has 0 < d, w_i - D[i][0] <~ d and d <~ w_j + D[0][j] for all i, j. On a
/// line such a d exists iff every lower end is below every upper end: 0 < w_j + D[0][j] is the strict new lower
/// bound, and w_i - w_j <~ D[i][0] + D[0][j] is implied by D[i][j], which is kept and, closed, not larger.
/// Closed: a path into 0 is now infinite, so only D'[0][j] <= D'[0][i] + D[i][j] can fail. Old closure gives it for
/// the values; where these are equal the left side, being strict, is the smallest bound with that value.
inline void up_strict(std::span<Bound> zone, int dimension) noexcept {
    if (is_empty(zone)) return;
    for (int i = 1; i < dimension; ++i) {
        zone[entry(dimension, i, 0)] = infinity;
        zone[entry(dimension, 0, i)].code &= ~std::int64_t{1};
    }
}

/// Time passes, possibly none, for the clocks that are not stopped: the least zone around { v + d * r | v in zone, d >=
/// 0 } with r_i = 0 for stopped clocks and 1 for the others. That set is no zone where a stopped and a running clock
/// are related to others (Cassez and Larsen 2000, The impressive power of stopwatches): an over-approximation. Bounds
/// of running on stopped clocks go. Closed: what is left of a path into a running clock never leads over the removed
/// entries, and a path into a stopped clock begins at one.
inline void up_partly(std::span<Bound> zone, int dimension, std::span<const std::uint8_t> stopped) noexcept {
    if (is_empty(zone)) return;
    for (int i = 1; i < dimension; ++i) {
        if (stopped[static_cast<std::size_t>(i)] != 0) continue;
        for (int j = 0; j < dimension; ++j)
            if (j == 0 || stopped[static_cast<std::size_t>(j)] != 0) zone[entry(dimension, i, j)] = infinity;
    }
}

/// x_i := value, which is >= 0. O(n).
inline void reset(std::span<Bound> zone, int dimension, int i, Ticks value = 0) {
    assert(0 < i && i < dimension && 0 <= value);
    if (is_empty(zone)) return;
    const Bound above = less_equal(value);
    const Bound below = less_equal(-value);
    for (int j = 0; j < dimension; ++j) {
        if (j == i) continue;
        zone[entry(dimension, i, j)] = add(above, zone[entry(dimension, 0, j)]);
        zone[entry(dimension, j, i)] = add(zone[entry(dimension, j, 0)], below);
    }
}

/// Forgets x_i: any value >= 0. O(n).
inline void free(std::span<Bound> zone, int dimension, int i) noexcept {
    assert(0 < i && i < dimension);
    if (is_empty(zone)) return;
    for (int j = 0; j < dimension; ++j) {
        if (j == i) continue;
        zone[entry(dimension, i, j)] = infinity;
        zone[entry(dimension, j, i)] = zone[entry(dimension, j, 0)];
    }
}

/// Whether every valuation of `inner` is one of `outer`. O(n^2), and mostly much less.
inline bool includes(std::span<const Bound> outer, std::span<const Bound> inner) noexcept {
    assert(outer.size() == inner.size());
    if (is_empty(inner)) return true;
    for (std::size_t k = 0; k < outer.size(); ++k)
        if (outer[k] < inner[k]) return false;
    return true;
}

inline bool equals(std::span<const Bound> a, std::span<const Bound> b) noexcept {
    return std::ranges::equal(a, b);
}

/// Keeps the valuations that are in `other` too; false, and the empty zone, if there are none. O(n^3).
inline bool intersect(std::span<Bound> zone, std::span<const Bound> other, int dimension) {
    bool changed = false;
    for (std::size_t k = 0; k < zone.size(); ++k) {
        if (other[k] >= zone[k]) continue;
        zone[k] = other[k];
        changed = true;
    }
    if (is_empty(zone)) return mark_empty(zone), false;
    return !changed || close(zone, dimension);
}

/// Extra+_LU (Behrmann, Bouyer, Larsen, Pelanek: Lower and upper bounds in zone-based abstractions of timed
/// automata, 2006, section 4.2), closed again: the valuations that a diagonal-free automaton cannot tell from
/// those of the zone, as far as bounds can say it. lower[i] (upper[i]) is the largest constant in a constraint
/// x_i > c or >= c (x_i < c or <= c) still to be met; `no_bound`, or anything negative, if there is none.
/// lower[0] and upper[0] are not read. Returns whether the zone has grown.
inline bool extrapolate_lu_plus(std::span<Bound> zone, int dimension, std::span<const Ticks> lower,
                                std::span<const Ticks> upper) {
    if (is_empty(zone)) return false;
    bool changed = false;
    const auto loosen = [&changed](Bound& bound, Bound looser) noexcept {
        changed |= bound != looser;
        bound = looser;
    };
    const auto least = [&zone](int i) noexcept { return -value(zone[static_cast<std::size_t>(i)]); };
    // Row 0 is what the other rows are judged by: it goes last.
    for (int i = 1; i < dimension; ++i) {
        const Ticks largest = lower[static_cast<std::size_t>(i)];
        const bool above = least(i) > largest;
        for (int j = 0; j < dimension; ++j) {
            Bound& bound = zone[entry(dimension, i, j)];
            if (i == j || bound == infinity) continue;
            const bool hidden = j != 0 && least(j) > upper[static_cast<std::size_t>(j)];
            if (above || hidden || value(bound) > largest) loosen(bound, infinity);
        }
    }
    for (int j = 1; j < dimension; ++j) {
        const Ticks largest = upper[static_cast<std::size_t>(j)];
        if (least(j) > largest) loosen(zone[static_cast<std::size_t>(j)], largest < 0 ? zero_bound : less(-largest));
    }
    if (changed) close(zone, dimension);
    return changed;
}

/// Whether a diagonal-free automaton can do from `outer` all it can do from `inner`: whether every valuation of `inner`
/// is simulated by one of `outer`, i.e. `inner` lies in a_LU(outer). That set is no zone, but the test is O(n^2)
/// (Herbreteau, Srivathsan and Walukiewicz 2012, Better abstractions for timed automata, theorem 34). Bounds as for
/// `extrapolate_lu_plus`, whose result lies in a_LU(zone): zones that were extrapolated may be compared.
inline bool simulates(std::span<const Bound> outer, std::span<const Bound> inner, int dimension,
                      std::span<const Ticks> lower, std::span<const Ticks> upper) noexcept {
    if (is_empty(inner)) return true;
    if (is_empty(outer)) return false;
    for (int x = 0; x < dimension; ++x) {
        const Bound least = inner[static_cast<std::size_t>(x)];
        // Whether every value of x is beyond its upper constant: inner(0, x) < (<=, -U_x).
        const Ticks beyond = x == 0 ? 0 : upper[static_cast<std::size_t>(x)];
        if (-value(least) > beyond || (-value(least) == beyond && is_strict(least))) continue;
        for (int y = 0; y < dimension; ++y) {
            const Bound wide = outer[entry(dimension, y, x)];
            if (wide >= inner[entry(dimension, y, x)]) continue;
            const Ticks largest = y == 0 ? 0 : lower[static_cast<std::size_t>(y)];
            // outer(y, x) + (<, -L_y) < inner(0, x), where the left side is strict.
            if (largest >= 0 && value(wide) - largest <= value(least)) {
                if (value(wide) - largest < value(least) || !is_strict(least)) return false;
            }
        }
    }
    return true;
}

/// The zone `to`, of dimension source.size(), whose clock k is clock source[k] of `from`, or a new clock with the
/// value 0 if source[k] is `fresh_clock`. source[0] is 0. Dropping, adding, copying and permuting clocks at once:
/// a new clock is a copy of x_0, and a closed matrix stays closed when rows and columns are taken from it.
inline void remap(std::span<const Bound> from, int dimension, std::span<const int> source,
                  std::span<Bound> to) noexcept {
    assert(!source.empty() && source[0] == 0 && to.size() == source.size() * source.size());
    std::size_t next = 0;
    for (const int i : source)
        for (const int j : source) to[next++] = from[entry(dimension, std::max(i, 0), std::max(j, 0))];
}

inline std::size_t hash(std::span<const Bound> zone) noexcept {
    std::uint64_t mixed = zone.size();
    for (const Bound bound : zone) {
        mixed ^= static_cast<std::uint64_t>(bound.code);
        mixed *= 0x9E3779B97F4A7C15u;  // 2^64 divided by the golden ratio: spreads low bits upward
        mixed ^= mixed >> 32;
    }
    return static_cast<std::size_t>(mixed);
}

}  // namespace dbm

/// A zone that owns its matrix; see the head of this file for what a zone is.
class Zone {
public:
    static Zone zero(int dimension) {
        Zone zone(dimension);
        dbm::set_zero(zone.matrix_);
        return zone;
    }

    static Zone universe(int dimension) {
        Zone zone(dimension);
        dbm::set_universe(zone.matrix_, dimension);
        return zone;
    }

    /// The valuations, of clocks >= 0, that satisfy every entry of a matrix that need not be closed.
    static Zone from_matrix(std::span<const Bound> matrix, int dimension) {
        Zone zone = universe(dimension);
        dbm::intersect(zone.matrix_, matrix, dimension);
        return zone;
    }

    int dimension() const noexcept { return dimension_; }
    std::span<const Bound> matrix() const noexcept { return matrix_; }
    Bound at(int i, int j) const noexcept { return matrix_[dbm::entry(dimension_, i, j)]; }
    Bound upper(int i) const noexcept { return at(i, 0); }
    /// The bound on 0 - x_i: its value is the least value of x_i, negated.
    Bound lower(int i) const noexcept { return at(0, i); }
    bool empty() const noexcept { return dbm::is_empty(matrix_); }

    bool constrain(int i, int j, Bound bound) { return dbm::constrain(matrix_, dimension_, i, j, bound); }
    void up() noexcept { dbm::up(matrix_, dimension_); }
    void up_strict() noexcept { dbm::up_strict(matrix_, dimension_); }
    void up_partly(std::span<const std::uint8_t> stopped) noexcept { dbm::up_partly(matrix_, dimension_, stopped); }
    void reset(int i, Ticks value = 0) { dbm::reset(matrix_, dimension_, i, value); }
    void free(int i) noexcept { dbm::free(matrix_, dimension_, i); }
    bool close() { return dbm::close(matrix_, dimension_); }
    bool intersect(const Zone& other) { return dbm::intersect(matrix_, other.matrix_, dimension_); }
    bool extrapolate_lu_plus(std::span<const Ticks> lower, std::span<const Ticks> upper) {
        return dbm::extrapolate_lu_plus(matrix_, dimension_, lower, upper);
    }

    bool includes(const Zone& other) const noexcept { return dbm::includes(matrix_, other.matrix_); }
    bool simulates(const Zone& other, std::span<const Ticks> lower, std::span<const Ticks> upper) const noexcept {
        return dbm::simulates(matrix_, other.matrix_, dimension_, lower, upper);
    }
    bool equals(const Zone& other) const noexcept { return dbm::equals(matrix_, other.matrix_); }
    bool intersects(const Zone& other) const { return Zone(*this).intersect(other); }
    std::size_t hash() const noexcept { return dbm::hash(matrix_); }

    /// See `dbm::remap`.
    Zone remap(std::span<const int> source) const {
        Zone zone(static_cast<int>(source.size()));
        dbm::remap(matrix_, dimension_, source, zone.matrix_);
        return zone;
    }

    /// The zone of the `kept` clocks alone, in that order; x_0 is kept without being named.
    Zone project(std::span<const int> kept) const {
        std::vector<int> source{0};
        source.insert(source.end(), kept.begin(), kept.end());
        return remap(source);
    }

private:
    explicit Zone(int dimension) : dimension_(dimension), matrix_(dbm::size(dimension), zero_bound) {}

    int dimension_;
    std::vector<Bound> matrix_;
};

}  // namespace mitlplan
