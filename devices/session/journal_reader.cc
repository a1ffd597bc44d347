// Reading journal.jsonl; writing is journal_writer.cc.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "devices/session/internal/journal_words.h"
#include "devices/session/journal.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kAdvice =
    "; the file was changed after it was written: put back a copy of the session folder, take away what was added, or begin a new session";

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
    void finish() const {
        if (!json_.empty()) fail(fmt::format("\"{}\" is unknown", json_.begin().key()));
    }

private:
    std::string where_;
    Json json_;
};

JournalHeader read_header(Line& line) {
    if (!line.has("palpate")) line.fail("is no header of a journal");
    if (line.take("palpate") != Json("journal") || line.take("schema") != Json(2)) {
        line.fail("is a journal of another version of Palpate, which alone can take it up: begin a new session, or use that version");
    }
    JournalHeader header;
    header.config = line.take_text("config");
    header.start = line.take_place("start");
    header.machine = line.take_text("machine");
    return header;
}

JournalMove read_move(Line& line) {
    JournalMove move;
    move.target = line.take_place("move");
    move.pace = line.word(line.take("pace"), kPaceWords);
    move.result.outcome = line.word(line.take("outcome"), kOutcomeWords);
    move.result.position = line.take_place("at");
    move.rest = line.take_place("rest");
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
    if (!resumed.is_object() || resumed.size() != (resumed.contains("after_miss") ? 4 : 3)) line.fail("\"resumed\" is none");
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
    return resumption;
}

void read_line(Line& line, std::uint64_t number, Journal& journal) {
    if (journal.end) line.fail("follows the end of the session");
    if (line.has("move")) {
        journal.moves.push_back(read_move(line));
        journal.moves.back().line = number;
    } else if (line.has("resumed")) {
        journal.resumptions.push_back(read_resumption(line));
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
    std::size_t count = moves.size();
    while (count > 0 && (moves[count - 1].result.outcome == Outcome::reached || moves[count - 1].result.outcome == Outcome::vanished))
        --count;
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

Journal parse_journal(const std::string& text, const std::string& name) {
    Journal journal;
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
        line.finish();
        ++journal.lines;
        journal.bytes += end + 1;
        left.remove_prefix(end + 1);
    }
    journal.dropped_bytes = left.size();
    if (journal.lines == 0)
        throw JournalDamaged(fmt::format("{}:1: holds no session: it ended before its first line was written; begin a new one", name));
    return journal;
}

Journal read_journal(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw JournalError(fmt::format("{}: cannot be read: is there a session in that folder?", file.string()));
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    return parse_journal(text, file.string());
}

}  // namespace palpate
