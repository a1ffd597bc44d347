#include "tools/calibration_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <optional>

#include "devices/calibration/touch_plan.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

namespace chrono = std::chrono;

std::optional<int> digits(std::string_view text, std::size_t from, std::size_t count) {
    if (text.size() < from + count) return std::nullopt;
    int value = 0;
    const char* const end = text.data() + from + count;
    const auto [last, error] = std::from_chars(text.data() + from, end, value);
    if (error != std::errc{} || last != end) return std::nullopt;
    return value;
}

// The begin of the day, or of the second where there is a time of day. Nothing on a day that no calendar has.
std::optional<CalendarTime> time_of(const std::string& date) {
    const auto year = digits(date, 0, 4);
    const auto month = digits(date, 5, 2);
    const auto day = digits(date, 8, 2);
    if (!year || !month || !day) return std::nullopt;
    const chrono::year_month_day calendar{chrono::year(*year), chrono::month(static_cast<unsigned>(*month)),
                                          chrono::day(static_cast<unsigned>(*day))};
    if (!calendar.ok()) return std::nullopt;
    const chrono::seconds time_of_day = chrono::hours(digits(date, 11, 2).value_or(0)) + chrono::minutes(digits(date, 14, 2).value_or(0)) +
                                        chrono::seconds(digits(date, 17, 2).value_or(0));
    return chrono::sys_days(calendar) + time_of_day;
}

}  // namespace

std::string date_text(CalendarTime time) {
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(chrono::system_clock::to_time_t(time)));
}

double counting_feed(const MachineSettings& machine) {
    const bool is_first = machine.touch.samples == 1 && !machine.touch.discard_first;
    return machine.motion.feeds.of(is_first ? Pace::probe : Pace::touch);
}

SessionConfig with_calibration(SessionConfig config) {
    const std::filesystem::path& file = config.calibration.file;
    if (file.empty() || !config.tool) return config;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) {
        throw CalibrationError(
            fmt::format("{}: does not exist, and tool.calibration names it: qualify the probe (palpate calibrate), or take the key out",
                        file.string()));
    }
    ProbeCalibration calibration = parse_calibration(read_file(file), file.string());
    require_fits(calibration, *config.tool, calibration.feed_mm_per_s, file.string());
    config.probe_calibration = std::move(calibration);
    return config;
}

std::vector<std::string> calibration_warnings(const SessionConfig& config, CalendarTime now) {
    std::vector<std::string> warnings;
    if (!config.probe_calibration) return warnings;
    const ProbeCalibration& calibration = *config.probe_calibration;
    const std::string name = config.calibration.file.string();
    const auto warn = [&](const std::string& what) { warnings.push_back(fmt::format("{}: {}", name, what)); };
    using Days = chrono::duration<double, chrono::days::period>;
    if (const auto made = time_of(calibration.date); !made) {
        warn(fmt::format("its date, {}, is in no calendar: nobody knows how old it is", calibration.date));
    } else if (const Days age = now - *made; age.count() > config.calibration.max_age_days) {
        warn(fmt::format("is {:.0f} days old, more than tool.calibration_max_age, {:.6g}: qualify the probe again", age.count(),
                         config.calibration.max_age_days));
    } else if (age < Days(-1)) {
        warn(fmt::format("is of {}, which is yet to come: look at the clock", calibration.date));
    }
    if (!config.machine) return warnings;
    constexpr double kSame = 1e-6;
    const double feed = counting_feed(*config.machine);
    if (std::abs(feed - calibration.feed_mm_per_s) > kSame) {
        warn(fmt::format("was made at {:.6g} mm/s, and touches count at {:.6g} mm/s: the lobes are others then; qualify the probe again",
                         calibration.feed_mm_per_s, feed));
    }
    if (const double needed = uncorrected_error(calibration); config.machine->touch_error() < needed) {
        warn(
            fmt::format("touches are off by {:.3g} mm before they are corrected, more than the touch error of {:.3g} mm that the session "
                        "reckons with: raise machine.noise",
                        needed, config.machine->touch_error()));
    }
    return warnings;
}

double lobing_range(const LobingMap& map) {
    constexpr std::size_t kDirections = 2000;
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (const Vector& normal : qualification_directions(map.axis, kDirections)) {
        const double pretravel = map.pretravel(normal);
        least = std::min(least, pretravel);
        most = std::max(most, pretravel);
    }
    return most - least;
}

std::string describe(const ProbeCalibration& calibration) {
    return fmt::format("effective radius {:.6g} mm, touches exact to {:.2g} mm (RMS) once corrected, of {}",
                       calibration.effective_radius_mm, calibration.rms_mm, calibration.date);
}

double touching_radius(const SessionConfig& config) {
    return config.probe_calibration ? config.probe_calibration->effective_radius_mm : config.tool->ball_diameter / 2;
}

}  // namespace palpate
