// Reading journal.jsonl; writing is journal_writer.cc.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "devices/session/internal/journal_words.h"
#include "devices/session/journal.h"
#include "devices/version.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kAdvice =
    "; the file was changed after it was written: put back a copy of the session folder, take away what was added, or go on from what is "
    "before that (palpate resume DIR --salvage)";

// One line, whose keys are taken one after the other; what is left over is an error.
class Line {
public:
    Line(const std::string& name, std::uint64_t number, std::string_view text) : where_(fmt::format("{}:{}", name, number + 1)) {
        // The check first: what it covers needs no suspicion, but for a writer that is not ours.
        constexpr std::string_view kMark = R"(,"crc":")";
        const std::size_t mark = text.rfind(kMark);
        if (mark == std::string_view::npos ||
            text.substr(mark) != fmt::format("{}{}\"}}", kMark, digest(std::string(text.substr(0, mark))))) {
            fail("the check sum does not fit the line");
        }
        json_ = Json::parse(text, nullptr, false);
        if (!json_.is_object()) fail("is no JSON object");
        json_.erase("crc");
        if (take("n") != Json(number)) fail(fmt::format("is not line number {}: lines are missing, or there twice", number));
    }

    [[noreturn]] void fail(const std::string& what) const { throw JournalDamaged(fmt::format("{}: {}{}", where_, what, kAdvice)); }
    // The line is as it was written, by another version.
    [[noreturn]] void refuse(const std::string& what) const {
        throw JournalDamaged(fmt::format("{}: {}: go on with that version, or begin a new session", where_, what));
    }
    [[nodiscard]] bool has(const char* key) const { return json_.contains(key); }
    Json take(const char* key) {
        const auto found = json_.find(key);
        if (found == json_.end()) fail(fmt::format("\"{}\" is missing", key));
        Json value = std::move(*found);
        json_.erase(found);
        return value;
    }
    Point take_place(const char* key) { return place(take(key)); }
    std::string take_text(const char* key) {
        const Json value = take(key);
        if (!value.is_string()) fail(fmt::format("\"{}\" is no text", key));
        return value.get<std::string>();
    }
    // Empty if it is missing.
    std::string take_text_if_any(const char* key) { return has(key) ? take_text(key) : ""; }
    std::uint64_t take_line(const char* key) {
        const Json value = take(key);
        if (!value.is_number_unsigned()) fail(fmt::format("\"{}\" is no line number", key));
        return value.get<std::uint64_t>();
    }
    double take_number(Json& from, const char* key) {
        const auto found = from.find(key);
        if (found == from.end() || !found->is_number()) fail(fmt::format("\"{}\" is no number", key));
        return found->get<double>();
    }
    [[nodiscard]] Point place(const Json& value) const {
        if (!value.is_array() || value.size() != 3) fail("a position is not three numbers");
        Point p;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!value[axis].is_number()) fail("a position is not three numbers");
            p[static_cast<Eigen::Index>(axis)] = value[axis].get<double>();
        }
        return p;
    }
    template <typename Value, std::size_t N>
    [[nodiscard]] Value word(const Json& json, const std::array<std::pair<Value, std::string_view>, N>& words) const {
        for (const auto& [value, word] : words) {
            if (json == Json(word)) return value;
        }
        fail(fmt::format("{} is no word that is known here", json.dump()));
    }
    // `writer`: the version of the program that began the journal. Others may have added keys without another schema.
    void finish(const std::string& writer) const {
        if (json_.empty()) return;
        const std::string& key = json_.begin().key();
        if (writer.empty() || writer == program_version()) fail(fmt::format("\"{}\" is unknown", key));
        refuse(fmt::format("\"{}\" is unknown to this Palpate, version {}; version {} wrote the journal", key, program_version(), writer));
    }

private:
    std::string where_;
    Json json_;
};

// Nothing is taken for granted about a line of another schema.
void check_schema(Line& line) {
    const Json schema = line.take("schema");
    if (!schema.is_number_unsigned()) line.fail("\"schema\" is no number");
    const auto number = schema.get<std::uint64_t>();
    if (number == kJournalSchema) return;
    const Json version = line.has("version") ? line.take("version") : Json();
    line.refuse(fmt::format("was written by {} Palpate{}, with schema {}; this one, version {}, knows schema {}",
                            number > kJournalSchema ? "a newer" : "an earlier",
                            version.is_string() ? fmt::format(", version {}", version.get<std::string>()) : "", number, program_version(),
                            kJournalSchema));
}

