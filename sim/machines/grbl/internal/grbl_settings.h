// The numbered settings of a virtual GRBL controller.
#pragma once

#include <map>
#include <string>

#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

class GrblSettings {
public:
    GrblSettings(const VirtualGrblOptions& options, const VirtualToolOptions& tool);

    // Number of the error, or 0. Of the settings, only the ones that are asked for below change anything.
    int set(int number, double value);
    // `$$`: one line per setting, without the `ok`.
    [[nodiscard]] std::string dump() const;

    // What reports hold ($10). Grbl builds leave out by themselves what grblHAL has bits for.
    struct Reports {
        bool machine_position = true;
        bool buffers = false;
        bool pins = true;
        bool offset = true;
        bool overrides = true;
        bool probes = true;
    };
    [[nodiscard]] Reports reports() const;
    [[nodiscard]] bool inches() const { return values_.at(kInches) != 0.0; }
    [[nodiscard]] bool soft_limits() const { return values_.at(kSoftLimits) != 0.0; }
    [[nodiscard]] bool homing() const { return values_.at(kHoming) != 0.0; }
    [[nodiscard]] double max_feed_mm_per_s() const;  // may be 0

private:
    static constexpr int kStatusMask = 10;
    static constexpr int kInches = 13;
    static constexpr int kSoftLimits = 20;
    static constexpr int kHoming = 22;
    static constexpr int kMaxFeed = 110;  // of x; y and z follow

    const int first_told_;  // but for those of reports
    const bool has_report_bits_;
    const Reports built_;
    std::map<int, double> values_;
};

}  // namespace palpate
