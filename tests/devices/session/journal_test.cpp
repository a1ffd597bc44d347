#include "devices/session/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "devices/version.h"
#include "tests/random.h"

namespace palpate::journal_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class JournalFile : public ::testing::Test {
protected:
    JournalFile() {
        std::string name = (fs::temp_directory_path() / "palpate_journal_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        file_ = folder_ / "journal.jsonl";
    }
    ~JournalFile() override { fs::remove_all(folder_); }

    [[nodiscard]] std::string text() const {
        std::ifstream in(file_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }

    fs::path folder_;
    fs::path file_;
};

// In a process of its own: what it ends with.
int exit_code_of(const std::function<int()>& call) {
    const pid_t child = fork();
    if (child == 0) _exit([&]() noexcept { return call(); }());  // it must not go on with the tests
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Files of this process grow no further.
void limit_files(rlim_t bytes, rlim_t at_most) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, at_most};
    setrlimit(RLIMIT_FSIZE, &limit);
}

const JournalHeader kHeader{"0123abcd", {1.5, -2, 1e-17}, "Grbl 1.1h on \"/dev/tty\\0\""};

JournalMove random_move(Random& random) {
    const auto place = [&] { return random.in_box(Point::Constant(-1000), Point::Constant(1000)); };
    JournalMove move;
    move.target = place();
    move.pace = random.one_of(std::vector<Pace>{Pace::travel, Pace::probe, Pace::touch});
    move.result.outcome = random.one_of(
        std::vector<MoveResult::Outcome>{MoveResult::Outcome::reached, MoveResult::Outcome::contact, MoveResult::Outcome::failed});
    move.result.position = place();
    move.rest = place();
    if (random.below(3) == 0) move.datum = DatumMark{};
    if (move.datum && random.below(2) == 0) move.datum->touch = random.below(4);
    for (std::size_t k = random.below(3); k > 0; --k) {
        move.result.events.push_back(
            {random.one_of(std::vector<DeviceEvent::Kind>{DeviceEvent::Kind::spurious_trigger, DeviceEvent::Kind::scattered_touch,
                                                          DeviceEvent::Kind::repeated_command, DeviceEvent::Kind::reconnected}),
             place()});
    }
    return move;
}

std::vector<JournalMove> write_some(const fs::path& file, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    JournalWriter writer = JournalWriter::create(file, kHeader);
    std::vector<JournalMove> moves;
    for (std::size_t k = 0; k < count; ++k) {
        moves.push_back(random_move(random));
        moves.back().line = k + 1;
        EXPECT_EQ(writer.append(moves.back()), k + 1);
    }
    return moves;
}

TEST_F(JournalFile, WhatIsWrittenReadsBackBitForBit) {
    constexpr std::uint64_t kSeed = 3;
    SCOPED_TRACE(seed_text(kSeed));
    const auto moves = write_some(file_, 200, kSeed);
    const Journal journal = read_journal(file_);
    EXPECT_EQ(journal.header, kHeader);
    EXPECT_EQ(journal.moves, moves);
    EXPECT_EQ(journal.lines, 201U);
    EXPECT_EQ(journal.bytes, fs::file_size(file_));
    EXPECT_EQ(journal.dropped_bytes, 0U);
    EXPECT_FALSE(journal.end);
    EXPECT_EQ(journal.last_rest(), moves.back().rest);
}

TEST_F(JournalFile, ResumptionsWithdrawalsAndTheEndAreRead) {
    Random random(5);
    {
        JournalWriter writer = JournalWriter::create(file_, kHeader);
        for (int k = 0; k < 4; ++k) writer.append(random_move(random));
        writer.append_withdrawn(3);
        EXPECT_EQ(writer.append(JournalResumption{{2, 1}, {0.0125, -0.5}, 2, false, {{0.1, -2, 3}, {4, 5, 6e-7}}}), 6U);
        EXPECT_EQ(writer.append(JournalResumption{}), 7U);
        writer.append(random_move(random));
        writer.append(JournalEnd{0.25, 1e3});
    }
    const Journal journal = read_journal(file_);
    ASSERT_EQ(journal.moves.size(), 3U);
    EXPECT_EQ(journal.moves[1].line, 2U);
    EXPECT_EQ(journal.moves[2].line, 8U);
    EXPECT_EQ(journal.resumptions, (std::vector<JournalResumption>{{{2, 1}, {0.0125, -0.5}, 2, false, {{0.1, -2, 3}, {4, 5, 6e-7}}, 6},
                                                                   {{}, {}, 0, false, {}, 7}}));
    EXPECT_EQ(journal.end, (JournalEnd{0.25, 1e3}));
}

// Nothing but a touch shows that the probe works: what was found free since then is in doubt.
TEST(Journal, WhatTheLastTouchConfirmsEndsWithIt) {
    using Outcome = MoveResult::Outcome;
    Journal journal{kHeader};
    const auto add = [&](double x, Outcome outcome) { journal.moves.push_back({{x, 0, 0}, Pace::probe, {outcome, {x, 0, 0}}, {x, 0, 1}}); };
    add(1, Outcome::reached);
    EXPECT_EQ(journal.confirmed_moves(), 0U);
    EXPECT_EQ(journal.rest_before(journal.confirmed_moves()), kHeader.start);
    add(2, Outcome::contact);
    add(3, Outcome::failed);
    add(4, Outcome::vanished);
    add(5, Outcome::reached);
    EXPECT_EQ(journal.confirmed_moves(), 3U);
    EXPECT_EQ(journal.rest_before(journal.confirmed_moves()), Point(3, 0, 1));
    // A touch of the datum is part of a visit, which is made again.
    add(6, Outcome::contact);
    journal.moves.back().datum = DatumMark{0};
    EXPECT_EQ(journal.confirmed_moves(), 3U);
}

TEST_F(JournalFile, ALastLineThatIsTornAnywhereIsDroppedAndCutOff) {
    const auto moves = write_some(file_, 3, 7);
    const std::string whole = text();
    const std::size_t begin = whole.rfind('\n', whole.size() - 2) + 1;
    for (std::size_t length = begin; length < whole.size(); ++length) {
        std::ofstream(file_, std::ios::binary) << whole.substr(0, length);
        JournalWriter writer(file_);
        const Journal journal = writer.read();
        ASSERT_EQ(journal.moves.size(), 2U) << length;
        ASSERT_EQ(journal.dropped_bytes, length - begin);
        // And the session goes on as if it had never been.
        writer.append(moves[2]);
        ASSERT_EQ(text(), whole);
    }
}

TEST_F(JournalFile, EveryOtherDamageIsFoundWithItsLine) {
    write_some(file_, 3, 9);
    const std::string whole = text();
    std::size_t line = 1;
    for (std::size_t k = 0; k < whole.size(); ++k) {
        for (const char change : {'\x01', '\x10'}) {
            std::string damaged = whole;
            damaged[k] = static_cast<char>(damaged[k] ^ change);
            // Without its end the last line is torn, which is no damage.
            if (k + 1 == whole.size()) continue;
            try {
                (void)parse_journal(damaged, "j");
                ADD_FAILURE() << "byte " << k << " of line " << line << " was changed unnoticed";
            } catch (const JournalDamaged& error) {
                EXPECT_THAT(error.what(), HasSubstr("j:" + std::to_string(line) + ":"));
            }
        }
        line += whole[k] == '\n' ? 1 : 0;
    }
}

TEST_F(JournalFile, LinesThatAreMissingOrThereTwiceAreFound) {
    write_some(file_, 4, 9);
    std::vector<std::string> lines;
    std::istringstream in(text());
    for (std::string line; std::getline(in, line);) lines.push_back(line + "\n");
    const auto joined = [](const std::vector<std::string>& all) {
        std::string result;
        for (const auto& line : all) result += line;
        return result;
    };
    for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
        auto missing = lines;
        missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(k));
        EXPECT_THROW((void)parse_journal(joined(missing), "j"), JournalDamaged) << k;
        auto twice = lines;
        twice.insert(twice.begin() + static_cast<std::ptrdiff_t>(k), lines[k]);
        EXPECT_THROW((void)parse_journal(joined(twice), "j"), JournalDamaged) << k;
        auto swapped = lines;
        std::swap(swapped[k], swapped[k + 1]);
        EXPECT_THROW((void)parse_journal(joined(swapped), "j"), JournalDamaged) << k;
    }
    EXPECT_THROW((void)parse_journal("", "j"), JournalDamaged);
    EXPECT_THROW((void)parse_journal(lines[0] + "\n", "j"), JournalDamaged);
    EXPECT_THROW((void)parse_journal(std::string(100, '\0') + "\n", "j"), JournalDamaged);
}

