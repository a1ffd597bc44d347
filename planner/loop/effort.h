// Ends work that leads to nothing: what a run asks at one place is bounded by the samples that it found there.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "planner/geometry.h"
#include "planner/loop/grid_cell.h"

namespace palpate {

// Places are cells of a grid, so large that a finished one holds some samples. At each, work is given up after kTries probes, and
// kPerSample more for every sample found there. As places are those of samples, a run asks at most (kTries + kPerSample) · samples
// probes besides those of its seeds, whatever the world answers; and samples keep a spacing, so their number is bounded by what can be
// packed on the surface that was touched.
class Effort {
public:
    // Measured on 220 runs on random parts: 0.27 of that at most.
    static constexpr std::uint64_t kTries = 200;
    static constexpr std::uint64_t kPerSample = 100;

    // The front (advancing_front.h) asks where it guesses that S is. Where that mostly fails it leaves a place to the walks: after
    // kGuesses probes that brought nothing, and kPerGuess more for each that did.
    static constexpr std::uint64_t kGuesses = 40;
    static constexpr std::uint64_t kPerGuess = 1;

    // `epsilon` (mm): how far samples are apart where nothing asks for more.
    explicit Effort(double epsilon) : cell_size_(kCell * epsilon) {}

    void note_probes(const Point& place, std::uint64_t count) { cells_[cell_of(place)].probes += count; }
    void note_sample(const Point& place) { ++cells_[cell_of(place)].samples; }
    [[nodiscard]] bool is_spent(const Point& place) const;
    void note_guess(const Point& place, std::uint64_t probes, bool was_right);
    [[nodiscard]] bool is_guesswork(const Point& place) const;
    // Work was left undone there.
    void give_up(const Point& place);
    // The first such place of every cell.
    [[nodiscard]] const std::vector<Point>& given_up() const { return given_up_; }

private:
    static constexpr double kCell = 4.0;  // of epsilon
    struct Spent {
        std::uint64_t probes = 0;
        std::uint64_t samples = 0;
        std::uint64_t wrong_guesses = 0;
        std::uint64_t right_guesses = 0;
        bool is_given_up = false;
    };
    [[nodiscard]] GridCell cell_of(const Point& p) const { return grid_cell(p, cell_size_); }

    const double cell_size_;
    std::map<GridCell, Spent> cells_;
    std::vector<Point> given_up_;
};

}  // namespace palpate
