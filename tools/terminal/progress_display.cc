#include "tools/terminal/progress_display.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/terminal/text_width.h"

namespace palpate {

namespace {

constexpr std::chrono::milliseconds kTerminalPeriod{100};  // smooth to the eye, nothing for the machine
constexpr std::chrono::seconds kPipePeriod{2};
constexpr int kDefaultColumns = 80;
constexpr int kMinBarColumns = 6;
constexpr int kMaxBarColumns = 40;
// Of a column; whole ones are drawn as blocks.
constexpr std::array<std::string_view, 8> kEighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
constexpr std::string_view kGap = "  ";

bool mentions_utf8(const char* locale) {
    const std::string_view text = locale;
    for (const std::string_view name : {"UTF-8", "utf8", "UTF8", "utf-8"}) {
        if (text.find(name) != std::string_view::npos) {
            return true;
        }
    }
    return false;
}

// POSIX: the first of these that is set and not empty decides about characters.
bool locale_is_utf8() {
    for (const char* variable : {"LC_ALL", "LC_CTYPE", "LANG"}) {
        const char* value = std::getenv(variable);
        if (value != nullptr && *value != '\0') {
            return mentions_utf8(value);
        }
    }
    return false;
}

double clean_fraction(double fraction) { return fraction > 0.0 ? std::min(fraction, 1.0) : 0.0; }  // NaN: 0

// Rounded down: 100 % is said only when it is so.
std::string percent_text(double fraction) { return fmt::format("{:3} %", static_cast<int>(std::floor(100.0 * fraction))); }

std::string ball_text(const Progress& progress) {
    return fmt::format("ball {:.3g} of {:.3g} mm", progress.worst_ball_radius, progress.epsilon);
}

// `columns` wide; with eighths of a column where the terminal has such characters.
std::string bar_text(double fraction, int columns, bool unicode) {
    const int eighths = static_cast<int>(std::floor(fraction * columns * 8.0));
    const int full = unicode ? eighths / 8 : static_cast<int>(std::floor(fraction * (columns - 2)));
    std::string done;
    for (int i = 0; i < full; ++i) {
        done += unicode ? "█" : "=";
    }
    int used = full;
    if (unicode && eighths % 8 != 0) {
        done += kEighths[static_cast<std::size_t>(eighths % 8)];
        ++used;
    }
    const int inner = unicode ? columns : columns - 2;
    const std::string rest(static_cast<std::size_t>(std::max(0, inner - used)), unicode ? ' ' : '.');
    return unicode ? done + rest : fmt::format("[{}{}]", done, rest);
}

// Most important first. All parts are ASCII: bytes are columns.
std::vector<std::string> parts_of(const Progress& progress, const std::string& time_left) {
    std::vector<std::string> parts = {percent_text(clean_fraction(progress.fraction_done))};
    if (!time_left.empty()) parts.push_back(time_left);
    parts.insert(parts.end(), {fmt::format("{} samples", progress.samples), fmt::format("{} probes", progress.probes), ball_text(progress),
                               fmt::format("{} open edges", progress.open_edges)});
    return parts;
}

}  // namespace

DisplayTraits DisplayTraits::of(int file_descriptor) {
    DisplayTraits traits;
    const char* terminal = std::getenv("TERM");
    const char* no_color = std::getenv("NO_COLOR");
    const bool dumb = terminal == nullptr || *terminal == '\0' || std::string_view(terminal) == "dumb";
    traits.rewrites = ::isatty(file_descriptor) == 1 && !dumb;
    traits.colours = traits.rewrites && (no_color == nullptr || *no_color == '\0');
    traits.unicode = traits.rewrites && locale_is_utf8();
    if (traits.rewrites) {
        traits.width = [file_descriptor] { return columns_of(file_descriptor); };
    }
    return traits;
}

ProgressDisplay::ProgressDisplay(ProgressSink sink, DisplayTraits traits, Clock clock)
    : sink_(std::move(sink)), traits_(std::move(traits)), clock_(std::move(clock)) {
    if (!clock_) {
        clock_ = [] { return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()); };
    }
}

ProgressDisplay::~ProgressDisplay() {
    if (status_.empty()) return;
    sink_.status({});
    sink_.line(status_);
}

void ProgressDisplay::update(const Progress& progress, const TimeLeft& time_left) {
    const std::chrono::nanoseconds now = clock_();
    const std::chrono::nanoseconds period =
        traits_.rewrites ? std::chrono::nanoseconds(kTerminalPeriod) : std::chrono::nanoseconds(kPipePeriod);
    if (last_drawn_ && now - *last_drawn_ < period) return;
    last_drawn_ = now;
    if (!traits_.rewrites) return sink_.line(text(progress, time_left));
    status_ = text(progress, time_left);
    sink_.status(status_);
}

void ProgressDisplay::finish(const Progress& progress) {
    if (traits_.rewrites) sink_.status({});
    status_.clear();
    sink_.line(text(progress, {}));
}

std::string ProgressDisplay::text(const Progress& progress, const TimeLeft& time_left) const {
    const std::string left = time_left.text();
    if (!traits_.rewrites) {
        const std::string line = fmt::format("{}", fmt::join(parts_of(progress, left), ", "));
        return line.substr(line.find_first_not_of(' '));
    }
    const int asked = traits_.width ? traits_.width() : 0;
    // A character in the last column makes some terminals wrap.
    return progress_line(progress, left, (asked > 0 ? asked : kDefaultColumns) - 1, traits_.unicode);
}

std::string progress_line(const Progress& progress, const std::string& time_left, int columns, bool unicode) {
    const std::vector<std::string> parts = parts_of(progress, time_left);
    if (static_cast<int>(parts.front().size()) > columns) {
        return {};
    }
    const int reserved = kMinBarColumns + static_cast<int>(kGap.size());
    std::string text = parts.front();
    for (std::size_t i = 1; i < parts.size(); ++i) {
        const std::string longer = fmt::format("{}{}{}", text, kGap, parts[i]);
        if (static_cast<int>(longer.size()) + reserved > columns) {
            break;
        }
        text = longer;
    }
    const int left = columns - static_cast<int>(text.size() + kGap.size());
    if (left < kMinBarColumns) {
        return text;
    }
    const std::string bar = bar_text(clean_fraction(progress.fraction_done), std::min(left, kMaxBarColumns), unicode);
    return fmt::format("{}{}{}", bar, kGap, text);
}

}  // namespace palpate
