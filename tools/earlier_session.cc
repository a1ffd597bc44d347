#include "tools/earlier_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "devices/errors.h"
#include "devices/session/journal.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(separator, begin), text.size());
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

// Without their ends; the last may lack one.
std::vector<std::string_view> lines_of(std::string_view text) {
    std::vector<std::string_view> lines = split(text, '\n');
    for (std::string_view& line : lines) {
        if (line.ends_with('\r')) line.remove_suffix(1);
    }
    if (text.ends_with('\n')) lines.pop_back();
    return lines;
}

std::optional<double> number_in(std::string_view field) {
    double value = 0;
    const auto [last, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc{} || last != field.data() + field.size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

constexpr std::array<std::string_view, 6> kCoordinates = {"x", "y", "z", "from_x", "from_y", "from_z"};

void add_contacts(std::vector<Touch>& touches, const Journal& journal, const fs::path& file) {
    for (std::size_t k = 0; k < journal.moves.size(); ++k) {
        const JournalMove& move = journal.moves[k];
        if (move.datum) {
            throw SetupError(
                fmt::format("{}:{}: touches machine.datum, and what its drift was is known at the session's end only: resume the session "
                            "first, then go on",
                            file.string(), move.line + 1));
        }
        if (move.result.outcome != MoveResult::Outcome::contact || move.pace == Pace::travel) continue;
        touches.push_back({move.result.position, journal.rest_before(k), Touch::Role::crossing, std::nullopt});
    }
}

}  // namespace

std::string earlier_touches_in(const fs::path& folder) {
    std::error_code ignored;
    const fs::path table = folder / kTouchesFile;
    const fs::path journal_file = folder / kJournalFile;
    std::optional<Journal> journal;
    if (fs::is_regular_file(journal_file, ignored)) journal = read_journal(journal_file);
    // What stopped has touched more than an older table says.
    if (fs::is_regular_file(table, ignored) && (!journal || (journal->end && !journal->is_raised_last))) return read_file(table);
    if (!journal) {
        throw SetupError(
            fmt::format("{}: holds neither {} nor {}; give the folder of a session", folder.string(), kTouchesFile, kJournalFile));
    }
    std::vector<Touch> touches;
    if (const fs::path before = folder / kEarlierFile; fs::is_regular_file(before, ignored)) {
        for (const EarlierTouch& touch : parse_touches(read_file(before), before.string())) {
            touches.push_back({touch.position, touch.from, Touch::Role::earlier, std::nullopt});
            if (touch.is_sample) touches.back().sample = static_cast<std::uint32_t>(touches.size() - 1);
        }
    }
    add_contacts(touches, *journal, journal_file);
    return to_csv(touches);
}

std::vector<EarlierTouch> parse_touches(const std::string& csv, const std::string& name) {
    const std::vector<std::string_view> lines = lines_of(csv);
    const std::vector<std::string_view> header = split(lines.front(), ',');
    const auto column = [&](std::string_view wanted) {
        const auto found = std::ranges::find(header, wanted);
        return found == header.end() ? std::optional<std::size_t>() : static_cast<std::size_t>(found - header.begin());
    };
    std::array<std::size_t, kCoordinates.size()> at{};
    for (std::size_t k = 0; k < at.size(); ++k) {
        const auto found = column(kCoordinates.at(k));
        if (!found) {
            throw SetupError(fmt::format("{}:1: has no column {}; the first line of a touches.csv names its columns, {} among them", name,
                                         kCoordinates.at(k), fmt::join(kCoordinates, ",")));
        }
        at.at(k) = *found;
    }
    const auto sample = column("sample");
    const auto tag = column("tag");
    std::vector<EarlierTouch> touches;
    for (std::size_t line = 1; line < lines.size(); ++line) {
        const std::vector<std::string_view> fields = split(lines[line], ',');
        if (fields.size() != header.size())
            throw SetupError(
                fmt::format("{}:{}: has {} fields, not the {} of its first line", name, line + 1, fields.size(), header.size()));
        std::array<double, kCoordinates.size()> values{};
        for (std::size_t k = 0; k < at.size(); ++k) {
            const auto value = number_in(fields[at.at(k)]);
            if (!value) {
                throw SetupError(fmt::format("{}:{}: {} is \"{}\"; allowed: a finite number (mm)", name, line + 1, kCoordinates.at(k),
                                             fields[at.at(k)]));
            }
            values.at(k) = *value;
        }
        // Of those nothing was touched.
        if (tag && (fields[*tag] == "fixture" || fields[*tag] == "untouched")) continue;
        touches.push_back({{values[0], values[1], values[2]}, {values[3], values[4], values[5]}, sample && !fields[*sample].empty()});
    }
    if (touches.empty()) throw SetupError(fmt::format("{}: has no touches", name));
    return touches;
}

SessionConfig with_earlier_touches(SessionConfig config) {
    const fs::path& file = config.earlier.file;
    if (file.empty()) return config;
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) {
        throw SetupError(
            fmt::format("{}: does not exist, and probing.earlier names it: give the touches.csv of an earlier session, or take the key out",
                        file.string()));
    }
    config.probing.earlier = parse_touches(read_file(file), file.string());
    return config;
}

}  // namespace palpate
