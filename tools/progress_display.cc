#include "tools/progress_display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

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
constexpr std::string_view kEraseToEnd = "\x1b[K";
constexpr std::string_view kBarColour = "\x1b[36m";
constexpr std::string_view kPlainColour = "\x1b[0m";

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

int columns_of(int file_descriptor) {
    winsize size{};
    return ::ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 ? int{size.ws_col} : 0;
}

double clean_fraction(double fraction) { return fraction > 0.0 ? std::min(fraction, 1.0) : 0.0; }  // NaN: 0

// Rounded down: 100 % is said only when it is so.
std::string percent_text(double fraction) { return fmt::format("{:3} %", static_cast<int>(std::floor(100.0 * fraction))); }

std::string ball_text(const Progress& progress) {
    return fmt::format("ball {:.3g} of {:.3g} mm", progress.worst_ball_radius, progress.epsilon);
}

// `columns` wide; with eighths of a column where the terminal has such characters.
std::string bar_text(double fraction, int columns, bool unicode, bool colours) {
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
    if (colours) {
        done = fmt::format("{}{}{}", kBarColour, done, kPlainColour);
    }
    const int inner = unicode ? columns : columns - 2;
    const std::string rest(static_cast<std::size_t>(std::max(0, inner - used)), unicode ? ' ' : '.');
    return unicode ? done + rest : fmt::format("[{}{}]", done, rest);
}

// Most important first. All parts are ASCII: bytes are columns.
std::vector<std::string> parts_of(const Progress& progress) {
    return {percent_text(clean_fraction(progress.fraction_done)), fmt::format("{} samples", progress.samples),
            fmt::format("{} probes", progress.probes), ball_text(progress), fmt::format("{} open edges", progress.open_edges)};
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

ProgressDisplay::ProgressDisplay(std::ostream& out, DisplayTraits traits, Clock clock)
    : out_(out), traits_(std::move(traits)), clock_(std::move(clock)) {
    if (!clock_) {
        clock_ = [] { return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()); };
    }
}

ProgressDisplay::~ProgressDisplay() {
    try {
        if (line_open_) {
            out_ << '\n' << std::flush;
        }
    } catch (const std::exception&) {
        // The stream was told to throw; a destructor has nobody to tell.
        line_open_ = false;
    }
}

void ProgressDisplay::update(const Progress& progress) {
    const std::chrono::nanoseconds now = clock_();
    const std::chrono::nanoseconds period =
        traits_.rewrites ? std::chrono::nanoseconds(kTerminalPeriod) : std::chrono::nanoseconds(kPipePeriod);
    if (!last_drawn_ || now - *last_drawn_ >= period) {
        last_drawn_ = now;
        draw(progress);
    }
}

void ProgressDisplay::clear() {
    if (line_open_) {
        out_ << '\r' << kEraseToEnd << std::flush;
        line_open_ = false;
    }
    if (traits_.rewrites) {
        last_drawn_.reset();
    }
}

void ProgressDisplay::finish(const Progress& progress) {
    draw(progress);
    if (line_open_) {
        out_ << '\n' << std::flush;
        line_open_ = false;
    }
    last_drawn_ = clock_();
}

void ProgressDisplay::draw(const Progress& progress) {
    if (!traits_.rewrites) {
        std::string line;
        for (const std::string& part : parts_of(progress)) {
            line += (line.empty() ? "" : ", ") + part;
        }
        out_ << line.substr(line.find_first_not_of(' ')) << '\n' << std::flush;
        return;
    }
    const int asked = traits_.width ? traits_.width() : 0;
    // A character in the last column makes some terminals wrap.
    const int columns = (asked > 0 ? asked : kDefaultColumns) - 1;
    out_ << '\r' << progress_line(progress, columns, traits_.unicode, traits_.colours) << kEraseToEnd << std::flush;
    line_open_ = true;
}

std::string progress_line(const Progress& progress, int columns, bool unicode, bool colours) {
    const std::vector<std::string> parts = parts_of(progress);
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
    const std::string bar = bar_text(clean_fraction(progress.fraction_done), std::min(left, kMaxBarColumns), unicode, colours);
    return fmt::format("{}{}{}", bar, kGap, text);
}

}  // namespace palpate
