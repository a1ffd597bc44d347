// Which of the numbers from 0 to n - 1 have been joined.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace palpate {

class UnionFind {
public:
    explicit UnionFind(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }

    // The same number for all that are joined: the least of them, whatever the order.
    [[nodiscard]] std::size_t root(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    // Were they apart?
    bool join(std::size_t i, std::size_t j) {
        const std::size_t a = root(i);
        const std::size_t b = root(j);
        parent_[std::max(a, b)] = std::min(a, b);
        return a != b;
    }

private:
    std::vector<std::size_t> parent_;
};

}  // namespace palpate
