// The end of a process that does not end by itself: what a signal asks for happens, however deep the program is in
// some library, and whether or not the interpreter's lock is to be had.
//
// Python hears a signal only between two of its own instructions. Its wakeup descriptor hears it at once; the thread
// here reads from that, and ends the process if the program has not done so when its patience is over.
#pragma once

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <poll.h>
#include <unistd.h>

namespace mitlplan {

/// What is to be done some time after a signal: this sentence on stderr, this exit code.
struct LastWord {
    int signal;
    double patience;
    int code;
    std::string sentence;
};

/// Read from the descriptor instead of a signal: the program has answered what came before.
inline constexpr unsigned char answered = 0;

inline void listen(int descriptor, const std::vector<LastWord>& words) {
    using Clock = std::chrono::steady_clock;
    const LastWord* due = nullptr;
    Clock::time_point when;
    while (true) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(when - Clock::now()).count();
        pollfd waited{descriptor, POLLIN, 0};
        const int ready = poll(&waited, 1, due == nullptr ? -1 : static_cast<int>(std::max<long long>(left, 0)));
        if (ready == 0) {
            // What cannot be said is left unsaid.
            [[maybe_unused]] const auto said = write(STDERR_FILENO, due->sentence.data(), due->sentence.size());
            _exit(due->code);
        }
        unsigned char number = answered;
        // Nobody is left to write to it.
        if (ready < 0 || read(descriptor, &number, 1) != 1) return;
        if (number == answered) {
            due = nullptr;
            continue;
        }
        for (const LastWord& word : words) {
            if (word.signal != number) continue;
            const auto then = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                 std::chrono::duration<double>(word.patience));
            if (due != nullptr && when <= then) continue;
            due = &word;
            when = then;
        }
    }
}

/// Starts the thread, which lives as long as the process and takes no signals itself.
inline void have_the_last_word(int descriptor, std::vector<LastWord> words) {
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    std::thread([descriptor, kept = std::move(words)] { listen(descriptor, kept); }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace mitlplan
