// How long it takes from each location of the driver to the nearest of some others: shortest paths, backwards.
//
// Dijkstra's algorithm without a heap of locations: maps have few distinct travel times, and what is reached by moves of
// one travel time is reached in order, so a queue for each of them is sorted by itself, and the nearest location is at
// the front of one of the queues (Dial 1969 has a bucket for each distance). With a single travel time this is
// breadth-first search. Distances are cut off far below the limit of ticks, so that sums of them are safe; they remain
// lower bounds.
#pragma once

#include <queue>

#include "tables.hpp"

namespace mitlplan {

inline constexpr Ticks farthest_distance = Ticks{1} << 53;

class Distances {
public:
    /// The moves, each with the number of its travel time.
    Distances(Index locations, std::span<const Index> sources, std::span<const Index> targets,
              std::span<const Index> times, std::span<const Ticks> ticks)
        : ticks_(ticks.begin(), ticks.end()), start_(static_cast<std::size_t>(locations) + 1), into_(sources.size()),
          queues_(ticks.size()) {
        using detail::demand;
        using detail::within;
        demand(targets.size() == sources.size() && times.size() == sources.size(), "columns of different lengths");
        for (const Ticks time : ticks) demand(0 <= time && time < tick_limit, "a travel time");
        const auto count = static_cast<std::size_t>(locations);
        for (std::size_t move = 0; move < sources.size(); ++move) {
            demand(within(sources[move], count) && within(targets[move], count), "a move");
            demand(within(times[move], ticks.size()), "the travel time of a move");
            ++start_[static_cast<std::size_t>(targets[move]) + 1];
        }
        for (std::size_t location = 0; location < count; ++location) start_[location + 1] += start_[location];
        auto next = start_;
        for (std::size_t move = 0; move < sources.size(); ++move)
            into_[next[static_cast<std::size_t>(targets[move])]++] = {sources[move], times[move]};
    }

    /// Writes the distance of each location to the nearest goal, or `none` where there is no way.
    void to(std::span<const Index> goals, std::span<Ticks> distances) {
        std::ranges::fill(distances, none);
        std::vector<Index> reached;
        for (const Index goal : goals) {
            detail::demand(detail::within(goal, distances.size()), "a goal");
            if (distances[static_cast<std::size_t>(goal)] == 0) continue;
            distances[static_cast<std::size_t>(goal)] = 0;
            reached.push_back(goal);
        }
        for (const Index goal : reached) leave(goal, 0, distances);
        while (!fronts_.empty()) {
            const auto [distance, time] = fronts_.top();
            fronts_.pop();
            Queue& queue = queues_[static_cast<std::size_t>(time)];
            const auto location = queue.entries[queue.front++].second;
            if (queue.front < queue.entries.size()) {
                fronts_.emplace(queue.entries[queue.front].first, time);
            } else {
                queue.entries.clear();
                queue.front = 0;
            }
            if (distances[static_cast<std::size_t>(location)] == distance) leave(location, distance, distances);
        }
    }

private:
    struct Queue {
        std::vector<std::pair<Ticks, Index>> entries;
        std::size_t front = 0;
    };

    void leave(Index location, Ticks distance, std::span<Ticks> distances) {
        const auto at = static_cast<std::size_t>(location);
        for (std::size_t entry = start_[at]; entry < start_[at + 1]; ++entry) {
            const auto [source, time] = into_[entry];
            const Ticks there = std::min(distance + ticks_[static_cast<std::size_t>(time)], farthest_distance);
            Ticks& known = distances[static_cast<std::size_t>(source)];
            if (known != none && known <= there) continue;
            known = there;
            Queue& queue = queues_[static_cast<std::size_t>(time)];
            if (queue.front == queue.entries.size()) fronts_.emplace(there, time);
            queue.entries.emplace_back(there, source);
        }
    }

    std::vector<Ticks> ticks_;
    std::vector<std::size_t> start_;
    std::vector<std::pair<Index, Index>> into_;  // the moves into each location: whence, and the number of the time
    std::vector<Queue> queues_;
    std::priority_queue<std::pair<Ticks, Index>, std::vector<std::pair<Ticks, Index>>, std::greater<>> fronts_;
};

}  // namespace mitlplan
