// What a virtual controller has said and nobody has taken, and what becomes of it on the way.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "planner/machine_time.h"

namespace palpate {

class GrblOutput {
public:
    void say(std::string_view text) {
        const std::size_t lost = std::min(to_lose_, text.size());
        to_lose_ -= lost;
        (held_until_ ? held_ : ready_) += text.substr(lost);
    }
    void lose(std::size_t bytes) { to_lose_ += bytes; }
    void hold_back(Seconds until) { held_until_ = until; }
    void release(Seconds now) {
        if (!held_until_ || now < *held_until_) return;
        held_until_.reset();
        ready_ += std::exchange(held_, {});
    }
    [[nodiscard]] std::optional<Seconds> held_until() const { return held_until_; }
    [[nodiscard]] std::string take() { return std::exchange(ready_, {}); }
    void drop() { *this = {}; }

private:
    std::string ready_;
    std::string held_;
    std::optional<Seconds> held_until_;
    std::size_t to_lose_ = 0;
};

}  // namespace palpate
