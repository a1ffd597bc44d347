#include "tools/run_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "config/reader.h"
#include "tools/simulation.h"

namespace palpate::run_estimate_test {
namespace {

using std::chrono::seconds;

struct Said {
    double fraction = 0.0;
    seconds at{0};
    std::chrono::nanoseconds left{0};
};

// Of whole runs in which a probe takes a second.
std::vector<Said> said_during(const std::string& object, const std::vector<std::string>& overrides) {
    const SessionConfig config = read_config(std::string(PALPATE_SOURCE_DIR) + "/config/examples/" + object + ".yaml", overrides);
    std::vector<Said> said;
    RunEstimate estimate;
    Observer observer;
    std::uint64_t looked_at = 0;
    observer.on_progress = [&](const Progress& progress, const RunView& run) {
        if (progress.probes < looked_at + 20) return;
        looked_at = progress.probes;
        estimate.note(seconds(progress.probes), progress, run.surface());
        said.push_back({estimate.fraction_done(progress), seconds(progress.probes), estimate.time_left().left()});
    };
    (void)simulate(config, build_scene(config), observer);
    return said;
}

// Among what was said from half of the run on.
double share_within_a_third(const std::vector<Said>& all) {
    const seconds end = all.back().at;
    double right = 0;
    double late = 0;
    for (const Said& said : all) {
        if (2 * said.at < end || said.at == end) continue;
        const double ratio = std::chrono::duration<double>(said.left) / std::chrono::duration<double>(end - said.at);
        right += ratio > 2.0 / 3 && ratio < 4.0 / 3;
        ++late;
    }
    return right / late;
}

TEST(RunEstimate, OfTheTimeThatIsLeftIsMostlyRightFromHalfOn) {
    EXPECT_GT(share_within_a_third(said_during("torus", {"probing.epsilon=0.03"})), 0.7);
    EXPECT_GT(share_within_a_third(said_during("bunny", {"probing.epsilon=0.3", "probing.strategy={infer: none}"})), 0.7);
}

// The base is a small part of it, and is not taken for all.
TEST(RunEstimate, KnowsOfATolerance) {
    const std::vector<Said> all =
        said_during("genus2", {"probing.epsilon=0.15", "probing.reach=null", "probing.strategy=adaptive", "probing.tolerance=0.002"});
    const auto half = std::ranges::find_if(all, [&](const Said& said) { return 2 * said.at >= all.back().at; });
    EXPECT_GT(half->fraction, 0.25);
    EXPECT_LT(half->fraction, 0.75);
    EXPECT_GT(share_within_a_third(all), 0.5);
}

TEST(RunEstimate, IsThereFromATenthOn) {
    const std::vector<Said> all = said_during("genus2", {"probing.epsilon=0.06"});
    for (const Said& said : all) {
        EXPECT_GE(said.fraction, 0);
        EXPECT_LT(said.fraction, 1);
        if (5 * said.at > all.back().at && said.at != all.back().at) {
            EXPECT_GT(said.left.count(), 0) << said.at.count();
        }
    }
}

}  // namespace
}  // namespace palpate::run_estimate_test
