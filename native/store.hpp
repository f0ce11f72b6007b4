// Where a search keeps what it has found: rows of integers that are numbered, and memory that never moves.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tables.hpp"
#include "zone.hpp"

namespace mitlplan {

/// Rows of equally many integers; the same row always has the same number. Open addressing, because there are
/// millions of short rows and none is ever taken out.
class RowSet {
public:
    explicit RowSet(std::size_t width) : width_(width), slots_(1024, 0) {}

    /// The number of a row, and whether it is new.
    std::pair<Index, bool> insert(std::span<const Index> row) {
        std::size_t slot = free_or_same(slots_, row);
        if (slots_[slot] != 0) return {slots_[slot] - 1, false};
        if (count_ >= limit) throw std::overflow_error("more than 2^31 states");
        entries_.insert(entries_.end(), row.begin(), row.end());
        slots_[slot] = ++count_;
        if (static_cast<std::size_t>(count_) * 2 > slots_.size()) grow();
        return {count_ - 1, true};
    }

    std::span<const Index> operator[](Index number) const noexcept {
        return std::span(entries_).subspan(static_cast<std::size_t>(number) * width_, width_);
    }

    std::size_t bytes() const noexcept { return (entries_.capacity() + slots_.capacity()) * sizeof(Index); }

private:
    static constexpr Index limit = std::numeric_limits<Index>::max() - 1;

    static std::size_t hash(std::span<const Index> row) noexcept {
        std::uint64_t mixed = 0x9E3779B97F4A7C15u;
        for (const Index entry : row) {
            mixed ^= static_cast<std::uint64_t>(static_cast<std::uint32_t>(entry));
            mixed *= 0xFF51AFD7ED558CCDu;
            mixed ^= mixed >> 33;
        }
        return static_cast<std::size_t>(mixed);
    }

    std::size_t free_or_same(const std::vector<Index>& slots, std::span<const Index> row) const noexcept {
        const std::size_t mask = slots.size() - 1;
        std::size_t slot = hash(row) & mask;
        while (slots[slot] != 0 && !std::ranges::equal((*this)[slots[slot] - 1], row)) slot = (slot + 1) & mask;
        return slot;
    }

    void grow() {
        std::vector<Index> larger(slots_.size() * 4, 0);
        for (Index number = 0; number < count_; ++number) larger[free_or_same(larger, (*this)[number])] = number + 1;
        slots_ = std::move(larger);
    }

    std::size_t width_;
    Index count_ = 0;
    std::vector<Index> entries_;
    std::vector<Index> slots_;  // number + 1, or 0
};

/// Memory for zones that is handed out piece by piece and never moves. What is given back is handed out again.
class Arena {
public:
    Bound* allocate(std::size_t count) {
        if (count < returned_.size() && !returned_[count].empty()) {
            Bound* const result = returned_[count].back();
            returned_[count].pop_back();
            return result;
        }
        if (count > free_) {
            const std::size_t size = std::max(block, count);
            blocks_.push_back(std::make_unique_for_overwrite<Bound[]>(size));
            bytes_ += size * sizeof(Bound);
            free_ = size;
            used_ = 0;
        }
        Bound* const result = blocks_.back().get() + used_;
        used_ += count;
        free_ -= count;
        return result;
    }

    void give_back(Bound* piece, std::size_t count) {
        if (count >= returned_.size()) returned_.resize(count + 1);
        returned_[count].push_back(piece);
    }

    std::size_t bytes() const noexcept { return bytes_; }

private:
    static constexpr std::size_t block = std::size_t{1} << 16;

    std::vector<std::unique_ptr<Bound[]>> blocks_;
    std::vector<std::vector<Bound*>> returned_;  // by length
    std::size_t free_ = 0;
    std::size_t used_ = 0;
    std::size_t bytes_ = 0;
};

}  // namespace mitlplan