// What is said of a journal that is refused.
std::string complaint_of(const std::string& journal) {
    try {
        (void)parse_journal(journal, "j");
    } catch (const JournalDamaged& error) {
        return error.what();
    }
    return "nothing";
}

// A line as a program would write it that knows other keys.
std::string line_of(const std::string& body) { return body + ",\"crc\":\"" + digest(body) + "\"}\n"; }

TEST_F(JournalFile, TheFirstLineTellsProgramConfigurationAndObject) {
    JournalHeader header = kHeader;
    header.version = "0.9.1";
    header.object_sha256 = std::string(64, 'a');
    (void)JournalWriter::create(file_, header);
    EXPECT_EQ(read_journal(file_).header, header);
    EXPECT_THAT(text(), ::testing::StartsWith(R"({"n":0,"palpate":"journal","schema":2,"version":"0.9.1","config":"0123abcd",)"));
    EXPECT_THAT(text(), HasSubstr(",\"object\":\"" + header.object_sha256 + "\","));
}

TEST(Journal, OneThatTellsNoVersionIsRead) {
    const Journal journal =
        parse_journal(line_of(R"({"n":0,"palpate":"journal","schema":2,"config":"0123abcd","start":[0,0,1],"machine":"m")"), "j");
    EXPECT_EQ(journal.header, (JournalHeader{"0123abcd", {0, 0, 1}, "m"}));
}

