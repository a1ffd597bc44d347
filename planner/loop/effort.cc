#include "planner/loop/effort.h"

namespace palpate {

bool Effort::is_spent(const Point& place) const {
    const auto found = cells_.find(cell_of(place));
    return found != cells_.end() && found->second.probes > kTries + kPerSample * found->second.samples;
}

void Effort::note_guess(const Point& place, std::uint64_t probes, bool was_right) {
    Spent& spent = cells_[cell_of(place)];
    (was_right ? spent.right_guesses : spent.wrong_guesses) += probes;
}

bool Effort::is_guesswork(const Point& place) const {
    const auto found = cells_.find(cell_of(place));
    return found != cells_.end() && found->second.wrong_guesses > kGuesses + kPerGuess * found->second.right_guesses;
}

void Effort::give_up(const Point& place) {
    Spent& spent = cells_[cell_of(place)];
    if (!spent.is_given_up) given_up_.push_back(place);
    spent.is_given_up = true;
}

}  // namespace palpate