JournalHeader read_header(Line& line) {
    if (!line.has("palpate") || line.take("palpate") != Json("journal")) line.fail("is no header of a journal");
    check_schema(line);
    JournalHeader header;
    header.version = line.take_text_if_any("version");
    header.config = line.take_text("config");
    header.start = line.take_place("start");
    header.machine = line.take_text("machine");
    header.object_sha256 = line.take_text_if_any("object");
    return header;
}

JournalMove read_move(Line& line) {
    JournalMove move;
    move.target = line.take_place("move");
    move.pace = line.word(line.take("pace"), kPaceWords);
    move.result.outcome = line.word(line.take("outcome"), kOutcomeWords);
    move.result.position = line.take_place("at");
    move.rest = line.take_place("rest");
    if (line.has("datum")) {
        const Json datum = line.take("datum");
        if (!datum.is_number_unsigned() && datum != Json(kDatumWay)) line.fail("\"datum\" is no touch of it and no way there");
        move.datum = DatumMark{};
        if (datum.is_number_unsigned()) move.datum->touch = datum.get<std::uint64_t>();
    }
    if (!line.has("events")) return move;
    const Json events = line.take("events");
    if (!events.is_array()) line.fail("\"events\" is no list");
    for (const Json& event : events) {
        if (!event.is_object() || event.size() != 2 || !event.contains("kind") || !event.contains("at")) line.fail("an event is none");
        move.result.events.push_back({line.word(event["kind"], kEventWords), line.place(event["at"])});
    }
    return move;
}

JournalResumption read_resumption(Line& line) {
    const Json resumed = line.take("resumed");
    JournalResumption resumption;
    const std::size_t others = (resumed.contains("after_miss") ? 1U : 0U) + (resumed.contains("datum") ? 1U : 0U);
    if (!resumed.is_object() || resumed.size() != 3 + others) line.fail("\"resumed\" is none");
    for (const char* list : {"contacts", "offsets"}) {
        if (!resumed.contains(list) || !resumed[list].is_array()) line.fail(fmt::format("\"resumed\" has no list of {}", list));
    }
    for (const Json& contact : resumed["contacts"]) {
        if (!contact.is_number_unsigned()) line.fail("a contact is no line number");
        resumption.contacts.push_back(contact.get<std::uint64_t>());
    }
    for (const Json& offset : resumed["offsets"]) {
        if (!offset.is_number()) line.fail("an offset is no number");
        resumption.offsets_mm.push_back(offset.get<double>());
    }
    if (resumption.contacts.size() != resumption.offsets_mm.size()) line.fail("has not one offset for every contact");
    if (!resumed.contains("directions") || !resumed["directions"].is_number_unsigned() || resumed["directions"] > 3)
        line.fail("\"directions\" is no number");
    resumption.directions = resumed["directions"].get<int>();
    resumption.after_miss = resumed.contains("after_miss");
    if (!resumed.contains("datum")) return resumption;
    if (!resumed["datum"].is_array()) line.fail("\"datum\" is no list of places");
    for (const Json& touched : resumed["datum"]) resumption.datum.push_back(line.place(touched));
    return resumption;
}

void read_line(Line& line, std::uint64_t number, Journal& journal) {
    journal.is_raised_last = false;
    if (line.has("raised")) {
        Json raised = line.take("raised");
        if (!raised.is_object() || raised.size() != 1 || !raised.contains("config") || !raised["config"].is_string())
            line.fail("\"raised\" is none");
        journal.raised.push_back(raised["config"].get<std::string>());
        journal.is_raised_last = true;
        journal.end.reset();
        return;
    }
    if (journal.end) line.fail("follows the end of the session");
    if (line.has("move")) {
        journal.moves.push_back(read_move(line));
        journal.moves.back().line = number;
    } else if (line.has("resumed")) {
        journal.resumptions.push_back(read_resumption(line));
        journal.resumptions.back().line = number;
    } else if (line.has("withdrawn")) {
        const std::uint64_t first = line.take_line("withdrawn");
        if (first == 0 || first >= number) line.fail("withdraws lines that are not there");
        while (!journal.moves.empty() && journal.moves.back().line >= first) journal.moves.pop_back();
    } else if (line.has("end")) {
        Json end = line.take("end");
        if (!end.is_object() || end.size() != 2) line.fail("\"end\" is none");
        journal.end = JournalEnd{line.take_number(end, "planner"), line.take_number(end, "oracle")};
    } else {
        line.fail("is of no kind that is known here");
    }
}

}  // namespace

std::size_t Journal::confirmed_moves() const {
    using Outcome = MoveResult::Outcome;
    const auto shows_nothing = [](const JournalMove& move) {
        return move.datum || move.result.outcome == Outcome::reached || move.result.outcome == Outcome::vanished;
    };
    std::size_t count = moves.size();
    while (count > 0 && shows_nothing(moves[count - 1])) --count;
    return count;
}