TEST(Journal, OfANewerOrOlderProgramSaysWhichOneReadsIt) {
    const std::string own(program_version());
    const std::string newer = complaint_of(line_of(R"({"n":0,"palpate":"journal","schema":3,"version":"7.1.0","other":1)"));
    EXPECT_THAT(newer, ::testing::StartsWith("j:1: was written by a newer Palpate, version 7.1.0, with schema 3"));
    EXPECT_THAT(newer, HasSubstr("this one, version " + own + ", knows schema 2: go on with that version, or begin a new session"));
    EXPECT_THAT(newer, ::testing::Not(HasSubstr("was changed")));
    EXPECT_THAT(complaint_of(line_of(R"({"n":0,"palpate":"journal","schema":30,"version":[7])")),
                HasSubstr("was written by a newer Palpate, with schema 30;"));
    EXPECT_THAT(complaint_of(line_of(R"({"n":0,"palpate":"journal","schema":1,"config":"c","start":[0,0,1],"machine":"m")")),
                HasSubstr("was written by an earlier Palpate, with schema 1;"));
    // No number that any Palpate wrote.
    EXPECT_THAT(complaint_of(line_of(R"({"n":0,"palpate":"journal","schema":"two")")), HasSubstr("put back a copy"));
    EXPECT_THAT(complaint_of(line_of(R"({"n":0,"palpate":"journal","schema":-2)")), HasSubstr("put back a copy"));
}

// A further key is no new schema.
TEST(Journal, AKeyThatOnlyAnotherVersionKnowsIsToldFromDamage) {
    const auto journal = [](const std::string& version) {
        return line_of(R"({"n":0,"palpate":"journal","schema":2,"version":")" + version +
                       R"(","config":"c","start":[0,0,1],"machine":"m","weather":"fine")");
    };
    const std::string foreign = complaint_of(journal("7.1.0"));
    EXPECT_THAT(foreign, ::testing::StartsWith("j:1: \"weather\" is unknown to this Palpate"));
    EXPECT_THAT(foreign, HasSubstr("version 7.1.0 wrote the journal: go on with that version"));
    EXPECT_THAT(complaint_of(journal(std::string(program_version()))), HasSubstr("\"weather\" is unknown; the file was changed"));
}

