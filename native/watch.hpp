// The clock on the wall: how long a search may go on, and when to ask whether anybody wants to interrupt it.
#pragma once

#include <chrono>
#include <functional>

namespace mitlplan {

/// How a search stands: to be gone on with, at a goal, at its end, or out of memory.
enum class Status : int { running = 0, found = 1, exhausted = 2, out_of_memory = 3 };

using Seconds = std::chrono::duration<double>;

/// Thrown when there is no time left in the midst of a state.
struct OutOfTime {};

class Watch {
public:
    void begin(Seconds limit, std::function<void()> poll) {
        began_ = polled_ = std::chrono::steady_clock::now();
        limit_ = limit;
        poll_ = std::move(poll);
    }

    bool over(Seconds budget) const { return std::chrono::steady_clock::now() - began_ > budget; }

    /// To be called in every round of a loop that may be long: looks up once in a while. What `poll` throws gets out.
    void look_up() {
        if (++rounds_ % rounds_between_looks != 0) return;
        const auto now = std::chrono::steady_clock::now();
        if (now - began_ > limit_) throw OutOfTime{};
        if (!poll_ || now - polled_ < between_polls) return;
        polled_ = now;
        poll_();
    }

private:
    static constexpr std::size_t rounds_between_looks = 1024;
    static constexpr std::chrono::milliseconds between_polls{50};

    std::size_t rounds_ = 0;
    std::chrono::steady_clock::time_point began_;
    std::chrono::steady_clock::time_point polled_;
    Seconds limit_ = Seconds::max();
    std::function<void()> poll_;
};

}  // namespace mitlplan