std::optional<std::size_t> Journal::last_passed(const Point& touched, double tolerance, std::size_t count) const {
    for (std::size_t k = count; k-- > 0;) {
        const JournalMove& move = moves[k];
        const Point& stop = move.result.position;
        // Beside where it was stopped it did not pass.
        if (move.pace != Pace::probe || (move.result.outcome != MoveResult::Outcome::reached && (stop - touched).norm() <= tolerance))
            continue;
        if (distance_to({rest_before(k), stop}, touched) <= tolerance) return k;
    }
    return std::nullopt;
}

bool Journal::fits(const std::string& config_digest) const {
    return header.config == config_digest || std::ranges::find(raised, config_digest) != raised.end();
}

namespace {

// Reads into `journal` line by line: after a throw it holds what is before the damage.
void read_lines(const std::string& text, const std::string& name, Journal& journal) {
    std::string_view left = text;
    while (true) {
        const std::size_t end = left.find('\n');
        if (end == std::string_view::npos) break;
        Line line(name, journal.lines, left.substr(0, end));
        if (journal.lines == 0) {
            journal.header = read_header(line);
        } else {
            read_line(line, journal.lines, journal);
        }
        line.finish(journal.header.version);
        ++journal.lines;
        journal.bytes += end + 1;
        left.remove_prefix(end + 1);
    }
    journal.dropped_bytes = left.size();
    if (journal.lines == 0)
        throw JournalDamaged(fmt::format("{}:1: holds no session: it ended before its first line was written; begin a new one", name));
}

std::string without_advice(const std::string& damage) { return damage.substr(0, damage.find(kAdvice)); }

// Of the whole lines of a text, wherever they stand.
std::vector<std::string> raised_in(std::string_view text, const std::string& name) {
    std::vector<std::string> raised;
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
        const std::string_view whole = text.substr(0, end);
        text.remove_prefix(end + 1);
        // Its number is what it says: which one that should be, nobody knows behind a damage.
        const Json json = Json::parse(whole, nullptr, false);
        if (!json.is_object() || !json.contains("raised") || !json.contains("n") || !json["n"].is_number_unsigned()) continue;
        Journal alone;
        try {
            Line line(name, json["n"].get<std::uint64_t>(), whole);
            read_line(line, 1, alone);
            raised.insert(raised.end(), alone.raised.begin(), alone.raised.end());
        } catch (const JournalDamaged&) {
            continue;
        }
    }
    return raised;
}

bool sync(const std::filesystem::path& file_or_folder) {
    const int file = ::open(file_or_folder.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_durable = file >= 0 && ::fsync(file) == 0;
    if (file >= 0) ::close(file);
    return is_durable;
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw JournalError(fmt::format("{}: cannot be read: is there a session in that folder?", file.string()));
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

Journal parse_journal(const std::string& text, const std::string& name) {
    Journal journal;
    read_lines(text, name, journal);
    return journal;
}

Journal read_journal(const std::filesystem::path& file) { return parse_journal(text_of(file), file.string()); }

std::optional<JournalCut> salvage_journal(const std::filesystem::path& file) {
    const std::string text = text_of(file);
    Journal good;
    JournalCut cut;
    try {
        read_lines(text, file.string(), good);
        return std::nullopt;
    } catch (const JournalDamaged& damage) {
        // Nothing is before it that could be gone on from.
        if (good.lines == 0) throw JournalDamaged(without_advice(damage.what()) + "; nothing of it can be salvaged: put back a copy");
        cut.damage = without_advice(damage.what());
    }
    cut.lines = good.lines;
    cut.lost = static_cast<std::uint64_t>(std::ranges::count(text, '\n')) - good.lines;
    const std::string stem = (file.parent_path() / file.stem()).string();
    for (int k = 1; cut.kept.empty() || std::filesystem::exists(cut.kept); ++k) cut.kept = fmt::format("{}.damaged{}.jsonl", stem, k);
    cut.raised = raised_in(std::string_view(text).substr(good.bytes), file.string());
    // The whole is on the disk under its new name before anything is cut off.
    std::error_code error;
    std::filesystem::copy_file(file, cut.kept, error);
    if (!error && !(sync(cut.kept) && sync(file.parent_path().empty() ? "." : file.parent_path())))
        error = std::error_code(errno, std::generic_category());
    if (!error) std::filesystem::resize_file(file, good.bytes, error);
    if (error) throw JournalError(fmt::format("{}: cannot be salvaged: {}", file.string(), error.message()));
    return cut;
}

}  // namespace palpate