TEST_F(JournalFile, ASecondProcessIsRefused) {
    JournalWriter writer = JournalWriter::create(file_, kHeader);
    const int code = exit_code_of([&] {
        try {
            const JournalWriter second(file_);
        } catch (const JournalError& error) {
            return std::string(error.what()).find("another process") != std::string::npos ? 7 : 8;
        }
        return 0;
    });
    EXPECT_EQ(code, 7);
}

TEST_F(JournalFile, ASessionIsNotWrittenOverAnother) {
    write_some(file_, 1, 1);
    const std::string before = text();
    EXPECT_THROW((void)JournalWriter::create(file_, kHeader), JournalError);
    EXPECT_EQ(text(), before);
}

// In a process of its own, whose files may not grow beyond a limit: a disk that is full.
TEST_F(JournalFile, ADiskThatIsFullLeavesTheJournalWhole) {
    write_some(file_, 3, 11);
    const std::string before = text();
    const int code = exit_code_of([&] {
        JournalWriter writer(file_);
        (void)writer.read();
        limit_files(before.size() + 40, before.size() + 40);
        Random random(1);
        try {
            writer.append(random_move(random));
        } catch (const JournalError& error) {
            return std::string(error.what()).find("journal.jsonl: cannot be written") != std::string::npos ? 7 : 8;
        }
        return 0;
    });
    EXPECT_EQ(code, 7);
    EXPECT_EQ(text(), before);
    EXPECT_EQ(read_journal(file_).moves.size(), 3U);
}

TEST_F(JournalFile, AfterAWriteThatFailedNothingMoreIsWritten) {
    write_some(file_, 1, 11);
    const std::string before = text();
    const int code = exit_code_of([&] {
        JournalWriter writer(file_);
        (void)writer.read();
        limit_files(before.size() + 40, RLIM_INFINITY);
        Random random(1);
        EXPECT_THROW(writer.append(random_move(random)), JournalError);
        limit_files(RLIM_INFINITY, RLIM_INFINITY);  // room again
        EXPECT_THROW(writer.append(random_move(random)), JournalError) << "there is a gap now";
        return ::testing::Test::HasFailure() ? 1 : 7;
    });
    EXPECT_EQ(code, 7);
    EXPECT_EQ(text(), before);
}

TEST_F(JournalFile, NumbersKeepTheirSignAndThoseThatAreNoneAreRefused) {
    JournalMove move;
    move.target = {-0.0, 0.0, 1e-320};
    JournalWriter writer = JournalWriter::create(file_, kHeader);
    writer.append(move);
    EXPECT_TRUE(std::signbit(read_journal(file_).moves[0].target.x()));
    EXPECT_FALSE(std::signbit(read_journal(file_).moves[0].target.y()));
    const std::string before = text();
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        move.rest.z() = bad;
        EXPECT_THROW(writer.append(move), BadAnswer);
    }
    EXPECT_EQ(text(), before);
}

TEST_F(JournalFile, NothingIsMadeWhereThereIsNoSession) {
    EXPECT_THROW(JournalWriter{file_}, JournalError);
    EXPECT_FALSE(fs::exists(file_));
}

TEST_F(JournalFile, AFileThatIsNotThereIsSaid) {
    try {
        (void)read_journal(folder_ / "nothing.jsonl");
        FAIL();
    } catch (const JournalError& error) {
        EXPECT_THAT(error.what(), HasSubstr("nothing.jsonl"));
    }
    EXPECT_THROW((void)JournalWriter::create(folder_ / "no_folder" / "j", kHeader), JournalError);
}

TEST_F(JournalFile, AnHourOfMovesReadsInNoTime) {
    std::string all;
    {
        write_some(file_, 1, 2);
        std::istringstream in(text());
        std::string header;
        std::string move;
        std::getline(in, header);
        std::getline(in, move);
        all = header + "\n";
        const std::string body = move.substr(move.find(','), move.rfind(",\"crc\"") - move.find(','));
        for (int k = 1; k <= 20'000; ++k) {
            const std::string line = "{\"n\":" + std::to_string(k) + body;
            all += line + ",\"crc\":\"" + digest(line) + "\"}\n";
        }
    }
    EXPECT_EQ(parse_journal(all, "j").moves.size(), 20'000U);
}

}  // namespace
}  // namespace palpate::journal_test
